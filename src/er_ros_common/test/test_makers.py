"""Messages made without their constructors are those that the constructors make; what is read is what they hold."""

from __future__ import annotations

import inspect
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

pytest.importorskip("rclpy")

from diagnostic_msgs.msg import DiagnosticArray
from rclpy.serialization import deserialize_message, serialize_message

from er_damper_msgs import msg
from er_ros_common import builders, makers

KINDS = [kind for _, kind in inspect.getmembers(msg, inspect.isclass)]


@pytest.fixture(params=[False, True], ids=["unchecked", "checked"])
def checked(request: pytest.FixtureRequest) -> bool:
    """Whether ROS 2 checks fields; the tests ask for it, nodes of users do not."""
    return bool(request.param)


def _fields(kind: type[Any]) -> list[str]:
    return [name for name in kind.get_fields_and_field_types() if name != "header"]


@pytest.mark.parametrize("kind", KINDS, ids=lambda k: k.__name__)
def test_without_values_a_message_is_as_its_constructor_makes_it(
    kind: type[Any], checked: bool
) -> None:
    made = makers.written(kind(check_fields=checked), ())(0, 0)
    assert type(made) is kind
    assert made == kind()
    assert made._check_fields is checked
    # not byte by byte: what fills gaps on the wire is anything
    assert deserialize_message(serialize_message(made), kind) == kind()


@pytest.mark.parametrize("kind", KINDS, ids=lambda k: k.__name__)
def test_every_field_arrives_in_its_place(kind: type[Any], checked: bool) -> None:
    examples = {"boolean": True, "double": 1.5, "uint8": 2, "uint64": 3, "string": "word"}
    types = kind.get_fields_and_field_types()
    values = {name: examples[types[name]] for name in _fields(kind)}
    expected = kind(**values)
    expected.header.stamp.sec, expected.header.stamp.nanosec = 5, 6
    make = makers.written(kind(check_fields=checked), tuple(values))
    assert deserialize_message(serialize_message(make(5, 6, *values.values())), kind) == expected


@pytest.mark.parametrize("kind", KINDS, ids=lambda k: k.__name__)
def test_what_is_read_is_what_was_written(kind: type[Any]) -> None:
    fields = _fields(kind)
    values = [getattr(kind(), name) for name in fields]
    message = makers.maker(kind, ("seq", "valid"))(5, 6, 7, True)
    seen = dict(zip(fields, makers.reader(kind, fields)(message)[2:], strict=True))
    assert seen == {**dict(zip(fields, values, strict=True)), "seq": 7, "valid": True}
    assert makers.reader(kind, ("seq",))(message) == (5, 6, 7)
    with pytest.raises(AttributeError):
        makers.reader(kind, ("nothing",))


def test_the_tick_of_a_message_is_read_from_whoever_made_it() -> None:
    """A recording's reader makes messages of its own, without slots and with numbers of NumPy."""
    tick = builders.Tick(5_000_000_006, 7)
    made = builders.pwm_duty(tick, 0.1)
    stamp = SimpleNamespace(sec=5, nanosec=6)
    read = SimpleNamespace(header=SimpleNamespace(stamp=stamp), seq=np.uint64(7))
    for message in (made, read):
        found = builders.tick_of(message)
        assert found == tick
        assert type(found.seq) is int
    made.header.stamp.nanosec = 1_000_000_000  # no stamp at all
    assert builders.tick_of(made) == (0, 7)


@pytest.mark.parametrize("kind", KINDS, ids=lambda k: k.__name__)
def test_no_two_messages_share_anything(kind: type[Any]) -> None:
    make = makers.maker(kind, ())
    one, other = make(0, 0), make(0, 0)
    one.header.stamp.sec, one.header.frame_id, one.seq = 5, "a", 7
    assert other == kind()
    assert make(0, 0) == kind()


def test_fields_are_checked_where_that_is_asked_for() -> None:
    make = makers.written(msg.DamperForce(check_fields=True), ("force",))
    with pytest.raises(AssertionError, match="must be of type 'float'"):
        make(0, 0, "1")


def test_an_unknown_field_is_refused() -> None:
    with pytest.raises(AttributeError, match="strength"):
        makers.maker(msg.DamperForce, ("force", "strength"))


def test_messages_with_lists_have_no_maker() -> None:
    with pytest.raises(TypeError, match=r"DiagnosticArray\.status is list"):
        makers.maker(DiagnosticArray, ())
