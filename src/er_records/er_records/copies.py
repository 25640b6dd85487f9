"""Records that hold the same samples: copies of a file, one run in two formats, data that shall only score."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np
from er_models.errors import InputError

from er_records.dataset import Dataset
from er_records.record import Array, Record

SAME = 1e-6
"""Largest difference of samples that are the same but for their rounding, over the channel's largest value."""
CELL = 1e-5
"""Relative width of the cells of root mean squares in which copies are looked for."""
TELLING = (
    "damper_force", "sprung_acceleration", "unsprung_acceleration", "deflection", "deflection_velocity", "road",
    "sprung_displacement", "unsprung_displacement", "actuator_force", "temperature", "duty",
)  # fmt: skip
"""Channels, those first that hardly ever are alike in two runs."""


def used_once(records: Sequence[Record]) -> list[Record]:
    """The records without copies of earlier ones, which note them; corners of one recording may be alike."""
    found, kept = copies(records), list(records)
    found = {k: first for k, first in found.items() if not _beside(records[k], records[first])}
    for k, first in found.items():
        note = (
            f"{_called(records[k])} holds the same samples as {_called(records[first])}: used once"
        )
        kept[first] = kept[first].noted(note)
    return [r for k, r in enumerate(kept) if k not in found]


def check_apart(data: Dataset) -> None:
    """Refuse data that shall only score and are learnt from as well.

    Raises:
        InputError: Both hold the same record.
    """
    n = len(data.learn)
    for k, first in copies(data.records).items():
        if first < n <= k:
            found = f"the samples of {_called(data.learn[first])}"
            file = data.score[k - n].file
            raise InputError(file, "held_out", "samples that are not learnt from", found)


def copies(records: Sequence[Record]) -> dict[int, int]:
    """Places of records that hold the samples of an earlier one, and the place of the first of these."""
    found: dict[int, int] = {}
    seen: dict[tuple[int, str, int], list[int]] = {}
    for k, record in enumerate(records):
        channels = _measured(record)
        name = next((n for n in TELLING if n in channels and _tells(channels[n])), None)
        if name is None:
            continue
        cell = round(float(np.log(np.sqrt(np.mean(channels[name] ** 2)))) / CELL)
        near = [
            j for c in (cell - 1, cell, cell + 1) for j in seen.get((len(record), name, c), ())
        ]
        first = next((j for j in near if _same(records[j], record)), None)
        if first is None:
            seen.setdefault((len(record), name, cell), []).append(k)
        else:
            found[k] = first
    return found


def _tells(y: Array) -> bool:
    """Whether a channel (n,) can tell records apart: all of it is known, and it is not zero throughout."""
    return bool(np.all(np.isfinite(y)) and np.any(y))


def _same(a: Record, b: Record) -> bool:
    """Whether two records of one length have the same samples of time, from their starts, and all common channels."""
    ours, theirs = _measured(a), _measured(b)
    if np.max(np.abs((a.t - a.t[0]) - (b.t - b.t[0]))) > 0.1 * a.dt:
        return False
    return all(
        np.max(np.abs(ours[n] - theirs[n])) <= SAME * np.max(np.abs(ours[n]))
        for n in TELLING
        if n in ours and n in theirs
    )


def _beside(a: Record, b: Record) -> bool:
    """Whether two records stand side by side in one file or recording."""
    return a.file == b.file and a.name != b.name


def _measured(record: Record) -> dict[str, Array]:
    """Channels that were measured, not derived from others."""
    return {n: y for n, y in record.channels.items() if n not in record.derived}


def _called(record: Record) -> str:
    """Name and file of a record."""
    return f"{record.name} of {record.file}"
