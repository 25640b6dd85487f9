"""The joint of a strut as control_msgs/DynamicJointState for a corner; the message package is that of ros2_control."""

from __future__ import annotations

from functools import partial

from er_common.topics import DEFLECTION

from er_bringup.nodes.adapter import entry, executable
from er_bringup.programs import DYNAMIC_JOINT_ADAPTER
from er_bringup.ros_joint_states import DYNAMIC_STATES, JointStateCore, JointStateParameters

NODE = executable(
    DYNAMIC_JOINT_ADAPTER,
    JointStateParameters,
    partial(JointStateCore, states=DYNAMIC_STATES),
    (DYNAMIC_STATES,),
    DEFLECTION,
)
main = entry(NODE)

if __name__ == "__main__":
    main()
