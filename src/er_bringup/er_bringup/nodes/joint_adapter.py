"""The joint of a strut as sensor_msgs/JointState for a corner."""

from __future__ import annotations

import sys
from functools import partial

from er_common.topics import DEFLECTION
from er_ros_common.spin import run

from er_bringup.nodes.adapter import executable
from er_bringup.programs import JOINT_ADAPTER
from er_bringup.ros_joint_states import STATES, JointStateCore, JointStateParameters

NODE = executable(
    JOINT_ADAPTER,
    JointStateParameters,
    partial(JointStateCore, states=STATES),
    (STATES,),
    DEFLECTION,
)


def main() -> None:
    """Entry point of the executable."""
    sys.exit(run(NODE.make, NODE.card))


if __name__ == "__main__":
    main()
