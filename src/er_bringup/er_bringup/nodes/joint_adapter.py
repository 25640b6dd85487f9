"""The joint of a strut as sensor_msgs/JointState for a corner."""

from __future__ import annotations

from functools import partial

from er_common.topics import DEFLECTION

from er_bringup.nodes.adapter import entry, executable
from er_bringup.programs import JOINT_ADAPTER
from er_bringup.ros_joint_states import STATES, JointStateCore, JointStateParameters

NODE = executable(
    JOINT_ADAPTER,
    JointStateParameters,
    partial(JointStateCore, states=STATES),
    (STATES,),
    DEFLECTION,
)
main = entry(NODE)

if __name__ == "__main__":
    main()
