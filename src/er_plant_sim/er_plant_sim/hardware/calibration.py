"""From counts of a device to SI units: gain, offset, sign, low-pass, range; from a file.

    schema: er_calibration 1
    name: rig                  # optional, the file's name by default
    channels:
      deflection: {gain: 1.0e-6, offset: 120, sign: -1, cutoff: 90.0, low: -30000, high: 30000}

value = sign * gain * (counts - offset), gain in the channel's SI unit per count. The offset of an
accelerometer is its reading at rest, so gravity goes with it. A channel that is not in the file is not
published. cutoff [Hz] (0: none) is a first-order low-pass, exact for readings held between samples.
Counts outside low..high are out of range.
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass
from enum import Enum
from pathlib import Path
from typing import Any, NamedTuple

from er_models.errors import InputError
from er_models.spec import REQUIRED, Number, Setting, Text, settings
from er_models.yaml_file import read_yaml

from er_plant_sim.hardware.frame import CHANNELS

SCHEMA = "er_calibration 1"
_COUNTS = 2.0**31
UNITS = ("m/s2", "m/s2", "m", "m/s", "N", "m")


class Quality(Enum):
    """What a value is worth."""

    OK = "ok"
    ABSENT = "not measured"
    UNREAD = "not read this time"
    OUT_OF_RANGE = "out of range"


@dataclass(frozen=True, slots=True)
class Channel:
    """Calibration of one channel: gain [SI/count], offset [counts], sign, cutoff [Hz], range [counts]."""

    gain: float
    offset: float = 0.0
    sign: float = 1.0
    cutoff: float = 0.0
    low: float = -_COUNTS
    high: float = _COUNTS - 1.0


@dataclass(frozen=True)
class Calibration:
    """Channels in the order of `frame.CHANNELS`; None where there is none."""

    name: str
    channels: tuple[Channel | None, ...]


class Value(NamedTuple):
    """A value in SI units, 0.0 unless its quality is OK."""

    value: float
    quality: Quality


Filters = tuple[float, ...]
"""Low-passed value of each channel [SI]; NaN before the first."""
EMPTY: Filters = (math.nan,) * len(CHANNELS)


def step(
    p: Calibration, state: Filters, counts: tuple[int, ...], valid: int, dt: float
) -> tuple[Filters, tuple[Value, ...]]:
    """Values of one sample; dt: time since the one before [s]; valid: bits of the channels that were read."""
    after, values = list(state), []
    for i, channel in enumerate(p.channels):
        if channel is None:
            values.append(Value(0.0, Quality.ABSENT))
        elif not valid >> i & 1:
            values.append(Value(0.0, Quality.UNREAD))
        elif not channel.low <= counts[i] <= channel.high:
            values.append(Value(0.0, Quality.OUT_OF_RANGE))
        else:
            after[i] = _filtered(channel, state[i], to_si(channel, counts[i]), dt)
            values.append(Value(after[i], Quality.OK))
    return tuple(after), tuple(values)


def to_si(p: Channel, counts: float) -> float:
    """Value of a reading in SI units, unfiltered."""
    return p.sign * p.gain * (counts - p.offset)


def to_counts(p: Channel, value: float) -> int:
    """The reading nearest to a value, within the channel's range: what a converter would show."""
    return round(min(max(p.sign * value / p.gain + p.offset, p.low), p.high))


def _filtered(p: Channel, before: float, value: float, dt: float) -> float:
    if not p.cutoff or math.isnan(before):
        return value
    return value + (before - value) * math.exp(-2.0 * math.pi * p.cutoff * max(dt, 0.0))


_TABLE: tuple[Setting, ...] = (
    Text("schema", REQUIRED, f"'{SCHEMA}'", (SCHEMA,)),
    Text("name", "", "name"),
    Text("source", "", "how and when it was calibrated"),
)


def _channel_table(unit: str) -> tuple[Setting, ...]:
    return (
        Number("gain", f"{unit} per count", REQUIRED, 1e-15, 1e6, f"{unit} per count"),
        Number("offset", "counts", 0.0, -_COUNTS, _COUNTS, "counts at zero"),
        Number("sign", "1 or -1", 1.0, -1.0, 1.0, "-1 where the sensor is mounted the other way"),
        Number("cutoff", "Hz", 0.0, 0.0, 1e5, "low-pass; 0: none"),
        Number("low", "counts", -_COUNTS, -_COUNTS, _COUNTS - 1.0, "lowest plausible reading"),
        Number(
            "high", "counts", _COUNTS - 1.0, -_COUNTS, _COUNTS - 1.0, "highest plausible reading"
        ),
    )


def load_calibration(path: str | Path) -> Calibration:
    """Read a calibration file.

    Raises `InputError` naming file, key, expected and found.
    """
    path = Path(path)
    document = read_yaml(path, "a calibration file")
    if not isinstance(document, Mapping):
        raise InputError(path, "", "a mapping of names to values", type(document).__name__)
    top = settings(_TABLE, document, path, also=("channels",))
    found = document.get("channels")
    if not isinstance(found, Mapping) or not found:
        raise InputError(path, "channels", f"a mapping of {', '.join(CHANNELS)}", repr(found))
    for name in found:
        if name not in CHANNELS:
            raise InputError(
                path, f"channels.{name}", f"one of {', '.join(CHANNELS)}", "an unknown key"
            )
    channels = (
        _channel(path, name, unit, found[name]) if name in found else None
        for name, unit in zip(CHANNELS, UNITS, strict=True)
    )
    return Calibration(top["name"] or path.stem, tuple(channels))


def _channel(path: Path, name: str, unit: str, document: Any) -> Channel:
    key = f"channels.{name}"
    if not isinstance(document, Mapping):
        raise InputError(path, key, "a mapping with gain", repr(document))
    channel = Channel(**settings(_channel_table(unit), document, path, key, also=()))
    if abs(channel.sign) != 1.0:
        raise InputError(path, f"{key}.sign", "1 or -1", f"{channel.sign:g}")
    if not channel.low < channel.high:
        raise InputError(path, f"{key}.low", "a reading below high", f"{channel.low:g}")
    return channel
