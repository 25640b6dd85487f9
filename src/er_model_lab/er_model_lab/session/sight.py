"""What is seen of data and a model: curves for a view, the map of what is left, loops, spectrum, worst places.

A data set is opened once (fused, checked); then every model that differs in effects and values is predicted along it.
What only that needs is imported where it is done, which is while the browser fetches the page.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import TYPE_CHECKING

import numpy as np
from er_models.model import Array, Model
from er_records.dataset import Dataset
from er_records.record import Record
from numpy.typing import NDArray

from er_model_lab.filtering import welch
from er_model_lab.output.report.samples import rms_map
from er_model_lab.output.report.thin import every, min_max
from er_model_lab.preflight.finding import Finding
from er_model_lab.results.records import Errors
from er_model_lab.session.steps import Stretch
from er_model_lab.work import HERE, Work

if TYPE_CHECKING:
    from er_model_lab.preflight.check import Preflight
    from er_model_lab.problem.problem import Problem

Mask = NDArray[np.bool_]
Curve = tuple[Array, Array]

ON_SCREEN = 900
"""Points of one curve that are drawn at once: two for each pixel of a screen's half."""
TILES = (30, 18)
"""Tiles of the map over velocity and deflection."""
SEGMENT = 512
"""Samples of a segment of the spectrum."""
WINDOWS = 60
"""Windows that the data are divided into to find the worst seconds."""


@dataclass(frozen=True, eq=False)
class Tiles:
    """Edges over velocity and deflection [SI], and the tile (n,) of each sample, -1 outside."""

    v: Array
    x: Array
    at: NDArray[np.intp]


@dataclass(frozen=True)
class Part:
    """A record, or a piece of one, in the common time: its name, its rows from i to j, and when it begins and ends.

    shift: common time less the time of its record [s].
    """

    name: str
    i: int
    j: int
    begin: float
    end: float
    shift: float

    def stretch(self, number: int, record: Record, begin: float, end: float) -> Stretch:
        """What lies between two common times [s], of the record with this number that this is a part of."""
        first, last = float(record.t[0]), float(record.t[-1])
        a, b = (min(max(t - self.shift, first), last) - first for t in (begin, end))
        return Stretch(number, a, b)


@dataclass(frozen=True, eq=False)
class Sight:
    """Data opened for a model; all arrays (n,), what is learnt from before what only scores.

    t: common time [s], records end to end with a gap, pieces of one where they lie in it; order: rows by this time;
    undone: values of the effects that were undone in the motion, another one of which needs another sight; tiles: edges
    of the map and each sample's tile.
    """

    problem: Problem
    preflight: Preflight
    t: Array
    order: NDArray[np.intp]
    parts: tuple[Part, ...]
    undone: tuple[tuple[str, float], ...]
    tiles: Tiles

    @property
    def force(self) -> Array:
        """Measured force (n,) [N]."""
        return self.problem.force

    @property
    def ends(self) -> tuple[float, float]:
        """First and last common time [s]."""
        return float(self.t[self.order[0]]), float(self.t[self.order[-1]])

    def places(self, finding: Finding) -> list[tuple[float, float]]:
        """Where a finding is, in the common time [s]; nothing where it is of a whole record."""
        return [
            (max(a + p.shift, p.begin), min(b + p.shift, p.end))
            for p in self.parts for a, b in finding.spans
            if p.name == finding.record and a + p.shift <= p.end and b + p.shift >= p.begin
        ]  # fmt: skip

    def fits(self, model: Model) -> bool:
        """Whether this model may be predicted along it."""
        return self.undone == _undone(model)

    def predicted(self, model: Model) -> Array:
        """Force of the model (n,) [N]."""
        from er_model_lab.fitting.velocity_channel import on_fused

        return self.problem.predict(on_fused(model))

    def errors(self, residual: Array) -> Errors:
        """Root mean square of what is left, learnt from and held out [N]."""
        from er_model_lab.residual.errors import errors

        p = self.problem
        both = [errors(p, residual, mask).rmse for mask in (p.train, p.held_out)]
        return Errors(*(e if np.isfinite(e) else None for e in both))


