"""Messages of the contract's topics to arrays: which fields are kept, and when they count."""

from __future__ import annotations

import re
from array import array
from collections.abc import Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt
from er_models.errors import InputError

from er_records.readers.columns import Column, column_of, scales_of, split_header, to_si
from er_records.readers.names import NONE, TIME, Names
from er_records.record import Array, cure

Stamps = npt.NDArray[np.int64]


@dataclass(frozen=True, slots=True)
class Field:
    """A message field, the channel it becomes, and the flags that must be true for it to count.

    column: how it becomes SI, where a user's mapping names the field.
    """

    name: str
    channel: str
    flags: tuple[str, ...] = ("valid",)
    column: Column | None = None


FIELDS: dict[str, tuple[Field, ...]] = {
    "sensors/deflection": (
        Field("deflection", "deflection"),
        Field("velocity", "deflection_velocity", ("valid", "velocity_valid")),
    ),
    "sensors/acceleration": (
        Field("sprung", "sprung_acceleration"),
        Field("unsprung", "unsprung_acceleration"),
    ),
    "sensors/force": (Field("force", "damper_force"),),
    "sensors/road": (Field("displacement", "road"),),
    "pwm/applied": (Field("duty", "duty"),),
}
"""Topic to the fields of its message (er_damper_msgs); `force/<observer>` is handled likewise."""

_TOPIC = re.compile(rf"^(?P<ns>.*?)/?(?P<key>{'|'.join(FIELDS)}|force/(?P<observer>\w+))$")

FIRST_PASS_NS = 500_000_000
"""A step back of the stamps beyond this is a restart, such as a simulation reset [ns]."""

RESTART_MESSAGES = 20
"""Most of as many messages behind a step back must be in the past too, or they are mere strays."""

MOST_AHEAD = RESTART_MESSAGES // 2
"""Of as many messages before a step back, at most so many are strays of the future: more are another time."""

LOOKED_AT, FEWEST_WAITS = 8, 20
"""One in so many messages is timed, and of so many at least a topic is judged."""


def fields_of(key: str) -> tuple[Field, ...]:
    """Fields to keep of a topic (relative name)."""
    if key in FIELDS:
        return FIELDS[key]
    return (Field("force", key.replace("/", "_")),)


@dataclass(frozen=True, slots=True)
class Stream:
    """One topic: stamps [ns] (N,) strictly increasing; channels (N,), NaN where not valid."""

    key: str
    stamps: Stamps
    values: Mapping[str, Array]

    @property
    def measured(self) -> bool:
        """Whether it is no mere estimate of an observer."""
        return self.key in FIELDS or self.key.startswith("/")


@dataclass(slots=True)
class _Rows:
    """Samples of a topic in order of arrival, the values of a message in turn; numbers only, for hours of them."""

    stamps: array[int] = field(default_factory=lambda: array("q"))
    values: array[float] = field(default_factory=lambda: array("d"))


