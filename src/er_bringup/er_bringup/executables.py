"""Entry points of the programs in `programs.py`, light: see `er_ros_common.entry`."""

from er_ros_common.entry import starter

__getattr__ = starter("er_bringup")
