r"""What units have in common: mixed effects with partial pooling.

.. math:: y_{ij} = \mu + u_i + e_{ij},\quad u_i \sim N(0, \tau^2),\quad e_{ij} \sim N(0, \omega^2 + s_{ij}^2)

y_ij: a value that recording j of unit i gives, s_ij: its known standard deviation; mu: the common value, tau: spread
between units, omega: spread within a unit beyond what s_ij says. tau and omega maximise the restricted likelihood
(Patterson and Thompson 1971). The value of a unit is its best linear unbiased prediction (Robinson 1991): its own mean
drawn towards mu, the more the less is known of it.

Units that differ would widen tau, and so hide each other. They are left out of mu and tau: those that chance gives
one fleet in twenty, found again until nothing changes. To leave out every unit that a false discovery rate
(Benjamini and Hochberg 1995) names would cut the tails of the healthy ones, and make tau too small.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray
from scipy.optimize import minimize
from scipy.stats import t as student

Array = NDArray[np.float64]
Mask = NDArray[np.bool_]
Places = NDArray[np.intp]

RATE = 0.05
"""Share of false ones among the units that are named [1]."""
FEWEST = 4
"""Units from which on a spread between them is known at all."""
ROUNDS = 20
MAD = 1.4826
"""Standard deviation of a normal variable over its median absolute deviation."""


@dataclass(frozen=True)
class Pooled:
    """A parameter over the fleet; arrays (m,) by unit.

    mean: mu with its deviation `sd`; between: tau; within: omega; value, value_sd: of each unit, partially pooled; own,
    own_sd: of its own data alone; weight: share of its own data in `value` [1]; p: probability of a unit that lies as
    far off by chance; core: units that mu and tau come from.
    """

    mean: float
    sd: float
    between: float
    within: float
    value: Array
    value_sd: Array
    own: Array
    own_sd: Array
    weight: Array
    p: Array
    core: Mask


def pooled(unit: Places, y: Array, s: Array, within: float | None = None) -> Pooled | None:
    """A parameter pooled over units 0 to m-1; None for fewer than `FEWEST` units.

    unit: of each value (n,); y, s: values and their deviations (n,), finite; within: omega where it is known already.
    """
    m = int(unit.max(initial=-1)) + 1
    if m < FEWEST:
        return None
    core, seen = _not_far(unit, y, m), set[bytes]()
    for _ in range(ROUNDS):
        found = _fitted(unit, y, s, core, within)
        core = found.p > RATE / m
        if core.sum() < FEWEST or core.tobytes() in seen:
            break
        seen.add(core.tobytes())
    return found


def discoveries(p: Array, rate: float) -> Mask:
    """Which of these probabilities (m,) are named, when at most a share `rate` of the named ones is false."""
    m, order = p.size, np.argsort(p)
    below = np.flatnonzero(p[order] <= rate * np.arange(1, m + 1) / m)
    named = np.zeros(m, bool)
    if below.size:
        named[order[: below[-1] + 1]] = True
    return named


def means(unit: Places, y: Array, variance: Array, m: int) -> tuple[Array, Array]:
    """Weighted mean of each unit (m,) and its variance."""
    weight = np.bincount(unit, 1.0 / variance, m)
    return np.bincount(unit, y / variance, m) / weight, 1.0 / weight


def _not_far(unit: Places, y: Array, m: int) -> Mask:
    """Units (m,) that are not far off beside the median of all, to begin with."""
    own = np.array([np.median(y[unit == k]) for k in range(m)])
    off = np.abs(own - np.median(own))
    found: Mask = off <= 3.0 * MAD * np.median(off) + 1e-12 * np.abs(own).max()
    return found


def _fitted(unit: Places, y: Array, s: Array, core: Mask, within: float | None) -> Pooled:
    """Everything, with mu and tau of the units in `core` (m,)."""
    m, kept = core.size, core[unit]
    names = np.cumsum(core) - 1
    tau, omega = _spreads(names[unit[kept]], y[kept], s[kept], within)
    own, v = means(unit, y, _variance(s, omega), m)
    w = np.where(core, 1.0 / (tau**2 + v), 0.0)
    mean, var = float(np.sum(w * own) / w.sum()), float(1.0 / w.sum())
    weight = tau**2 / (tau**2 + v)
    value = mean + weight * (own - mean)
    value_sd = np.sqrt(weight * v + (1.0 - weight) ** 2 * var)
    # a unit of the core is held against the others: it is a part of their mean
    share = w * var
    sd = np.sqrt(np.where(core, (tau**2 + v) * (1.0 - share), tau**2 + v + var))
    freedom = max(int(core.sum()) - 2, 1)
    p = 2.0 * student.sf(np.abs(own - mean) / np.maximum(sd, 1e-300), freedom)
    return Pooled(mean, var**0.5, tau, omega, value, value_sd, own, np.sqrt(v), weight, p, core)


def _variance(s: Array, omega: float) -> Array:
    """Variance of each value (n,); never zero."""
    return np.maximum(s**2 + omega**2, 1e-300)


def _spreads(unit: Places, y: Array, s: Array, within: float | None) -> tuple[float, float]:
    """Tau and omega by restricted maximum likelihood."""
    m = int(unit.max()) + 1
    size = float(np.sqrt(np.mean((y - y.mean()) ** 2))) or 1.0
    repeated = np.bincount(unit, minlength=m).max() > 1 and within is None
    known = 0.0 if within is None else within

    def cost(log: Array) -> float:
        tau = size * np.exp(log[0])
        omega = size * np.exp(log[1]) if repeated else known
        variance = _variance(s, omega)
        own, v = means(unit, y, variance, m)
        total = tau**2 + v
        w = 1.0 / total
        mean = np.sum(w * own) / w.sum()
        inner = (
            np.sum((y - own[unit]) ** 2 / variance) + np.sum(np.log(variance)) - np.sum(np.log(v))
        )
        return float(
            inner + np.sum(np.log(total)) + np.log(w.sum()) + np.sum(w * (own - mean) ** 2)
        )

    bounds = [(-12.0, 3.0)] * (2 if repeated else 1)
    starts = [[-0.3, -2.0], [-3.0, -0.5]] if repeated else [[-0.3], [-4.0]]
    best = min(
        (minimize(cost, x, bounds=bounds, method="L-BFGS-B") for x in starts), key=lambda f: f.fun
    )
    tau = size * float(np.exp(best.x[0]))
    return tau, size * float(np.exp(best.x[1])) if repeated else known
