r"""Whether the error of a model has grown: a sequential test on its power, block by block. Pure.

The power of the error that a block should have is learnt as

.. math:: P = c_0 + c_1 S + c_2 F

with the mean squares S of what an error of the velocity would change in the force, and F of the force itself, each
coefficient at or above zero: noise of the force sensor, noise of the motion, and what the model is off by. So a
rougher road is no alarm. The logarithm of the measured power over P scatters about a mean; a cumulative sum of what it
exceeds that mean by, less half of the change to be found, tells when it has moved.

The limit is Siegmund's for a mean time between false alarms, with the scatter and the mean that were learnt each moved
by as much as they may be wrong. Blocks follow one another nearly without memory; what is left of one is in the scatter.

Source: Page 1954; Siegmund, Sequential Analysis, 1985, (2.57); multiplicative updates of the Itakura-Saito divergence,
Fevotte, Bertin, Durrieu 2009.

Functions take one monitor or many at once: arrays have a last axis of monitors, or none.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import Any

import numpy as np
from er_models.model import Array

HOUR = 3600.0
UPDATES = 100
"""Updates in which the coefficients are found: 1 ms. What they are off by then is in mean and scatter, learnt after."""
SURE = 2.33
"""By so many of its standard deviations what was learnt may be wrong: one in a hundred is further out, on one side."""
LAGS = 4
"""Blocks over which the memory of a block is looked at."""
OVERSHOOT = 1.166
"""Twice Siegmund's correction for the jump over the limit, in standard deviations."""
AT_LEAST = 3
"""Blocks that an alarm takes: one that is wild, a stone under the wheel for instance, is none."""
CALM = 40
"""Blocks that take the sum of an alarm down by one limit at least: 10 s of motion."""


@dataclass(frozen=True)
class Rules:
    """What is to be found, and how often it may be called in vain.

    block: length of a block of motion [s]; blocks: how many are learnt from; change: by how much of itself the error
    grows, to be found; between: mean time of motion between false alarms [s].
    """

    block: float = 0.25
    blocks: int = 240
    change: float = 0.3
    between: float = 24.0 * HOUR

    @property
    def step(self) -> float:
        """The change in the logarithm of the power."""
        return 2.0 * math.log1p(self.change)


RULES = Rules()


@dataclass(frozen=True)
class Known:
    """What the error is like where the model explains: coefficients (3,), mean and limit of the sum.

    power: mean square in the blocks learnt from [N2]; sd: scatter of a block; half: what each block is lowered by.
    """

    coefficients: Array
    mean: Any
    sd: Any
    limit: Any
    half: float
    power: Any

    def expected(self, motion: Array) -> Any:
        """Power of the error that blocks (..., 3) should have, their mean logarithm taken in [N2]."""
        return np.exp(self.mean) * _power(motion, self.coefficients)

    def added(self, total: Any, power: Any, motion: Array, *, failing: bool = False) -> Any:
        """The sum after another block, from what it was before.

        While the model fails a block takes little from it: an error crosses zero now and then, and in a gentle motion
        it hides in the noise.
        """
        excess = np.log(power / self.expected(motion)) - self.half
        least = -self.limit / CALM if failing else -math.inf
        return np.maximum(total + np.clip(excess, least, self.limit / AT_LEAST), 0.0)

    def delay(self, change: float, block: float) -> float:
        """How long a change of the error, as a share of itself, takes to be found in the mean [s]; inf: for ever."""
        rise = 2.0 * math.log1p(change) - self.half
        return block * max(AT_LEAST, 1.0 + float(self.limit) / rise) if rise > 0.0 else math.inf


def learnt(rules: Rules, power: Array, motion: Array, floor: float = 0.0) -> Known:
    """What blocks tell of the error.

    power (n, ...): mean square of the error of each block [N2]; motion (n, ..., 3): 1, S and F as above [N2]; floor:
    what the error of the model is known to be [N], 0: as large as it was in these blocks.
    """
    power = np.maximum(power, np.finfo(float).tiny)
    c = _coefficients(power, motion)
    y = np.log(power / _power(motion, c))
    mean, n = y.mean(axis=0), y.shape[0]
    if floor > 0.0:
        mean = mean - np.log(power.mean(axis=0) / floor**2)
    own, sd = y.std(axis=0, ddof=1), _scatter(y)
    sure = sd * math.sqrt(1.0 + SURE * math.sqrt(2.0 / n))
    half = 0.5 * rules.step
    # where so little is known the promise cannot be kept: the limit is then the largest that finds anything
    drift = np.maximum(half - SURE * sd / math.sqrt(n), 0.25 * half)
    limit = _limit(drift / sure, rules.between / rules.block) * sure
    return Known(c, mean, own, limit, half, power.mean(axis=0))


def _power(motion: Array, c: Array) -> Array:
    """P of blocks (..., 3)."""
    found: Array = np.maximum((motion * c).sum(axis=-1), np.finfo(float).tiny)
    return found


def _coefficients(power: Array, motion: Array) -> Array:
    """Coefficients (..., 3) at or above zero of which the power of exponential noise is likeliest."""
    size = np.maximum(motion.mean(axis=0), np.finfo(float).tiny)
    x = motion / size
    c = np.ones_like(size) * (power.mean(axis=0) / 3.0)[..., None]
    for _ in range(UPDATES):
        p = _power(x, c)
        up, down = (x * (power / p**2)[..., None]).sum(axis=0), (x / p[..., None]).sum(axis=0)
        c = c * up / np.maximum(down, np.finfo(float).tiny)
    found: Array = c / size
    return found


def _scatter(y: Array) -> Any:
    """Standard deviation of the logarithms (n, ...), with what each block remembers of those before it."""
    w = y - y.mean(axis=0)
    variance = (w * w).mean(axis=0)
    with np.errstate(invalid="ignore"):
        memory = sum(
            (1.0 - k / (LAGS + 1)) * (w[k:] * w[:-k]).mean(axis=0) for k in range(1, LAGS + 1)
        )
    return np.sqrt(np.maximum(variance, variance + 2.0 * memory))


def _limit(drift: Any, blocks: float) -> Any:
    """Limit of a sum that is lowered by `drift` a block, for so many blocks between alarms; in standard deviations."""
    span = np.log1p(2.0 * blocks * drift**2)
    for _ in range(8):
        span = np.log(2.0 * blocks * drift**2 + span + 1.0)
    return np.maximum(span / (2.0 * drift) - OVERSHOOT, 0.0)
