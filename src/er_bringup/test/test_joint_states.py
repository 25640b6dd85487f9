"""A joint of the vehicle as the deflection of a corner, in both messages that tell of joints."""

from __future__ import annotations

import math
from collections.abc import Mapping
from functools import partial
from types import SimpleNamespace
from typing import Any

import pytest

pytest.importorskip("rclpy")

from er_bringup.nodes.adapter import AdapterNode
from er_bringup.nodes.joint_adapter import NODE
from er_bringup.ros_joint_states import (
    DYNAMIC_STATES,
    STATES,
    JointStateCore,
    JointStateParameters,
)
from er_common.topics import Topic
from er_models.errors import InputError
from er_ros_common.clock import to_stamp
from er_ros_common.core import When
from sensor_msgs.msg import JointState
from std_msgs.msg import Header

MS = 1_000_000
T0 = 1_000_000 * MS
P = JointStateParameters(joint="strut", ratio=-0.5, zero=0.1, max_age=0.0)
BOTH = pytest.mark.parametrize("topic", [STATES, DYNAMIC_STATES], ids=lambda topic: topic.name)
Joints = Mapping[str, Mapping[str, float]]


def said(topic: Topic, stamp: int, joints: Joints) -> Any:
    """A message of either type: interfaces by joint, those of the vehicle's other joints first."""
    header = Header(stamp=to_stamp(stamp), frame_id="chassis")
    if topic is STATES:
        message = JointState(header=header, name=list(joints))
        for part in ("position", "velocity"):
            held = [each[part] for each in joints.values() if part in each]
            setattr(message, part, held)
        return message
    values = [
        SimpleNamespace(interface_names=list(each), values=list(each.values()))
        for each in joints.values()
    ]
    return SimpleNamespace(header=header, joint_names=list(joints), interface_values=values)


def fed(core: JointStateCore, *messages: Any) -> tuple[Any, list[Any]]:
    """State and messages after these."""
    state, out = core.start(), []
    for k, message in enumerate(messages):
        state, answers = core.on_message(state, core.inputs[0], message, When(k * MS, None))
        assert all(topic.name == "sensors/deflection" for topic, _ in answers)
        out += [each for _, each in answers]
    return state, out


@BOTH
def test_the_named_joint_is_scaled_turned_and_measured_from_its_zero(topic: Topic) -> None:
    joints = {
        "wheel": {"velocity": 8.0, "position": 9.0},
        "strut": {"velocity": 2.0, "position": 0.3},
    }
    state, (deflection,) = fed(JointStateCore(P, topic), said(topic, T0, joints))
    assert (deflection.deflection, deflection.velocity) == pytest.approx((-0.1, -1.0))
    assert (deflection.valid, deflection.velocity_valid, deflection.seq) == (True, True, 1)
    assert (deflection.header.stamp, deflection.header.frame_id) == (to_stamp(T0), "chassis")
    assert (state.last.stamp, state.invalid, state.others) == (T0, 0, 0)


@BOTH
def test_what_a_message_lacks_is_not_made_up(topic: Topic) -> None:
    core = JointStateCore(P, topic)
    state, out = fed(
        core,
        said(topic, T0, {"strut": {"position": 0.1}}),
        said(topic, T0 + MS, {"wheel": {"position": 1.0}}),
        said(topic, T0 + 2 * MS, {"strut": {"position": 0.1, "velocity": math.nan}}),
        said(topic, T0 + 3 * MS, {"strut": {"position": math.nan, "velocity": 1.0}}),
        said(
            topic,
            T0 + 4 * MS,
            {"strut": {"velocity": 1.0}} if topic is not STATES else {"strut": {}},
        ),
        said(topic, T0 + 4 * MS, {"strut": {"position": 7.0}}),
    )
    assert [(m.valid, m.velocity_valid) for m in out] == [
        (True, False), (True, False), (False, False), (False, False),
    ]  # fmt: skip
    assert [m.deflection for m in out] == [0.0] * 4
    assert (state.others, state.invalid, state.stamps.duplicate) == (1, 2, 1)


def test_a_joint_that_stays_away_is_told_after_the_timeout() -> None:
    core = JointStateCore(JointStateParameters(joint="strut"), STATES)
    state, _ = fed(core, said(STATES, T0, {"strut": {"position": 0.1}}))
    assert [core.silent(state, state.heard + k * MS) for k in (40, 60)] == [False, True]


def test_a_ratio_of_zero_is_refused() -> None:
    with pytest.raises(InputError, match="ratio"):
        JointStateCore(JointStateParameters(ratio=0.0), STATES)


def test_the_node_hears_joint_states_and_says_the_deflection() -> None:
    assert [topic.name for topic in NODE.card.subscribes] == ["joint_states"]
    assert NODE.card.publishes[0].name == "sensors/deflection"
    assert isinstance(NODE.make, partial)
    assert NODE.make.func is AdapterNode
