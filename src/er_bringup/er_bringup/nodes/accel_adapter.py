"""Accelerometers as geometry_msgs/AccelStamped for a corner."""

from __future__ import annotations

import sys
from functools import partial

from er_common.topics import ACCELERATION
from er_ros_common.spin import run

from er_bringup.nodes.adapter import executable
from er_bringup.programs import ACCEL_ADAPTER
from er_bringup.ros_adapter import ACCEL, AdapterCore, AdapterParameters

NODE = executable(
    ACCEL_ADAPTER, AdapterParameters, partial(AdapterCore, sensors=ACCEL), ACCEL, ACCELERATION
)


def main() -> None:
    """Entry point of the executable."""
    sys.exit(run(NODE.make, NODE.card))


if __name__ == "__main__":
    main()
