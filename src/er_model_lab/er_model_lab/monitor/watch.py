"""The error of a model sample by sample: blocks of motion, the floor learnt from the first of them, the alarm. Pure."""

from __future__ import annotations

import math
from dataclasses import dataclass
from enum import Enum
from typing import NamedTuple

import numpy as np

from er_model_lab.monitor.sequential import Known, Rules, learnt

HIGHEST = 2.0
"""Limits up to which the sum rises; the alarm is over when it is down at zero again."""
ROLLING = 10.0
"""The error that is shown is that of so much motion [s]."""


class Finding(Enum):
    """What the error says."""

    LEARNING = "learning"
    EXPLAINS = "explains"
    FAILS = "fails"


@dataclass(frozen=True)
class Settings:
    """How a monitor watches.

    rules: of the test; dt: between two samples [s]; moving: least root mean square velocity of a block of motion
    [m/s]; floor: known error of the model [N], 0: it is learnt.
    """

    rules: Rules
    dt: float
    moving: float
    floor: float = 0.0

    @property
    def samples(self) -> int:
        """Of a block."""
        return max(round(self.rules.block / self.dt), 1)

    @property
    def shown(self) -> int:
        """Blocks of which the rolling error is."""
        return max(round(ROLLING / self.rules.block), 1)


class Part(NamedTuple):
    """A sample that is judged: error [N], what an error of the velocity would change [N], force [N], velocity [m/s]."""

    error: float
    doubt: float
    force: float
    velocity: float


class Watch(NamedTuple):
    """What is known of the error.

    sums: samples of the block so far, and sums of the squares of their parts; rows: blocks learnt from, power and
    motion; known: None while there are too few; total: of the test; recent: powers of the last blocks [N2]; expected:
    of the last block [N2]; moved: time of motion that was judged [s]; since: when it failed, by that time.
    """

    sums: tuple[int, float, float, float, float] = (0, 0.0, 0.0, 0.0, 0.0)
    rows: tuple[tuple[float, float, float], ...] = ()
    known: Known | None = None
    total: float = 0.0
    recent: tuple[float, ...] = ()
    expected: float = 0.0
    moved: float = 0.0
    since: float = math.nan

    @property
    def finding(self) -> Finding:
        """What the error says."""
        if self.known is None:
            return Finding.LEARNING
        return Finding.EXPLAINS if math.isnan(self.since) else Finding.FAILS

    @property
    def error(self) -> float:
        """Rolling error [N]; 0 before the first block."""
        return math.sqrt(sum(self.recent) / len(self.recent)) if self.recent else 0.0

    @property
    def usual(self) -> float:
        """What the error of the last block should have been [N]; 0 while it is being learnt."""
        return math.sqrt(self.expected)

    @property
    def ratio(self) -> float:
        """Sum over its limit [1]: above 1 the model no longer explains."""
        return self.total / float(self.known.limit) if self.known is not None else 0.0


def watch(s: Settings, w: Watch, part: Part) -> Watch:
    """After another sample; one that is not finite tells nothing."""
    e, d, f, v = part
    square = e * e + d * d + f * f + v * v
    if not math.isfinite(square):
        return w
    n, ee, dd, ff, vv = w.sums
    n, ee, dd, ff, vv = n + 1, ee + e * e, dd + d * d, ff + f * f, vv + v * v
    if n < s.samples:
        return Watch((n, ee, dd, ff, vv), *w[1:])  # at a third of the time of `_replace`
    w = w._replace(sums=(0, 0.0, 0.0, 0.0, 0.0))
    if vv / n < s.moving**2:  # at rest nothing is seen of most effects
        return w
    return _block(s, w, ee / n, dd / n, ff / n)


def _block(s: Settings, w: Watch, power: float, doubt: float, force: float) -> Watch:
    """After another block of motion."""
    recent = (*w.recent, power)[-s.shown :]
    w = w._replace(recent=recent, moved=w.moved + s.rules.block)
    if w.known is None:
        rows = (*w.rows, (power, doubt, force))
        if len(rows) < s.rules.blocks:
            return w._replace(rows=rows)
        table = np.array(rows)
        motion = np.column_stack([np.ones(len(rows)), table[:, 1:]])
        return w._replace(rows=(), known=learnt(s.rules, table[:, 0], motion, s.floor))
    motion, limit = np.array([1.0, doubt, force]), float(w.known.limit)
    since, failing = w.since, not math.isnan(w.since)
    total = float(w.known.added(w.total, power, motion, failing=failing))
    total = min(total, HIGHEST * limit)
    if total > limit and not failing:
        since = w.moved
    elif total == 0.0:
        since = math.nan
    return w._replace(total=total, since=since, expected=float(w.known.expected(motion)))
