"""Accelerometers as sensor_msgs/Imu for a corner."""

from __future__ import annotations

from functools import partial

from er_common.topics import ACCELERATION

from er_bringup.nodes.adapter import entry, executable
from er_bringup.programs import IMU_ADAPTER
from er_bringup.ros_adapter import IMU, AdapterCore, ImuParameters

NODE = executable(IMU_ADAPTER, ImuParameters, partial(AdapterCore, sensors=IMU), IMU, ACCELERATION)
main = entry(NODE)

if __name__ == "__main__":
    main()
