"""Streams of one corner to one record: joined by header stamp, never by time of arrival.

The grid is that of `sensors/deflection` (else acceleration, else force). Channels of the same tick
carry equal stamps and are joined exactly; duty holds its last value; a sensor with a clock or rate
of its own is interpolated; one that shares no time with the grid is dropped. Both are noted.
"""

from __future__ import annotations

import numpy as np

from er_records.readers.bag_streams import Stamps, Stream
from er_records.readers.table import BASE
from er_records.record import HELD, Array, Record

GRID_ORDER = (
    "sensors/deflection",
    "sensors/acceleration",
    "sensors/force",
    "sensors/road",
    "pwm/applied",
)
SAME_TICK = 0.5
"""Share of grid stamps a stream must carry to count as coming from the same tick."""

HOLD_PERIODS = 5.0
"""A value older than this many periods is lost, not held or interpolated."""

TRIM_SECONDS = 5.0
"""Discovery takes seconds: this much may be cut at the ends of a record that is complete [s]."""


def align(name: str, streams: list[Stream], source: str, digest: str) -> list[Record]:
    """The record of one namespace, as a list; empty when the grid has fewer than two stamps."""
    by_key = {stream.key: stream for stream in streams}
    base = _base(streams, by_key)
    notes: list[str] = []
    used = [s for s in streams if _shares_time(s, base, notes)]
    dropped = len(used) < len(streams)
    grid = _common_span(base.stamps, [s for s in used if s.measured])
    if grid.size < 2:
        return []
    trimmed = 1e-9 * float((grid[0] - base.stamps[0]) + (base.stamps[-1] - grid[-1]))
    if trimmed > 0.0:
        notes.append(f"{trimmed:.3g} s cut at the ends, where not all topics were there")
    channels: dict[str, Array] = {}
    for stream in sorted(used, key=lambda s: s.key.startswith("/")):  # a mapping goes before
        for channel, values in stream.values.items():
            channels[channel] = _onto(stream, values, grid, base, notes)
    notes.append(f"t = 0 is the stamp {grid[0] // 10**9}.{grid[0] % 10**9:09d} s")
    t = (grid - grid[0]) * 1e-9
    complete = not dropped and trimmed <= TRIM_SECONDS
    return [Record(name, t, channels, tuple(notes), complete, source, digest)]


def _base(streams: list[Stream], by_key: dict[str, Stream]) -> Stream:
    """The stream whose stamps are the grid: of the usual topics, else that of the first channel of the contract."""
    usual = [by_key[key] for key in GRID_ORDER if key in by_key]
    if usual and (usual[0].key == GRID_ORDER[0] or not any(s.key[:1] == "/" for s in streams)):
        return usual[0]
    return next(s for c in (*BASE, "temperature") for s in streams if c in s.values)


def _is_held(stream: Stream) -> bool:
    """Whether a stream holds nothing but values that stay in force until the next."""
    return stream.values.keys() <= HELD


def _shares_time(stream: Stream, base: Stream, notes: list[str]) -> bool:
    """Whether a stream covers at least half of the grid's time; a note if not."""
    if stream.stamps.size == 0 or base.stamps.size == 0:
        return False
    span = max(int(base.stamps[-1] - base.stamps[0]), 1)
    held = _is_held(stream)
    first = max(int(stream.stamps[0]), int(base.stamps[0]))
    last = min(
        int(stream.stamps[-1]) + (round(_hold_ns(stream)) if held else 0), int(base.stamps[-1])
    )
    if last - first >= 0.5 * span or stream is base or not stream.measured:
        return True
    offset = 1e-9 * float(stream.stamps[0] - base.stamps[0])
    covered = 1e-9 * max(last - first, 0)
    notes.append(
        f"{stream.key} covers {covered:.3g} s of the {span * 1e-9:.3g} s of {base.key} "
        f"(it starts {offset:+.6g} s from it) and was dropped"
    )
    return False


def _period_ns(stamps: Stamps) -> float:
    """Median time between messages [ns]."""
    return float(np.median(np.diff(stamps))) if stamps.size > 1 else 0.0


def _hold_ns(stream: Stream) -> float:
    """How long a held value stays good [ns]."""
    return HOLD_PERIODS * _period_ns(stream.stamps)


def _common_span(grid: Stamps, measured: list[Stream]) -> Stamps:
    """Grid stamps at which every measured stream has begun and none has ended."""
    first = max(int(stream.stamps[0]) for stream in measured)
    last = min(
        int(stream.stamps[-1]) + (round(_hold_ns(stream)) if _is_held(stream) else 0)
        for stream in measured
    )
    return grid[(grid >= first) & (grid <= last)]


def _onto(stream: Stream, values: Array, grid: Stamps, base: Stream, notes: list[str]) -> Array:
    """Values on the grid, NaN where there are none."""
    if _is_held(stream):
        return _held(stream, values, grid)
    k = np.clip(np.searchsorted(stream.stamps, grid), 0, stream.stamps.size - 1)
    equal = stream.stamps[k] == grid
    if float(equal.mean()) >= SAME_TICK or not stream.measured:
        return np.where(equal, values[k], np.nan)
    rate = 1e9 / max(_period_ns(stream.stamps), 1.0)
    text = (
        f"{stream.key} ({rate:.4g} Hz) carries other stamps than {base.key} and was interpolated"
    )
    if text not in notes:
        notes.append(text)
    return _interpolated(stream, values, grid)


def _held(stream: Stream, values: Array, grid: Stamps) -> Array:
    """The value in force at each grid stamp (zero-order hold), NaN when it is too old."""
    k = np.searchsorted(stream.stamps, grid, side="right") - 1
    age = grid - stream.stamps[np.clip(k, 0, None)]
    limit = max(_hold_ns(stream), HOLD_PERIODS * _period_ns(grid))
    return np.where((k >= 0) & (age <= limit), values[np.clip(k, 0, None)], np.nan)


def _interpolated(stream: Stream, values: Array, grid: Stamps) -> Array:
    """Linear in time between neighbours that are not too far apart, NaN elsewhere."""
    zero = int(grid[0])
    own = (stream.stamps - zero).astype(np.float64)
    wanted = (grid - zero).astype(np.float64)
    result = np.interp(wanted, own, values)
    k = np.clip(np.searchsorted(own, wanted), 1, max(own.size - 1, 1))
    if own.size > 1:
        result[(own[k] - own[k - 1]) > HOLD_PERIODS * _period_ns(stream.stamps)] = np.nan
    return result
