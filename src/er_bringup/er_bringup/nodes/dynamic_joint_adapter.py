"""The joint of a strut as control_msgs/DynamicJointState for a corner; the message package is that of ros2_control."""

from __future__ import annotations

import sys
from functools import partial

from er_common.topics import DEFLECTION
from er_ros_common.spin import run

from er_bringup.nodes.adapter import executable
from er_bringup.programs import DYNAMIC_JOINT_ADAPTER
from er_bringup.ros_joint_states import DYNAMIC_STATES, JointStateCore, JointStateParameters

NODE = executable(
    DYNAMIC_JOINT_ADAPTER,
    JointStateParameters,
    partial(JointStateCore, states=DYNAMIC_STATES),
    (DYNAMIC_STATES,),
    DEFLECTION,
)


def main() -> None:
    """Entry point of the executable; `ModuleNotFoundError` where the message package is not there."""
    if not {"-h", "--help"} & {*sys.argv}:
        _ = DYNAMIC_STATES.type
    sys.exit(run(NODE.make, NODE.card))


if __name__ == "__main__":
    main()
