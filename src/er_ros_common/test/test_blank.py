"""Messages made without their constructors are those that the constructors make."""

from __future__ import annotations

import inspect
from typing import Any

import pytest

pytest.importorskip("rclpy")

from diagnostic_msgs.msg import DiagnosticArray
from er_ros_common.blank import blank
from rclpy.serialization import deserialize_message, serialize_message
from std_msgs.msg import Header

from er_damper_msgs import msg

KINDS = [kind for _, kind in inspect.getmembers(msg, inspect.isclass)]


@pytest.mark.parametrize("kind", [*KINDS, Header, DiagnosticArray], ids=lambda k: k.__name__)
def test_a_blank_message_is_as_its_constructor_makes_it(kind: type[Any]) -> None:
    made = blank(kind)
    assert type(made) is kind
    assert made == kind()
    # not byte by byte: what fills gaps on the wire is anything
    assert deserialize_message(serialize_message(made), kind) == kind()


@pytest.mark.parametrize("kind", KINDS, ids=lambda k: k.__name__)
def test_no_two_messages_share_anything(kind: type[Any]) -> None:
    one, other = blank(kind), blank(kind)
    one.header.stamp.sec, one.header.frame_id, one.seq = 5, "a", 7
    assert other == kind()
    assert blank(kind) == kind()


def test_lists_are_not_shared() -> None:
    one = blank(DiagnosticArray)
    one.status.append(one)
    assert blank(DiagnosticArray).status == []
