"""Which stretches of long data are searched: those that together cover best what the data hold.

Every stretch is counted into cells: ranges of deflection, velocity, duty, change of duty, temperature and time,
alone and in pairs. What a stretch adds is the sum over the cells of log(1 + time there): the first second in a
corner of the data counts far more than the hundredth of what there is plenty of. Taking the best stretch again
and again comes within 1 - 1/e of the best choice (Nemhauser, Wolsey and Fisher 1978). Forces are not looked at:
what is searched must not depend on where a model fails.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise

import numpy as np
from er_records.dataset import Dataset, Place
from er_records.record import Array, Record
from numpy.typing import NDArray

LONG = 120_000
"""Samples (ten minutes at 200 Hz) up to which everything is searched."""
USED = 24_000
"""Samples that are searched of longer data."""
STRETCH = (5.0, 10.0)
"""Shortest and longest stretch [s]: shorter where there are many records, so that more of them are looked at."""
LEAST = 3
"""Fewest stretches of whatever length: one of them has to be held out."""
EDGES = (0.001, 0.02, 0.1, 0.3, 0.5, 0.7, 0.9, 0.98, 0.999)
"""Quantiles between the cells of a quantity: fine at both ends, where stops and cut-offs show."""
SOON = 0.1
"""Time in a cell from which more of it begins to count less [s]."""
PERIODS = 8
"""Cells of the time of a record."""


def shortened(data: Dataset, also: Sequence[Place] = ()) -> Dataset:
    """The data, or of long ones the stretches to search.

    also: stretches to use whatever they cover.
    """
    if sum(map(len, data.records)) <= LONG:
        return data
    learn = len(data.learn)
    places = chosen(data.learn, USED * 3 // 4 if data.score else USED)
    places = sorted({*places, *also}, key=lambda p: (p.record, p.i))
    score = chosen(data.score, USED // 4) if data.score else []
    cut = [*places, *(replace(p, record=p.record + learn) for p in score)]
    pieces = [_cut(data.records[p.record], p) for p in cut]
    return Dataset(tuple(pieces[: len(places)]), tuple(pieces[len(places) :]), data, tuple(cut))


def with_more(data: Dataset, also: Sequence[Place]) -> Dataset:
    """The stretches with some more of them; see `shortened`."""
    assert data.whole is not None
    return shortened(data.whole, [*data.places[: len(data.learn)], *also])


def _cut(record: Record, place: Place) -> Record:
    """One stretch, which bears the time at which it begins in its name."""
    since = record.t[place.i] - record.t[0]
    whole = place.j - place.i == len(record)
    return replace(
        record.slice(place.i, place.j),
        name=record.name if whole else f"{record.name}@{since:.0f}s",
    )


def places_of(records: Sequence[Record], longest: float = STRETCH[1]) -> list[Place]:
    """All stretches of all records, end to end and equally long within a record, at most some `longest` seconds."""
    found = []
    for r, record in enumerate(records):
        usual = float(np.clip(USED * record.dt / (2 * len(records)), *STRETCH))
        seconds = min(usual, longest)
        number = max(round(len(record) * record.dt / seconds), 1)
        edges = np.linspace(0, len(record), number + 1).astype(int)
        found += [Place(r, int(i), int(j)) for i, j in pairwise(edges)]
    return found


def chosen(records: Sequence[Record], budget: int, longest: float = STRETCH[1]) -> list[Place]:
    """Stretches of at most `budget` samples together (but at least three) that cover the data best."""
    places = places_of(records, longest)
    seconds = _seconds_in_cells(records, places)
    taken: list[int] = []
    covered, used = np.zeros(seconds.shape[1]), 0
    while len(taken) < len(places):
        gain = np.log1p((covered + seconds) / SOON).sum(axis=1) - np.log1p(covered / SOON).sum()
        gain[taken] = -np.inf
        best = int(np.argmax(gain))
        size = places[best].j - places[best].i
        if len(taken) >= LEAST and used + size > budget:
            break
        taken.append(best)
        covered, used = covered + seconds[best], used + size
    return [places[k] for k in sorted(taken)]


def _seconds_in_cells(records: Sequence[Record], places: Sequence[Place]) -> Array:
    """Time (stretches, cells) [s] that each stretch spends in each cell."""
    columns = _quantities(records)
    edges = [np.unique(np.quantile(np.concatenate(parts), EDGES)) for parts in columns]
    counts = [_counts(records, columns, edges, place) for place in places]
    return np.asarray(np.array(counts) * np.array([[records[p.record].dt] for p in places]))


def _quantities(records: Sequence[Record]) -> list[list[Array]]:
    """What the damper feels and how much of it: per quantity one array (n,) for each record."""
    found: list[list[Array]] = []
    for name in ("deflection", "deflection_velocity", "duty", "temperature"):
        found.append([_or_zero(r, name) for r in records])
    found.append([np.abs(np.diff(y, prepend=y[:1])) for y in found[2]])
    return [parts for parts in found if any(np.ptp(y) > 0.0 for y in parts)]


def _or_zero(record: Record, name: str) -> Array:
    """Samples of a channel without holes; zeros where there is none."""
    return record.channels[name] if record.has(name) else np.zeros(len(record))


def _counts(
    records: Sequence[Record], columns: list[list[Array]], edges: list[Array], place: Place
) -> Array:
    """Samples of one stretch in every cell: of each quantity, of neighbouring pairs of them, of time."""
    rows = slice(place.i, place.j)
    cells = [
        np.searchsorted(e, parts[place.record][rows])
        for parts, e in zip(columns, edges, strict=True)
    ]
    sizes = [e.size + 1 for e in edges]
    found = [np.bincount(c, minlength=n) for c, n in zip(cells, sizes, strict=True)]
    for k in range(len(cells) - 1):
        both: NDArray[np.intp] = cells[k] * sizes[k + 1] + cells[k + 1]
        found.append(np.bincount(both, minlength=sizes[k] * sizes[k + 1]))
    when = np.zeros(PERIODS * len(records))
    period = PERIODS * (place.i + place.j) // (2 * len(records[place.record]))
    when[place.record * PERIODS + min(period, PERIODS - 1)] = place.j - place.i
    return np.concatenate([*found, when]).astype(float)
