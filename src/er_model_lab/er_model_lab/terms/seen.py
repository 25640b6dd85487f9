"""The quantities of measured terms along the samples, as the kernel sees them."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np
from er_models.measured import LAGGED, ORDER, QUANTITIES, MeasuredTerm
from er_models.model import Array, Model

from er_model_lab.problem.problem import Problem

SMALL = 1e-4
"""Size of the force that shows a quantity, over that of the damper: what feeds back does not notice it."""
WIDE = 1e3
"""Range of a quantity that is shown, over its natural scale."""
FEW, EDGE = 0.01, 1e-3
"""Share of samples beyond a range, and of the range, below which there is nothing to say."""
STILL = 1e-6
"""Spread of a quantity, over its natural scale, below which it does not change."""


def probe(quantity: str, wide: float, slope: float, lag: float = 0.0) -> MeasuredTerm:
    """A term in proportion to a quantity, within +-wide of it."""
    knots = (-wide,) * ORDER + (wide,) * ORDER
    line = tuple(slope * wide * share for share in (-1.0, -1.0 / 3.0, 1.0 / 3.0, 1.0))
    return MeasuredTerm((quantity,), (knots,), line, (0.0,) * ORDER, lag=lag)


def seen(
    model: Model, problem: Problem, lags: Sequence[tuple[str, float]] = ()
) -> dict[str, Array]:
    """Values (n,) of every quantity that changes; lags: (quantity with `LAGGED`, time [s]), in place of them all.

    A term in proportion to a quantity adds that quantity to the force, whatever the motion passes on its way.
    """
    scales, out = problem.scales, dict[str, Array]()
    asked = lags or [(name, 0.0) for name in QUANTITIES]
    for name, lag in asked:
        unit = QUANTITIES[name.removesuffix(LAGGED)][1]
        size = scales.duty if unit == "1" else scales.of(unit)
        slope = SMALL * scales.force / size
        bare = replace(model, terms=(probe(name, WIDE * size, 0.0, lag),))
        shown = replace(model, terms=(probe(name, WIDE * size, slope, lag),))
        vectors = np.stack([bare.compiled().p, shown.compiled().p])
        without, with_it = problem.predict_many(shown, vectors)
        value = (with_it - without) / slope
        if np.isfinite(value).all() and np.ptp(value[problem.train]) > STILL * size:
            out[name] = value
    return out


def distinct(values: Mapping[str, Array], problem: Problem) -> dict[str, Array]:
    """Quantities that are no other one again: a formed duty that is the duty, a yield force that is the force."""
    out = dict[str, Array]()
    rows = problem.train
    for name, value in values.items():
        known = (np.corrcoef(value[rows], other[rows])[0, 1] for other in out.values())
        if all(abs(c) < 1.0 - 1e-9 for c in known):
            out[name] = value
    return out


def held(model: Model, problem: Problem) -> tuple[str, ...]:
    """A note on each measured term of a model that many scored samples go beyond, so that it is held constant there."""
    notes = []
    for term in model.terms:
        names = dict.fromkeys(term.quantities)
        values = seen(replace(model, terms=()), problem, [(name, term.lag) for name in names])
        outside = np.zeros(problem.used.size, bool)
        for name, (low, high) in zip(term.quantities, term.ranges, strict=True):
            y = values.get(name, np.full(outside.size, low))
            slack = EDGE * (high - low)
            outside |= (y < low - slack) | (y > high + slack)
        share = float(np.mean(outside[problem.used]))
        if share > FEW:
            notes.append(
                f"{term.name} is held constant in {share:.0%} of the samples: they lie beyond what it learnt"
            )
    return tuple(notes)