class Collector:
    """Gathers samples by namespace and topic."""

    def __init__(self, path: Path, names: Names = NONE) -> None:
        self.path = path
        self.names = names
        self._own = _own_fields(path, names)
        self._rows: dict[tuple[str, str], _Rows] = {}
        self._waits: dict[tuple[str, str], list[int]] = {}
        self._places: dict[str, tuple[str, str] | None] = {}
        self._names: dict[str, str] = {}

    def rename(self, names: Mapping[str, str]) -> None:
        """Take topics for those of other names, from now on."""
        self._names.update(names)
        self._places.clear()

    def copy(self) -> Collector:
        """An independent collector with the same samples, to go back to when a file is damaged."""
        other = Collector(self.path, self.names)
        other._rows = {k: _Rows(r.stamps[:], r.values[:]) for k, r in self._rows.items()}
        other._waits = {k: list(w) for k, w in self._waits.items()}
        other._names = dict(self._names)
        return other

    def wants(self, topic: str) -> bool:
        """Whether the topic is one of the contract's."""
        return self._place(topic) is not None

    def add(self, topic: str, kind: str, message: object, arrival: int | None = None) -> None:
        """Take the fields of a message that arrived at a time [ns]; `InputError` when they are not there."""
        place = self._place(topic)
        if place is None:
            return
        wanted = self._own.get(topic) or fields_of(place[1])
        try:
            when = stamp_ns(message, arrival if topic in self._own else None)
            values = tuple(_value(message, each) for each in wanted)
        except (AttributeError, TypeError, ValueError, IndexError):
            fields = ", ".join(("header", *(each.name for each in wanted)))
            raise InputError(
                self.path, f"topic {topic}", f"a message with {fields}", kind, cure(self.path)
            ) from None
        rows = self._rows.setdefault(place, _Rows())
        rows.stamps.append(when)
        rows.values.extend(values)
        if arrival is not None and len(rows.stamps) % LOOKED_AT == 1:
            self._waits.setdefault(place, []).append(arrival - when)

    def waits(self, namespace: str) -> dict[str, tuple[float, float]]:
        """Median time from stamp to arrival [s] of each topic of a namespace, and its 90 % spread."""
        found = {}
        for (own, key), waits in self._waits.items():
            if own == namespace and key in FIELDS and len(waits) >= FEWEST_WAITS:
                seconds = np.asarray(waits, dtype=np.float64) * 1e-9
                low, middle, high = np.quantile(seconds, [0.05, 0.5, 0.95])
                found[key] = (float(middle), float(high - low))
        return found

    def streams(self, notes: list[str]) -> dict[str, list[Stream]]:
        """Streams of each namespace ('' is the root); disorder is repaired and noted."""
        found: dict[str, list[Stream]] = {}
        for (namespace, key), rows in sorted(self._rows.items()):
            fields = self._own.get(key) or fields_of(key)
            stream = _ordered(namespace, key, rows, notes, fields)
            found.setdefault(namespace, []).append(stream)
        others = found.keys() - {""}
        if self._own and len(others) == 1 and all(s.key in self._own for s in found.get("", ())):
            found[next(iter(others))] += found.pop("", [])
        # estimates without any measurement are nothing to compare with
        return {ns: own for ns, own in found.items() if any(s.measured for s in own)}

    @property
    def scales(self) -> dict[str, str]:
        """What 1 of each scaled channel means."""
        return scales_of([f.column for own in self._own.values() for f in own if f.column])

    @property
    def asked(self) -> tuple[str, ...]:
        """Topics that the user has said something of."""
        return tuple(self._own)

    def _lacks(self, fields: tuple[Field, ...]) -> bool:
        """Whether a user's mapping leaves any of these channels to its usual topic."""
        mapped = {f.channel for own in self._own.values() for f in own}
        return any(each.channel not in mapped for each in fields)

    def _place(self, topic: str) -> tuple[str, str] | None:
        """Namespace and relative topic name; None for topics outside the contract."""
        if topic in self._own:
            return "", topic
        if topic not in self._places:
            match = _TOPIC.match(self._names.get(topic, topic))
            self._places[topic] = (match["ns"], match["key"]) if match else None
            if match and self._own and not self._lacks(fields_of(match["key"])):
                self._places[topic] = None
        return self._places[topic]


def _own_fields(path: Path, names: Names) -> dict[str, tuple[Field, ...]]:
    """Fields by topic that a mapping names as `/topic.field.of.it` or `/topic.data[2]`."""
    found: dict[str, tuple[Field, ...]] = {}
    for channel, source in names.sources.items():
        topic, dot, name = source.column.partition(".")
        if channel == TIME or not topic.startswith("/") or not dot:
            continue
        bare, unit = split_header(name)
        column = column_of(path, 0, channel, source.unit or unit, source)
        found[topic] = (*found.get(topic, ()), Field(bare, channel, (), column))
    return found


def stamp_ns(message: Any, arrival: int | None = None) -> int:
    """Header stamp [ns]; the arrival stands for it where a message of others has none."""
    if arrival is not None and not hasattr(message, "header"):
        return arrival
    stamp = message.header.stamp
    return int(stamp.sec) * 1_000_000_000 + int(stamp.nanosec)


