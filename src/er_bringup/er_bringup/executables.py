"""Entry points of the package's nodes, light: see `er_ros_common.entry`."""

from er_ros_common.entry import program

composed = program("er_bringup.ros_composed")
ros2_control_joint = program("er_bringup.nodes.ros2_control_joint")
