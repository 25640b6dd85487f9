"""Repairs of a record's rows: repeated rows, missing samples, dead channels, holes in time.

Pure functions Record -> Record (or pieces); each writes a note on what it changed.
"""

from __future__ import annotations

from dataclasses import replace
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from er_records.record import HELD, Array, Record, is_core

SHORT_GAP = 5
"""Samples; gaps up to this length are bridged, longer ones split the record."""

EDGE_SECONDS = 0.5
"""Missing time at the start or end that counts as start-up, not as lost data [s]."""

Mask = npt.NDArray[np.bool_]


def drop_held(record: Record) -> Record:
    """Drop rows that repeat the one before in time and every sample (a sensor that was held)."""
    held = np.flatnonzero(repeated(record)) + 1
    if not held.size:
        return record
    keep = np.ones(len(record), dtype=bool)
    keep[held] = False
    return _rows(record, keep).noted(
        f"{_count(held.size, 'repeated row')} (same time, same samples) dropped"
    )


def repeated(record: Record) -> Mask:
    """Whether row k + 1 equals row k in time and samples (N - 1,)."""
    same = np.diff(record.t) == 0.0
    for samples in record.channels.values():
        a, b = samples[:-1], samples[1:]
        same &= (a == b) | (np.isnan(a) & np.isnan(b))
    return np.asarray(same)


def drop_empty(record: Record) -> Record:
    """Drop channels without a single valid sample."""
    empty = [name for name, samples in record.channels.items() if bool(np.isnan(samples).all())]
    return _without(record, empty, "has no valid sample and was dropped")


def drop_sparse(record: Record, share: float = 0.5) -> Record:
    """Drop channels that are missing most of the time, so that they do not cut the others.

    `share` counts valid samples among the rows in which any channel is valid.
    """
    valid = {n: ~np.isnan(samples) for n, samples in record.channels.items() if is_core(n)}
    rows = int(np.logical_or.reduce(list(valid.values())).sum()) if valid else 0
    sparse = [name for name, mask in valid.items() if int(mask.sum()) < share * rows]
    if not sparse:
        return record
    text = f"is valid in less than {100 * share:.0f} % of the rows and was dropped"
    return replace(_without(record, sparse, text), complete=False)


def _without(record: Record, names: list[str], why: str) -> Record:
    """The record without some channels, and the notes that say why."""
    if not names:
        return record
    rest = {name: samples for name, samples in record.channels.items() if name not in names}
    return replace(record, channels=rest).noted(*(f"{name} {why}" for name in names))


def fill_slow(record: Record, name: str = "temperature") -> Record:
    """Interpolate a channel that is sampled more slowly than the rest (temperature), ends held."""
    if not record.has(name) or not bool(np.isnan(record.channels[name]).any()):
        return record
    samples = record.channels[name]
    valid = ~np.isnan(samples)
    filled = np.interp(record.t, record.t[valid], samples[valid])
    note = f"{name} interpolated between {_count(int(valid.sum()), 'valid sample')}"
    return replace(record, channels={**record.channels, name: filled}).noted(note)


def bridge(record: Record, limit: int = SHORT_GAP) -> Record:
    """Fill runs of at most `limit` missing samples: linear in time, duty held from before."""
    channels = dict(record.channels)
    notes = []
    for name, samples in record.channels.items():
        runs = _short_runs(record, samples, limit) if is_core(name) else []
        if not runs:
            continue
        filled = samples.copy()
        for i, j in runs:
            ends = [i - 1, j]
            linear = np.interp(record.t[i:j], record.t[ends], samples[ends])
            filled[i:j] = samples[i - 1] if name in HELD else linear
        channels[name] = filled
        missing = _count(sum(j - i for i, j in runs), "missing sample")
        notes.append(f"{name}: {missing} bridged in {_count(len(runs), 'gap')}")
    return replace(record, channels=channels).noted(*notes) if notes else record


def _short_runs(record: Record, samples: Array, limit: int) -> list[tuple[int, int]]:
    """Runs [i, j) of missing samples, valid on both sides and short in time as well as in rows."""
    longest = (limit + 1.5) * record.dt if len(record) > 1 else 0.0
    return [
        (i, j)
        for i, j in nan_runs(np.isnan(samples))
        if i > 0 and j < len(record) and record.t[j] - record.t[i - 1] <= longest
    ]


def nan_runs(missing: Mask) -> list[tuple[int, int]]:
    """Runs [i, j) of True."""
    edges = np.diff(np.concatenate(([False], missing, [False])).astype(np.int8))
    return list(
        zip(np.flatnonzero(edges == 1).tolist(), np.flatnonzero(edges == -1).tolist(), strict=True)
    )


def split(record: Record) -> list[Record]:
    """Cut at missing samples and at holes in time; pieces are `name#1`, `name#2`.

    The result is marked incomplete unless only the start-up or the end was cut.
    """
    missing = np.zeros(len(record), dtype=bool)
    lost: list[str] = []
    for name, samples in record.channels.items():
        if is_core(name) and bool(np.isnan(samples).any()):
            missing |= np.isnan(samples)
            lost.append(name)
    holes = np.flatnonzero(np.diff(record.t) > (SHORT_GAP + 1.5) * record.dt)
    if not lost and not holes.size:
        return [record]
    pieces = _kept_runs(~missing, holes)
    inside = bool(holes.size) or any(i > 0 and j < len(record) for i, j in nan_runs(missing))
    edge = len(record) - (pieces[-1][1] - pieces[0][0]) if pieces else len(record)
    notes = [
        f"t = {record.t[k]:.6g} s: a hole of {record.t[k + 1] - record.t[k]:.3g} s" for k in holes
    ]
    if lost:
        notes.append(
            f"{_count(int(missing.sum()), 'row')} cut where {', '.join(lost)} had no valid sample"
        )
    whole = record.complete and not inside and edge * record.dt <= EDGE_SECONDS
    noted = replace(record, complete=whole).noted(*notes)
    if len(pieces) == 1:
        return [noted.slice(*pieces[0])]
    return [
        replace(noted.slice(i, j), name=f"{record.name}#{k}") for k, (i, j) in enumerate(pieces, 1)
    ]


def _kept_runs(valid: Mask, holes: npt.NDArray[np.intp]) -> list[tuple[int, int]]:
    """Runs [i, j) of valid rows, also cut behind each row in `holes`."""
    runs = []
    for i, j in nan_runs(valid):
        cuts = [i, *(int(k) + 1 for k in holes if i <= k < j - 1), j]
        runs += list(pairwise(cuts))
    return runs


def _rows(record: Record, keep: Mask) -> Record:
    """The rows to keep."""
    channels = {name: samples[keep] for name, samples in record.channels.items()}
    return replace(record, t=record.t[keep], channels=channels)


def _count(number: int, noun: str) -> str:
    """`1 row`, `2 rows`."""
    return f"{number} {noun}" + ("" if number == 1 else "s")