def value_at(message: object, name: str) -> float:
    """The number at a place in a message: `wrench.force.z`, `data[2]`."""
    for part in re.findall(r"[^.\[\]]+", name):
        message = message[int(part)] if part.isdigit() else getattr(message, part)  # type: ignore[index]
    return float(message)  # type: ignore[arg-type]


def _value(message: object, wanted: Field) -> float:
    """A field as float, NaN when one of its flags is false."""
    value = value_at(message, wanted.name)
    return value if all(getattr(message, flag) for flag in wanted.flags) else float("nan")


def _ordered(
    namespace: str, key: str, rows: _Rows, notes: list[str], fields: tuple[Field, ...]
) -> Stream:
    """The stream with stamps strictly increasing; what was left out or sorted is noted."""
    topic = f"{namespace}/{key}"
    stamps = np.asarray(rows.stamps, dtype=np.int64)
    keep, why = _first_pass(stamps)
    notes += [f"{topic}: {sentence}" for sentence in why]
    values = np.asarray(rows.values, dtype=np.float64).reshape(stamps.size, -1)[keep]
    stamps = stamps[keep]
    late = int(np.count_nonzero(np.diff(stamps) < 0))
    unique, first = np.unique(stamps, return_index=True)
    if late:
        notes.append(f"{topic}: {messages(late)} out of order, sorted by stamp")
    if unique.size < stamps.size:
        repeats = messages(stamps.size - unique.size)
        notes.append(f"{topic}: {repeats} with a repeated stamp dropped")
    channels = {}
    for i, wanted in enumerate(fields):
        channels[wanted.channel] = values[first, i]
        if wanted.column is not None:
            channels[wanted.channel], how = to_si(wanted.column, values[first, i])
            notes += [f"{wanted.channel} is {key}.{wanted.name}", *how]
    return Stream(key, unique, channels)


def _first_pass(stamps: Stamps) -> tuple[Stamps, list[str]]:
    """Indices to keep, and why others are left out: no stamp, a stray stamp, a restart of time."""
    why: list[str] = []
    index = np.arange(stamps.size)
    # simulated time may begin at zero, so a first zero counts when the next stamp follows closely
    zero = stamps == 0
    if zero.size > 1 and stamps[1] <= FIRST_PASS_NS:
        zero[0] = False
    if zero.any():
        why.append(f"{messages(int(zero.sum()))} without a stamp dropped")
        index = index[~zero]
    ahead = _ahead(stamps[index])
    if ahead.any():
        why.append(f"{messages(int(ahead.sum()))} with a stamp far in the future dropped")
        index = index[~ahead]
    own = stamps[index]
    past = np.maximum.accumulate(own) - own > FIRST_PASS_NS
    if past.any():
        k = int(np.argmax(past))
        if float(past[k : k + RESTART_MESSAGES].mean()) > 0.5 and past[k:].sum() > 1:
            why.append(f"time jumps back after {messages(k)}; {own.size - k} behind it left out")
            index = index[:k]
        else:
            why.append(f"{messages(int(past.sum()))} with a stamp far in the past dropped")
            index = index[~past]
    return index.astype(np.int64), why


def _ahead(own: Stamps) -> npt.NDArray[np.bool_]:
    """Which stamps are far above those behind them, where these go on from the others before: strays of the future."""
    found = np.zeros(own.size, dtype=bool)
    for k in np.flatnonzero(np.diff(own) < -FIRST_PASS_NS) + 1:
        start = max(k - RESTART_MESSAGES, 0)
        before, behind = own[start:k], np.sort(own[k : k + RESTART_MESSAGES])
        # the middle one: there may be strays among them, too
        level = behind[behind.size // 2]
        high = before > level + FIRST_PASS_NS
        goes_on = before[~high].max(initial=level) <= level
        if goes_on and high.sum() <= min(MOST_AHEAD, behind.size):
            found[start:k] |= high
    return found


def messages(count: int) -> str:
    """`1 message`, `2 messages`."""
    return f"{count} message" + ("" if count == 1 else "s")
