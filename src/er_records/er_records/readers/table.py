"""A file as a table of columns, whatever its format, and the record that it becomes."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from er_models.errors import InputError

from er_records.provenance import restore
from er_records.readers.columns import LEFT_OUT, Column, made, resolve, scales_of, to_si
from er_records.readers.names import TIME, Given, Names
from er_records.record import CHANNELS, HELD, Array, Record, cure
from er_records.sampling import at

Numbers = tuple[list[Array], list[str]]
"""Samples (n,) of columns as stored, NaN where missing, and notes on how they were read."""

BASE = ("deflection", *(name for name in CHANNELS if name not in ("deflection", "temperature")))
"""Whose time axis the record takes where channels have their own: the first of these that is there."""


@dataclass(frozen=True)
class Table:
    """The columns of one file.

    header: cells `name [unit]`; numbers: reads some of its columns; digest: SHA-256 of the file; provenance: what
    `er_records.write` stored in it; times: the own time axis (n,) [s] of a column by its place, where the format has
    one for each, else None.
    """

    path: Path
    header: tuple[str, ...]
    numbers: Callable[[Sequence[Column]], Numbers]
    digest: str
    complete: bool = True
    provenance: str = ""
    times: Callable[[int], Array] | None = None
    notes: tuple[str, ...] = ()


def record(table: Table, names: Given | Names | None = None) -> Record:
    """The record of a table, samples in SI units.

    Raises:
        InputError: Wrong columns, a cell that is no number.
    """
    columns, notes = resolve(table.path, table.header, names, needs_time=table.times is None)
    if table.times is not None:  # such files hold hundreds of them
        others = [n for n in notes if n.endswith(LEFT_OUT)]
        kept = [n for n in notes if not n.endswith(LEFT_OUT)]
        notes = kept + [f"{len(others)} other channels were left out"] * bool(others)
    stored = [c for c in columns if c.index >= 0]
    numbers, how = table.numbers(stored)
    notes += how
    found: dict[str, Array] = {}
    for column, raw in zip(stored, numbers, strict=True):
        found[column.name], said = to_si(column, raw)
        notes += said
    if table.times is not None and TIME not in found:
        own = {c.name: table.times(c.index) for c in stored}
        found, said = joined(table.path, own, found)
        notes += said
    n = next((y.size for y in found.values()), 0)
    absent = [c for c in columns if c.index < 0 and c.name not in found]
    found |= made(table.path, absent, n, found.get(TIME))
    t = found.pop(TIME)
    result = Record(
        table.path.stem, t, found, (*table.notes, *notes), table.complete, str(table.path), table.digest,
        scales=scales_of(columns),
    )  # fmt: skip
    return restore(result, table.provenance, table.path) if table.provenance else result


def joined(
    path: Path, own: Mapping[str, Array], signals: Mapping[str, Array]
) -> tuple[dict[str, Array], list[str]]:
    """Channels with time axes of their own, brought to one, which stands among them as `t`; and notes.

    Raises:
        InputError: A channel without times, such as one of a table, which a column `t` must give.
    """
    bare = next((name for name, times in own.items() if times.size != signals[name].size), None)
    if bare is not None:
        raise InputError(path, f"time of '{bare}'", "times for each sample", "none", cure(path))
    base = next((name for name in BASE if name in signals), next(iter(signals)))
    t, notes, found = own[base], list[str](), dict[str, Array]()
    for name, samples in signals.items():
        same = own[name].size == t.size and bool(np.array_equal(own[name], t))
        found[name] = samples if same else onto(own[name], samples, t, name)
        if not same:
            notes.append(f"{name} is sampled at other times and was brought to those of {base}")
    return {TIME: t, **found}, notes


def onto(own_t: Array, samples: Array, t: Array, name: str) -> Array:
    """Samples at times t, NaN outside the channel's own time span."""
    if own_t.size == 0:
        return np.full(t.size, np.nan)
    # a held value stays in force for one more period
    after = float(np.median(np.diff(own_t))) if name in HELD and own_t.size > 1 else 0.0
    inside = (t >= own_t[0] - 1e-9) & (t <= own_t[-1] + after + 1e-9)
    return np.asarray(np.where(inside, at(own_t, samples, t, name), np.nan))
