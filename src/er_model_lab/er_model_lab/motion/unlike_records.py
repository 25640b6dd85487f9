"""Records whose force differs at the same motion: something differs between them that no channel tells.

Samples are sorted into cells of deflection, velocity and duty. In a cell that two records share, the one's force may
lie above the other's, as much in extension as in compression: another level. Or it is wider: above in one direction,
below in the other. Heat, frequency and history, which effects of one damper bring, do less than `LEVEL` and `WIDER`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]

CELLS = np.array([6, 8, 10])
"""Cells of deflection, speed and duty over the range of all records; the slowest, where a force turns, do not count."""
LEAST, COMMON = 10, 3
"""Samples that a cell needs, and cells of one direction that two records must share."""
NEAR = 0.3
"""Part of a cell by which the mean deflection, speed and duty of two records may differ in it."""
LEVEL, WIDER = 2.0, 3.0
"""Difference of levels over the width, and ratio of the widths, from which on two records are unlike."""
MOST = 0.9
"""Share of the shared cells that must say so."""
REFERENCES = 3
"""Records with most cells that all others are compared with."""
REMEDY = "take the difference off, give what differs as a channel, or ask each record alone"


@dataclass(frozen=True)
class Course:
    """What a record drives and feels: deflection [m], velocity [m/s], duty and force [N], each (n,)."""

    name: str
    x: Array
    v: Array
    u: Array
    force: Array


@dataclass(frozen=True)
class Unlike:
    """Two records that differ: how far the first one's level is above the other's [N], else how much wider it is."""

    name: str
    other: str
    level: float = 0.0
    wider: float = 1.0

    @property
    def size(self) -> float:
        """How much they differ, beside others."""
        return self.level or self.wider

    def __str__(self) -> str:
        if self.level:
            return (
                f"at the same motion the force of {self.name} is {self.level:.3g} N above that of {self.other}: "
                "a pressure, a load or the zero of a sensor differs that no channel tells"
            )
        return (
            f"at the same motion the force of {self.name} is {self.wider:.2g} times that of {self.other}: "
            "a current, a pressure or a temperature differs that no channel tells"
        )


def unlike(courses: Sequence[Course]) -> Unlike | None:
    """The two records that differ most at the same motion; None where all agree, or share too little of it."""
    courses = [whole for c in courses if (whole := _whole(c)).x.size]
    if len(courses) < 2:
        return None
    seen = _by_cells(courses)
    known = [int(np.isfinite(s.force).sum()) for s in seen]
    found = list[Unlike]()
    for k in np.argsort(known, kind="stable")[::-1][:REFERENCES]:
        found += [u for j, other in enumerate(seen) if j != k and (u := _compared(seen[k], other))]
    return max(found, key=lambda each: each.size, default=None)


def difference(found: Unlike, courses: Sequence[Course]) -> float:
    """How much the same two records differ [N] in levels or widths, as they were found to, where they feel this."""
    one, other = _by_cells([
        _whole(next(c for c in courses if c.name == name)) for name in (found.name, found.other)
    ])  # fmt: skip
    usual = [float(np.median(d)) for d in _apart(one, other) if d.size >= COMMON]
    if not usual:
        return 0.0
    return abs(sum(usual) / len(usual) if found.level else 0.5 * (usual[-1] - usual[0]))


def _by_cells(courses: Sequence[Course]) -> list[_Seen]:
    """Records by the same cells."""
    places = [np.column_stack([c.x, np.abs(c.v), c.u]) for c in courses]
    low = np.min([p.min(axis=0) for p in places], axis=0)
    size = (np.max([p.max(axis=0) for p in places], axis=0) - low) / CELLS
    size[size <= 0.0] = 1.0
    return [_seen(c, (p - low) / size) for c, p in zip(courses, places, strict=True)]


def _whole(course: Course) -> Course:
    """The samples of which nothing is missing."""
    signals = np.stack([course.x, course.v, course.u, course.force])
    return Course(course.name, *signals[:, np.isfinite(signals).all(axis=0)])


@dataclass(frozen=True)
class _Seen:
    """A record by cells, nan where it has few samples.

    force: mean [N] in compression and extension (cells, 2); place: where in the cell they are (cells, 2, 3); width:
    half the difference of its mean forces in both directions [N].
    """

    name: str
    force: Array
    place: Array
    width: float


def _seen(course: Course, place: Array) -> _Seen:
    """A record by cells; place: of each sample (n, 3), in cells."""
    index = np.minimum(place.astype(np.int64), CELLS - 1)
    row = 2 * np.ravel_multi_index(tuple(index.T), tuple(CELLS)) + (course.v > 0.0)
    good = index[:, 1] > 0
    n = 2 * int(CELLS.prod())
    count = np.bincount(row[good], minlength=n)
    sums = [np.bincount(row[good], y, minlength=n) for y in (course.force[good], *place[good].T)]
    with np.errstate(invalid="ignore", divide="ignore"):
        means = np.where(count >= LEAST, np.asarray(sums) / count, np.nan)
    up, down = (course.force[good & side] for side in (course.v > 0.0, course.v < 0.0))
    width = 0.5 * abs(float(up.mean() - down.mean())) if up.size and down.size else 0.0
    return _Seen(course.name, means[0].reshape(-1, 2), means[1:].T.reshape(-1, 2, 3), width)


def _compared(one: _Seen, other: _Seen) -> Unlike | None:
    """How two records differ in the cells that they share; None where they do not."""
    apart = [d for d in _apart(one, other) if d.size >= COMMON]
    width = 0.5 * (one.width + other.width)
    if not apart or not width > 0.0:
        return None
    usual = [float(np.median(d)) for d in apart]
    level = sum(usual) / len(usual)
    clear = all(np.mean(d * level > 0.0) >= MOST for d in apart)
    if clear and abs(level) >= LEVEL * width * (1.0 if len(apart) == 2 else WIDER - 1.0):
        high, low = (one, other) if level > 0.0 else (other, one)
        return Unlike(high.name, low.name, level=abs(level))
    if len(apart) < 2:
        return None
    down, up = apart
    wide, narrow = (one, other) if usual[1] > usual[0] else (other, one)
    both = np.mean(up * usual[1] > 0.0) >= MOST and np.mean(down * usual[0] > 0.0) >= MOST
    if both and usual[0] * usual[1] < 0.0 and wide.width >= WIDER * narrow.width > 0.0:
        return Unlike(wide.name, narrow.name, wider=wide.width / narrow.width)
    return None


def _apart(one: _Seen, other: _Seen) -> list[Array]:
    """Difference of the forces [N] in the cells that two records share, in compression and in extension."""
    shared = np.abs(one.place - other.place).max(axis=2) <= NEAR  # nan is not
    return [(one.force - other.force)[shared[:, k], k] for k in (0, 1)]
