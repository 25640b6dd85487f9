"""Injected faults do what they are called, end when they should, and are refused where they mean nothing."""

from __future__ import annotations

import math
from dataclasses import dataclass
from random import Random

import pytest
from er_models.errors import InputError
from er_ros_common.injection import Channel, Kind, asked, described, taken_over, through

FIELDS = {"sensors/acceleration": ("sprung", "unsprung")}


@dataclass
class Message:
    """Stands for a message."""

    seq: int
    sprung: float
    unsprung: float


def run(
    kind: Kind, value: float, ticks: int, unit: str = "sensors/acceleration", duration: float = 0.0
) -> list[list[Message]]:
    """What goes out at each of these ticks of 5 ms."""
    _, fault = asked(unit, kind, value, duration, FIELDS, 0.0, rate=200.0)
    channel, random, out = Channel(fault), Random(1), []
    for k in range(ticks):
        channel, sent = through(channel, Message(k, float(k), -float(k)), 0.005 * k, random)
        out.append(sent)
    return out


def test_off_says_nothing_and_ends_in_time() -> None:
    counts = [len(sent) for sent in run(Kind.OFF, 0.0, 20, duration=0.05)]
    assert counts == [0] * 10 + [1] * 10


def test_stuck_keeps_values_and_not_numbers_of_the_tick() -> None:
    out = run(Kind.STUCK, 0.0, 5, unit="sensors/acceleration.sprung")
    assert [(m.seq, m.sprung, m.unsprung) for (m,) in out] == [
        (k, 0.0, -float(k)) for k in range(5)
    ]


def test_bias_is_added() -> None:
    assert [m.sprung for (m,) in run(Kind.BIAS, 0.5, 3)] == [0.5, 1.5, 2.5]


def test_garbage_is_of_every_sort() -> None:
    numbers = [m.sprung for (m,) in run(Kind.GARBAGE, 0.0, 200)]
    assert any(math.isnan(x) for x in numbers)
    assert any(math.isinf(x) for x in numbers)
    assert any(abs(x) > 1e300 for x in numbers if math.isfinite(x))


def test_slow_is_a_rate() -> None:
    assert sum(len(sent) for sent in run(Kind.SLOW, 20.0, 200)) == 20


def test_delayed_messages_come_later_and_all_in_order_when_it_ends() -> None:
    out = run(Kind.DELAYED, 0.02, 12, duration=0.05)
    assert [len(sent) for sent in out] == [0] * 4 + [1] * 6 + [5, 1]
    assert [m.seq for sent in out for m in sent] == list(range(12))


def requested(*requests: tuple[int, Kind, float], ticks: int = 30) -> list[int]:
    """Numbers of the messages that go out where faults are asked for before some ticks of 5 ms."""
    channel, random, out = Channel(), Random(1), []
    for k in range(ticks):
        for _, kind, value in (each for each in requests if each[0] == k):
            _, fault = asked("sensors/acceleration", kind, value, 0.0, FIELDS, 0.005 * k)
            channel = taken_over(channel, fault, 0.005 * k)
        channel, sent = through(channel, Message(k, 0.0, 0.0), 0.005 * k, random)
        out += [m.seq for m in sent]
    return out


@pytest.mark.parametrize(("first", "second"), [(1.0, 0.03), (0.03, 1.0), (0.03, 0.01)])
def test_another_delay_loses_repeats_and_swaps_nothing(first: float, second: float) -> None:
    out = requested((2, Kind.DELAYED, first), (12, Kind.DELAYED, second), (25, Kind.OK, 0.0))
    assert out == list(range(30))


@pytest.mark.parametrize("kind", [Kind.STUCK, Kind.BIAS, Kind.GARBAGE, Kind.OK])
def test_what_is_delayed_goes_before_what_another_fault_leaves(kind: Kind) -> None:
    out = requested((2, Kind.DELAYED, 1.0), (12, kind, 0.5), (25, Kind.OK, 0.0))
    assert out == list(range(30))


def test_what_is_delayed_is_not_held_back_by_another_fault() -> None:
    assert requested((2, Kind.DELAYED, 1.0), (12, Kind.SLOW, 10.0), ticks=14) == list(range(13))
    assert requested((2, Kind.DELAYED, 1.0), (12, Kind.INTERMITTENT, 1.0)) == list(range(12))


def test_what_is_delayed_is_lost_where_nothing_comes_any_more() -> None:
    out = requested((2, Kind.DELAYED, 1.0), (12, Kind.OFF, 0.0), (25, Kind.OK, 0.0))
    assert out == [0, 1, *range(25, 30)]


def test_intermittent_loses_its_share() -> None:
    came = sum(len(sent) for sent in run(Kind.INTERMITTENT, 0.3, 2000))
    assert came == pytest.approx(1400, abs=80)


@pytest.mark.parametrize(
    ("unit", "kind", "value", "duration", "words"),
    [
        ("sensors/accel", 1, 0.0, 0.0, "unit: expected one of sensors/acceleration"),
        ("sensors/acceleration.x", 2, 0.0, 0.0, "unit: expected one of"),
        ("sensors/acceleration.sprung", 1, 0.0, 0.0, "a whole topic for this kind"),
        ("sensors/acceleration", 8, 0.0, 0.0, "kind: expected 0 to 7, found 8"),
        ("sensors/acceleration", 4, math.nan, 0.0, "value: expected a bias"),
        ("sensors/acceleration", 5, 0.0, 0.0, "value: expected a rate"),
        ("sensors/acceleration", 6, -1.0, 0.0, "value: expected a delay"),
        ("sensors/acceleration", 7, 1.5, 0.0, "value: expected a probability"),
        ("sensors/acceleration.", 2, 0.0, 0.0, "unit: expected one of"),
        ("sensors/acceleration", 4, 0.0, 0.0, "not 0, found 0"),
        ("sensors/acceleration", 7, 0.0, 0.0, "not 0, found 0"),
        ("sensors/acceleration", 5, 1000.0, 0.0, "below the 200 Hz that it has, found 1000"),
        ("sensors/acceleration", 5, 200.0, 0.0, "below the 200 Hz"),
        ("sensors/acceleration", 1, 0.0, -1.0, "duration: expected 0 or more seconds"),
    ],
)
def test_what_cannot_be_done_is_refused(
    unit: str, kind: int, value: float, duration: float, words: str
) -> None:
    with pytest.raises(InputError, match=words):
        asked(unit, kind, value, duration, FIELDS, 0.0, rate=200.0)


def test_what_is_in_force_is_said() -> None:
    _, fault = asked("sensors/acceleration", Kind.STUCK, 0.0, 1.0, FIELDS, 10.0)
    channels = {"sensors/acceleration": Channel(fault), "pwm/command": Channel()}
    assert described(channels, 10.5) == "sensors/acceleration stuck"
    assert described(channels, 11.5) == ""
