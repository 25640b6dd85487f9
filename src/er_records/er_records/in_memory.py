"""Records from arrays and tables in memory, checked and repaired as files are."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np
from er_models.errors import InputError, UnknownName
from numpy.typing import ArrayLike

from er_records.clean import clean
from er_records.dataset import Dataset
from er_records.provenance import content_digest
from er_records.readers.columns import made, resolve, scales_of, to_si
from er_records.readers.names import TIME, Given, parsed
from er_records.record import CHANNELS, Array, Record, unit_of

if TYPE_CHECKING:
    import pandas as pd


def from_arrays(t: ArrayLike, *, name: str = "arrays", **channels: ArrayLike) -> Dataset:
    """One record from arrays in SI units, all (n,): `t` [s] and channels by the contract's names.

    Example: `from_arrays(t, deflection=x, duty=u, damper_force=f)`. Missing samples are NaN; the velocity is derived
    where it is absent, and the notes say so.

    Raises:
        UnknownName: A channel that there is none of.
        InputError: Arrays of different lengths, unsorted times, samples that no damper makes.
    """
    for channel in channels:
        if unit_of(channel) is None:
            raise UnknownName("channel", channel, tuple(CHANNELS))
    samples = {key: _numbers(name, key, values) for key, values in channels.items()}
    return _dataset(Record(name, _numbers(name, TIME, t), samples, source=name))


def from_frame(frame: pd.DataFrame, names: Given | None = None, *, name: str = "table") -> Dataset:
    """One record from a table whose columns are named as in a file, with units in brackets: `damper_force [kN]`.

    names: what the table's own columns are, such as `{"damper_force": "Kraft [kN]"}` or
    `{"duty": {"from": "Strom [A]", "full_scale": 1.6}}` (`er_records.readers.names`); where the table has no
    column `t`, its index is the time [s].

    Raises:
        InputError: No time, no channel, a misspelt or repeated column, an unknown unit, text where numbers belong.
        UnknownName: A key of `names` that is no channel.
    """
    header, path = [str(column) for column in frame.columns], Path(name)
    timed = TIME in header or TIME in (names or {}) or any(h.startswith("t ") for h in header)
    columns, notes = resolve(path, header, parsed(names), needs_time=timed)
    channels: dict[str, Array] = {}
    for column in (c for c in columns if c.index >= 0):
        raw = _numbers(name, column.name, frame.iloc[:, column.index])
        channels[column.name], how = to_si(column, raw)
        notes += how
    index = None if timed else _numbers(name, TIME, frame.index)
    absent = [c for c in columns if c.index < 0]
    channels |= made(path, absent, len(frame), channels.get(TIME, index))
    t = channels.pop(TIME) if index is None else index
    scales = scales_of(columns)
    return _dataset(Record(name, t, channels, tuple(notes), source=name, scales=scales))


def _numbers(name: str, key: str, values: ArrayLike) -> np.ndarray:
    """Samples (n,) as numbers."""
    try:
        return np.asarray(values, dtype=np.float64)
    except (TypeError, ValueError):
        raise InputError(name, key, "numbers", type(values).__name__) from None


def _dataset(record: Record) -> Dataset:
    """The record, checked and repaired, with a digest of its samples."""
    return Dataset.of(clean(replace(record, digest=content_digest(record))))
