"""Faults of sensors and actuators, put on messages on purpose; `fault_port` is the service. No clock.

fault = asked(unit, kind, value, duration, fields)      # or InputError: what cannot be done is refused
channel, out = through(channel, message, now)           # messages to go on with, oldest first
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from copy import deepcopy
from dataclasses import dataclass, replace
from enum import IntEnum
from random import Random
from typing import Any

from er_models.errors import InputError

GARBAGE = (math.nan, math.inf, -math.inf, 1e308, -1e308, 5e-324, 1e30, -1e9)


class Kind(IntEnum):
    """What can be wrong, as in er_damper_msgs/srv/InjectFault."""

    OK = 0
    OFF = 1
    STUCK = 2
    GARBAGE = 3
    BIAS = 4
    SLOW = 5
    DELAYED = 6
    INTERMITTENT = 7


VALUES: Mapping[Kind, tuple[float, float, str]] = {
    Kind.BIAS: (-1e6, 1e6, "a bias in -1e6..1e6 of the field's unit, not 0"),
    Kind.SLOW: (0.01, 1000.0, "a rate in 0.01..1000 Hz"),
    Kind.DELAYED: (0.001, 10.0, "a delay in 0.001..10 s"),
    Kind.INTERMITTENT: (0.0, 1.0, "a probability in 0..1, not 0"),
}
"""Lowest and highest value of the kinds that have one; 0 is never one: it would do nothing."""
OF_FIELDS = (Kind.STUCK, Kind.GARBAGE, Kind.BIAS)
"""Kinds that one field alone can have."""


@dataclass(frozen=True, slots=True)
class Fault:
    """What is wrong with these fields, until a time [s] (inf: until it is taken away)."""

    kind: Kind
    value: float
    fields: tuple[str, ...]
    until: float


@dataclass(frozen=True, slots=True)
class Channel:
    """One unit: its fault, the values it is stuck at, what is delayed (due [s], message), when it last spoke [s]."""

    fault: Fault | None = None
    held: Mapping[str, float] | None = None
    waiting: tuple[tuple[float, Any], ...] = ()
    spoke: float = -math.inf


def asked(
    unit: str, kind: int, value: float, duration: float, fields: Mapping[str, tuple[str, ...]], now: float,
    *, rate: float = math.inf,
) -> tuple[str, Fault | None]:  # fmt: skip
    """Channel and fault of a request; None takes the fault away.

    Args:
        unit: channel, or CHANNEL.FIELD.
        kind: as in the service.
        value: as in the service.
        duration: as in the service.
        fields: names of the numbers of every channel there is.
        now: time [s].
        rate: messages of a channel per second as it is [Hz].

    Raises:
        InputError: There is no such unit or kind, or the value means nothing or would change nothing.
    """
    channel, dot, field = unit.partition(".")
    if channel not in fields or (dot and field not in fields[channel]):
        known = ", ".join(f"{name} ({' '.join(each)})" for name, each in fields.items())
        raise InputError("inject_fault", "unit", f"one of {known}", f"'{unit}'")
    if kind not in tuple(Kind):
        raise InputError("inject_fault", "kind", f"0 to {max(Kind)}", kind)
    wanted = Kind(kind)
    low, high, words = VALUES.get(wanted, (-math.inf, math.inf, ""))
    if math.isnan(value) or not low <= value <= high or (wanted in VALUES and value == 0.0):
        raise InputError("inject_fault", "value", words or "a number", f"{value:g}")
    if wanted is Kind.SLOW and value >= rate:
        expected = f"a rate below the {rate:g} Hz that it has"
        raise InputError("inject_fault", "value", expected, f"{value:g}")
    if field and wanted not in OF_FIELDS:
        expected = "a whole topic for this kind, without a field"
        raise InputError("inject_fault", "unit", expected, f"'{unit}'")
    if not 0.0 <= duration < math.inf:
        raise InputError("inject_fault", "duration", "0 or more seconds", f"{duration:g}")
    if wanted is Kind.OK:
        return channel, None
    until = now + duration if duration else math.inf
    return channel, Fault(wanted, value, (field,) if field else fields[channel], until)


def taken_over(channel: Channel, fault: Fault | None, now: float) -> Channel:
    """The channel with another fault, or none, from time now [s] on.

    What an earlier one delays goes before the next message, so that the order stays; `off` lets none of it through.
    """
    silent = fault is not None and fault.kind is Kind.OFF
    waiting = () if silent else tuple((now, each) for _, each in channel.waiting)
    return Channel(fault, None, waiting)


def through(
    channel: Channel, message: Any, now: float, random: Random
) -> tuple[Channel, list[Any]]:
    """What becomes of a message at time now [s]; without a fault it goes on as it is, behind what was delayed."""
    fault = channel.fault
    if fault is not None and now >= fault.until:
        channel, fault = replace(channel, fault=None, held=None), None
    if fault is None:
        out = [each for _, each in channel.waiting] + [message]
        return replace(channel, waiting=()) if channel.waiting else channel, out
    if fault.kind is Kind.DELAYED:
        channel = replace(channel, waiting=(*channel.waiting, (now + fault.value, message)))
    due = [each for when, each in channel.waiting if when <= now]
    if due:
        later = tuple(each for each in channel.waiting if each[0] > now)
        channel = replace(channel, waiting=later)
    channel, out = _left(channel, fault, message, now, random)
    return channel, due + out


def _left(
    channel: Channel, fault: Fault, message: Any, now: float, random: Random
) -> tuple[Channel, list[Any]]:
    """What goes on at once of a message."""
    if fault.kind in OF_FIELDS:
        return _spoilt(channel, fault, message, random)
    if fault.kind is Kind.SLOW and now - channel.spoke >= 1.0 / fault.value - 1e-9:
        return replace(channel, spoke=now), [message]
    speaks = fault.kind is Kind.INTERMITTENT and random.random() >= fault.value
    return channel, [message] if speaks else []


def _spoilt(
    channel: Channel, fault: Fault, message: Any, random: Random
) -> tuple[Channel, list[Any]]:
    """The message with wrong numbers in some of its fields."""
    changed = deepcopy(message)
    if fault.kind is Kind.STUCK and channel.held is None:
        channel = replace(channel, held={name: getattr(message, name) for name in fault.fields})
    for name in fault.fields:
        if fault.kind is Kind.STUCK:
            number = (channel.held or {})[name]
        elif fault.kind is Kind.BIAS:
            number = getattr(message, name) + fault.value
        else:
            number = random.choice(GARBAGE)
        setattr(changed, name, float(number))
    return channel, [changed]


def described(channels: Mapping[str, Channel], now: float) -> str:
    """What is in force, in words; empty where nothing is."""
    return ", ".join(
        f"{unit} {channel.fault.kind.name.lower()}"
        for unit, channel in channels.items()
        if channel.fault is not None and now < channel.fault.until
    )
