"""Accelerometers as geometry_msgs/AccelStamped for a corner."""

from __future__ import annotations

from functools import partial

from er_common.topics import ACCELERATION

from er_bringup.nodes.adapter import entry, executable
from er_bringup.programs import ACCEL_ADAPTER
from er_bringup.ros_adapter import ACCEL, AdapterCore, AdapterParameters

NODE = executable(
    ACCEL_ADAPTER, AdapterParameters, partial(AdapterCore, sensors=ACCEL), ACCEL, ACCELERATION
)
main = entry(NODE)

if __name__ == "__main__":
    main()