def look(
    data: Dataset, model: Model, *, whole: Sequence[Record] | None = None, work: Work = HERE
) -> Sight:
    """Open data for a model; nothing is searched, so long data are taken whole.

    whole: the records in their order that those of the data are pieces of; None: they are whole.

    Raises:
        InputError: Data that are too short.
        MissingChannel: No force, or no motion.
    """
    from er_model_lab.level.damper import DamperLevel, opened
    from er_model_lab.preflight.check import admitted

    found, records = admitted(data.records, model, model.catalogue, anyway=True)
    usable = DamperLevel().usable(data.with_records(records))
    problem = opened(usable, model, work=work).problem
    m, t = problem.motion, np.empty(problem.motion.n)
    shift = _shifts(data.records if whole is None else whole, max(0.5, 0.01 * m.n * m.dt))
    parts = []
    for record, (i, j) in zip(usable.records, pairwise(m.starts.tolist()), strict=True):
        move = shift[record.name]
        t[i:j] = record.t[0] + move + np.arange(j - i) * m.dt
        parts.append(Part(record.name, i, j, float(t[i]), float(t[j - 1]), move))
    order = np.argsort(t, kind="stable")
    return Sight(problem, found, t, order, tuple(parts), _undone(model), _tiles(problem))


def _shifts(records: Sequence[Record], gap: float) -> dict[str, float]:
    """What brings the time of each record into the common time [s]: end to end, with a gap [s]."""
    shift, start = dict[str, float](), 0.0
    for record in records:
        shift[record.name] = start - float(record.t[0])
        start += float(record.t[-1] - record.t[0]) + gap
    return shift


def _undone(model: Model) -> tuple[tuple[str, float], ...]:
    from er_model_lab.fitting.velocity_channel import KINEMATIC

    return tuple(
        (f"{name}.{p}", float(v))
        for name in KINEMATIC
        for p, v in model.effects.get(name, {}).items()
    )


def _tiles(problem: Problem) -> Tiles:
    m = problem.motion
    v, x, _ = rms_map(m.v, m.x, np.zeros(m.n), TILES)
    i, j = np.searchsorted(v, m.v, "right") - 1, np.searchsorted(x, m.x, "right") - 1
    inside = (i >= 0) & (i < TILES[0]) & (j >= 0) & (j < TILES[1])
    return Tiles(v, x, np.where(inside, j * TILES[0] + i, -1))


@dataclass(frozen=True)
class Selection:
    """Samples that every view shows: seconds of the common time, ranges of velocity and deflection [SI]; None: all."""

    seconds: tuple[float, float] | None = None
    velocity: tuple[float, float] | None = None
    deflection: tuple[float, float] | None = None

    def mask(self, sight: Sight) -> Mask:
        """Which samples (n,) are selected."""
        m, out = sight.problem.motion, np.ones(sight.t.size, bool)
        for span, y in ((self.seconds, sight.t), (self.velocity, m.v), (self.deflection, m.x)):
            if span is not None:
                out &= (y >= span[0]) & (y <= span[1])
        return out

    @property
    def empty(self) -> bool:
        """Whether nothing is selected, which means all."""
        return self == Selection()


def curve(
    sight: Sight, y: Array, span: tuple[float, float] | None = None, most: int = ON_SCREEN
) -> Curve:
    """Time [s] and values of y (n,) as a screen needs them in a span of time: peaks stay, records are apart."""
    i, j = (0, y.size) if span is None else _rows(sight.t[sight.order], span)
    chosen = sight.order[i:j]
    drawn = min_max(y[chosen], most)
    t, values = sight.t[chosen[drawn]], y[chosen[drawn]]
    breaks = np.searchsorted(drawn, np.flatnonzero(_apart(sight, chosen)) + 1)
    return np.insert(t, breaks, t[breaks]), np.insert(values, breaks, np.nan)


def _apart(sight: Sight, rows: NDArray[np.intp]) -> Mask:
    """Whether the row behind is more than a step away in time, for all of the rows (m,) but the last."""
    return np.asarray(np.diff(sight.t[rows]) > 1.5 * sight.problem.motion.dt)


def _rows(t: Array, span: tuple[float, float]) -> tuple[int, int]:
    """Places of a span in sorted times, with one sample beyond either end."""
    i, j = np.searchsorted(t, span)
    return max(int(i) - 1, 0), min(int(j) + 1, t.size)


