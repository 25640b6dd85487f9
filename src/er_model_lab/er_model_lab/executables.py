"""Entry points of the package's nodes, light: see `er_ros_common.entry`."""

from er_ros_common.entry import program

recorder = program("er_model_lab.nodes.recorder")
