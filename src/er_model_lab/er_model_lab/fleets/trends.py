r"""What changes in one unit: nothing, in a straight line, at once, or from some point on.

The spread within units is that of the whole fleet, so that the size of a change over its deviation is Student's t in a
series that changes nothing. The best of the places where a change may begin is taken; its probability is multiplied by
the number of places. The form is that with the least Bayesian information criterion. A bend stands at
the mean of its places, weighted by their likelihood.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from scipy.optimize import minimize_scalar
from scipy.stats import chi2
from scipy.stats import t as student

from er_model_lab.fleets.pooled import MAD, Array, Places, means

Form = Literal["line", "step", "bend", "groups"]
FEWEST = 4
"""Values from which on a series can show a change."""
PLACES = 40
"""Places between two neighbours' ends where a bend is looked for, in all."""


@dataclass(frozen=True)
class Trend:
    """The best change of a series.

    form: a straight line, a step, or a bend (nothing, then a line); at: where it begins, low and high: where it may;
    change: from the first to the last value; sd: its deviation; p: of a series that changes nothing; criterion:
    Bayesian, beside that of a series of which only the mean is unknown. The form `groups` is that of `two_groups`.
    """

    form: Form
    at: float
    low: float
    high: float
    change: float
    sd: float
    p: float
    criterion: float


def trend(x: Array, y: Array, variance: Array, freedom: int) -> Trend | None:
    """The best change of values y (n,) with these variances along x (n,); None for too few, or all at one place.

    freedom: degrees of freedom that the variances rest on.
    """
    order = np.argsort(x, kind="stable")
    x, y, w = x[order], y[order], 1.0 / variance[order]
    if y.size < FEWEST or not x[-1] > x[0]:
        return None
    left = np.sum(w * (y - np.sum(w * y) / w.sum()) ** 2)
    steps = np.unique(0.5 * (x[1:] + x[:-1])[x[1:] > x[:-1]])
    bends = np.linspace(x[0], x[-1], PLACES, endpoint=False)
    forms: list[tuple[Form, Array, Array, int]] = [
        ("line", x[:1], (x - x[0])[None], 1),
        ("step", steps, (x > steps[:, None]).astype(float), steps.size),
        ("bend", bends[1:], np.maximum(x - bends[1:, None], 0.0), steps.size),
    ]
    found = [_best(form, at, shapes, n, (x, y, w), left, freedom) for form, at, shapes, n in forms]
    p = min(1.0, len(forms) * min(f.p for f in found))
    return replace(min(found, key=lambda f: f.criterion), p=p)


def _best(
    form: Form,
    places: Array,
    shapes: Array,
    n: int,
    series: tuple[Array, Array, Array],
    left: float,
    freedom: int,
) -> Trend:
    """The best place of a form."""
    x, y, w = series
    centred = shapes - (shapes @ w / w.sum())[:, None]
    square = centred**2 @ w
    slopes = np.divide(centred @ (w * y), square, out=np.zeros_like(square), where=square > 0.0)
    gains, reach = slopes**2 * square, shapes[:, -1] - shapes[:, 0]
    k = int(np.argmax(gains))
    near = places[gains >= gains[k] - chi2.ppf(0.9, 1)]
    low, high = float(near.min()), float(near.max())
    if form == "step":
        low, high = float(x[x < low].max(initial=x[0])), float(x[x > high].min(initial=x[-1]))
    chance = np.exp(0.5 * (gains - gains[k]))
    at = float(places @ chance / chance.sum()) if form == "bend" else float(places[k])
    sd = float(reach[k]) / math.sqrt(square[k]) if square[k] > 0.0 else math.inf
    p = min(1.0, n * 2.0 * float(student.sf(math.sqrt(gains[k]), freedom)))
    price = math.log(y.size) * (1 if form == "line" else 2)
    criterion = float(left - gains[k] + price)
    return Trend(form, at, low, high, float(slopes[k] * reach[k]), sd, p, criterion)


def scatter(unit: Places, x: Array, y: Array, s: Array) -> float | None:
    """Spread within units that no slow change widens: of neighbours along x; None where none repeats.

    The median over all of them, so that jumps of a few count little.
    """
    order = np.lexsort((x, unit))
    unit, y, s = unit[order], y[order], s[order]
    same = unit[1:] == unit[:-1]
    if not same.any():
        return None
    step = np.abs(np.diff(y))[same] / math.sqrt(2.0)
    known = np.median((s[1:] ** 2 + s[:-1] ** 2)[same] / 2.0)
    return math.sqrt(max(float((MAD * np.median(step)) ** 2 - known), 0.0))


def spread_within(unit: Places, y: Array, s: Array) -> float:
    """Spread within units beyond the deviations s (n,) of values y (n,), by restricted maximum likelihood."""
    m, size = int(unit.max()) + 1, float(np.std(y)) or 1.0

    def cost(log: float) -> float:
        variance = np.maximum(s**2 + (size * math.exp(log)) ** 2, 1e-300)
        own, v = means(unit, y, variance, m)
        return float(
            np.sum((y - own[unit]) ** 2 / variance) + np.sum(np.log(variance)) - np.sum(np.log(v))
        )

    return size * math.exp(float(minimize_scalar(cost, bounds=(-12.0, 3.0), method="bounded").x))