def tile_map(sight: Sight, residual: Array, mask: Mask | None = None, fewest: int = 5) -> Array:
    """Rms of what is left [N] per tile (deflection, velocity); nan where there are few samples."""
    tiles, keep = sight.tiles, sight.problem.used & (sight.tiles.at >= 0) & np.isfinite(residual)
    keep = keep if mask is None else keep & mask
    size = TILES[0] * TILES[1]
    count = np.bincount(tiles.at[keep], minlength=size)
    total = np.bincount(tiles.at[keep], residual[keep] ** 2, minlength=size)
    z = np.where(count >= fewest, np.sqrt(total / np.maximum(count, 1)), np.nan)
    return z.reshape(TILES[1], TILES[0])


def loops(
    sight: Sight, forces: Sequence[Array], mask: Mask, most: int = ON_SCREEN
) -> tuple[Array, list[Array]]:
    """Velocity [m/s] and forces [N] of the selected samples, broken where they are not neighbours."""
    chosen = np.flatnonzero(mask)
    rows = chosen[every(chosen.size, most)] if chosen.size else chosen
    step = max(1, -(-chosen.size // most))
    breaks = np.flatnonzero(np.diff(rows) > 2 * step) + 1 if step == 1 else np.zeros(0, int)
    v = np.insert(sight.problem.motion.v[rows], breaks, np.nan)
    return v, [np.insert(f[rows], breaks, np.nan) for f in forces]


def spectrum(sight: Sight, residual: Array, mask: Mask) -> Curve:
    """Frequency [Hz] and amplitude density [N/sqrt(Hz)] of what is left where it is selected."""
    y = np.where(mask & np.isfinite(residual), residual, 0.0)
    share = float(np.mean(mask))
    f, power = welch(y, 1.0 / sight.problem.motion.dt, min(SEGMENT, y.size))
    return np.asarray(f[1:]), np.sqrt(np.asarray(power[1:]) / max(share, 1e-9))


@dataclass(frozen=True)
class Worst:
    """A place where much of the error is: words, its share of the squared error, and what selects it."""

    says: str
    share: float
    selection: Selection


def worst(sight: Sight, residual: Array, most: int = 6) -> list[Worst]:
    """The windows of time and the tiles that carry most of the squared error, heaviest first."""
    square = np.where(sight.problem.used & np.isfinite(residual), residual, 0.0) ** 2
    t, by_time = sight.t[sight.order], square[sight.order]
    whole = float(square.sum()) or 1.0
    edges = np.unique(np.linspace(0, square.size, WINDOWS + 1).astype(int))
    power = np.add.reduceat(by_time, edges[:-1])
    found = []
    for k in np.argsort(power)[::-1][: most // 2]:
        a, b = float(t[edges[k]]), float(t[edges[k + 1] - 1])
        found.append(Worst(f"{a:.1f} to {b:.1f} s", power[k] / whole, Selection(seconds=(a, b))))
    inside = sight.tiles.at >= 0
    power = np.bincount(sight.tiles.at[inside], square[inside], minlength=TILES[0] * TILES[1])
    for k in np.argsort(power)[::-1][: most - most // 2]:
        where = tile(sight, *divmod(int(k), TILES[0]))
        (v, v_to), (x, x_to) = where.velocity or (0.0, 0.0), where.deflection or (0.0, 0.0)
        says = f"{1e3 * v:.3g} to {1e3 * v_to:.3g} mm/s, {1e3 * x:.3g} to {1e3 * x_to:.3g} mm"
        found.append(Worst(says, power[k] / whole, where))
    return sorted((w for w in found if w.share > 0.0), key=lambda w: w.share, reverse=True)


def tile(sight: Sight, row: int, column: int) -> Selection:
    """What selects a tile of the map."""
    v, x = sight.tiles.v, sight.tiles.x
    row, column = min(max(row, 0), TILES[1] - 1), min(max(column, 0), TILES[0] - 1)
    return Selection(
        velocity=(float(v[column]), float(v[column + 1])),
        deflection=(float(x[row]), float(x[row + 1])),
    )


def tile_at(sight: Sight, velocity: float, deflection: float) -> Selection:
    """What selects the tile that holds a velocity [m/s] and a deflection [m]."""
    v, x = sight.tiles.v, sight.tiles.x
    return tile(
        sight,
        int(np.searchsorted(x, deflection, "right")) - 1,
        int(np.searchsorted(v, velocity, "right")) - 1,
    )
