"""Entry points of the package's nodes, light: see `er_ros_common.entry`."""

from er_ros_common.entry import program

ftc_controller = program("er_ftc_controller.nodes.ftc_controller")
skyhook_controller = program("er_ftc_controller.nodes.skyhook_controller")
