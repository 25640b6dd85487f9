"""What a measured term depends on, how finely, and which symmetry and sign it keeps: blocks of time decide."""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from er_models.model import Array
from numpy.typing import NDArray

from er_model_lab.terms.regression import Normal, normal
from er_model_lab.terms.spline import SPACINGS, Axis, axis, design, mirrored, roughness

COARSE, FINE, SINGLE = 7, 12, (20, 100)
"""Coefficients along a quantity: of two when many terms are compared, of two, and of a single one, which may be smooth
or go up and down many times."""
FEW_STRENGTHS = (1e-4, 1e-2)
STRENGTHS = (1e-7, 1e-6, 1e-5, 1e-4, 1e-3, 1e-2, 1e-1, 1.0, 10.0)
"""Weights of the roughness that are tried."""
TILTS = ((1.0, 10.0), (10.0, 1.0))
"""Weights of the roughness along both quantities, beside equal ones."""
FINALISTS = 3
SIMPLER = 0.02
"""Share of the fall of the mean square that a simpler term may lose and is still taken in place of another."""
ORDER = (
    "velocity", "deflection", "acceleration", "force", "yield_force", "temperature", "formed_duty", "duty",
)  # fmt: skip
"""In which a term names its quantities."""
Parts = tuple[tuple[str, ...], str]
"""Quantities of a term, and what it is multiplied by."""


@dataclass(frozen=True)
class Samples:
    """What a term is learnt from.

    values (n,) of every quantity; jacobian (n, p): of the model's parameters; left (n,): residual of the model [N];
    block (n,): of time, from 0 on, in order.
    """

    values: Mapping[str, Array]
    jacobian: Array
    left: Array
    block: NDArray[np.int64]

    def normal(self, design: Array) -> Normal:
        """Normal equations of parameters and a design (n, k)."""
        return normal(self.jacobian, design, self.left, self.block)


@dataclass(frozen=True)
class Choice:
    """A term as far as its shape goes.

    map (k, r): from its free coefficients to all; weights, strength: of its roughness; shape: in words; held (m, k):
    conditions on its coefficients, none below zero; lag [s]: of the quantity that is lagged; mse: mean square of blocks
    left out [N2]; losses: of each.
    """

    axes: tuple[Axis, ...]
    times: str
    map: Array
    strength: float
    weights: tuple[float, float]
    shape: tuple[str, ...]
    mse: float
    losses: Array
    held: Array | None = None
    lag: float = 0.0

    @property
    def quantities(self) -> tuple[str, ...]:
        """Quantities of the term."""
        return tuple(a.quantity for a in self.axes)

    def design(self, values: Mapping[str, Array]) -> Array:
        """Products of the splines (n, coefficients) along the samples."""
        times = values[self.times] if self.times else None
        return design(self.axes, [values[a.quantity] for a in self.axes], times)

    def penalty(self, equations: Normal) -> Array:
        """Penalty of the equations of all coefficients through `map`."""
        rough = self.map.T @ roughness(self.axes, self.weights) @ self.map
        out = equations.penalty(rough, self.strength)
        return out if self.held is None else equations.pressed(out, self.held @ self.map)


def parts(values: Mapping[str, Array]) -> list[Parts]:
    """Every term that may be: over one quantity or two, and the same times the duty; simplest first."""
    names = [n for n in ORDER if n in values]
    found: list[Parts] = [((a,), "") for a in names]
    found += [(pair, "") for pair in itertools.combinations(names, 2)]
    if "duty" in names:
        others = [n for n in names if n not in ("duty", "formed_duty")]
        found += [((a,), "duty") for a in others]
        found += [(pair, "duty") for pair in itertools.combinations(others, 2)]
    return found


def searched(samples: Samples, base: float, known: Sequence[Parts] = ()) -> Choice:
    """The best term; base: mean square of blocks left out without it [N2]; known: terms that the model holds."""
    able = [p for p in parts(samples.values) if p not in known]
    found = [(p, _coarse(p, samples)) for p in able]
    found.sort(key=lambda f: f[1])
    fall = base - found[0][1]
    single = [f for f in found if len(f[0][0]) == 1 and f[1] < found[0][1] + SIMPLER * fall]
    ahead = dict.fromkeys(p for p, _ in [*found[:FINALISTS], *single[:1]])
    best = [refined(p, samples, base) for p in ahead]
    return simplest(best, base)


def simplest(found: Sequence[Choice], base: float) -> Choice:
    """The best of some terms, or one over a single quantity that does nearly as well."""
    best = min(found, key=lambda c: c.mse)
    near = [c for c in found if c.mse <= best.mse + SIMPLER * max(base - best.mse, 0.0)]
    return min(near, key=lambda c: (len(c.quantities) + bool(c.times), c.mse))


def _coarse(p: Parts, samples: Samples) -> float:
    """Mean square of blocks left out with few coefficients, which says which quantities matter."""
    spacings = ["dense at zero" if q == "velocity" else "as often" for q in p[0]]
    times, found = samples.values[p[1]] if p[1] else None, []
    for many in (COARSE,) if len(p[0]) > 1 else SINGLE:
        axes = _axes(p[0], samples, many, spacings)
        equations = samples.normal(design(axes, [samples.values[q] for q in p[0]], times))
        rough = roughness(axes)
        penalties = (equations.penalty(rough, w) for w in FEW_STRENGTHS)
        found += [equations.mean(equations.judged(penalty)) for penalty in penalties]
    return min(found)


def _axes(
    quantities: Sequence[str], samples: Samples, many: int, spacings: Sequence[str]
) -> tuple[Axis, ...]:
    """Axes of some quantities, with knots spaced in one of the ways each."""
    both = zip(quantities, spacings, strict=True)
    return tuple(axis(q, samples.values[q], many, spacing) for q, spacing in both)


def refined(p: Parts, samples: Samples, base: float) -> Choice:
    """A term over given quantities: spacing, symmetry and strength of what makes it smooth."""
    sizes = (FINE,) if len(p[0]) > 1 else SINGLE
    knots = (
        _axes(p[0], samples, many, [spacing] * len(p[0])) for many in sizes for spacing in SPACINGS
    )
    return min((_shaped(axes, p[1], samples, base) for axes in knots), key=lambda c: c.mse)


def _shaped(axes: tuple[Axis, ...], times: str, samples: Samples, base: float) -> Choice:
    """Symmetry and strength on given knots: odd or even where that loses next to nothing."""
    whole = np.eye(int(np.prod([a.many for a in axes])))
    empty = Choice(axes, times, whole, 0.0, (1.0, 1.0), (), np.inf, np.empty(0))
    equations = samples.normal(empty.design(samples.values))
    found = [_smooth(empty, equations, base)]
    if any(a.turns for a in axes):
        for word, sign in (("odd", -1.0), ("even", 1.0)):
            half = replace(empty, map=mirrored(axes, sign), shape=(word,))
            found.append(_smooth(half, equations, base))
    best = min(found, key=lambda c: c.mse)
    near = [c for c in found if c.mse <= best.mse + SIMPLER * max(base - best.mse, 0.0)]
    return next((c for c in near if c.shape), best)


def _smooth(choice: Choice, equations: Normal, base: float) -> Choice:
    """A choice with the roughness along each quantity that does best, as smooth as loses next to nothing."""
    own = equations.through(choice.map)

    def judged(strength: float, weights: tuple[float, float]) -> Choice:
        made = replace(choice, strength=strength, weights=weights)
        losses = own.judged(made.penalty(own))
        return replace(made, losses=losses, mse=own.mean(losses))

    found = [judged(s, (1.0, 1.0)) for s in STRENGTHS]
    best = min(found, key=lambda c: c.mse)
    tilts = TILTS if len(choice.axes) > 1 else ()
    found += [judged(best.strength * s, t) for t in tilts for s in (0.1, 1.0, 10.0)]
    best = min(found, key=lambda c: c.mse)
    near = [
        c
        for c in found
        if c.weights == best.weights and c.mse <= best.mse + SIMPLER * max(base - best.mse, 0.0)
    ]
    return max(near, key=lambda c: c.strength)


def conditioned(choice: Choice, samples: Samples, base: float) -> Choice:
    """The choice kept monotone in a quantity, or taking energy, where that loses next to nothing.

    The model's parameters stay where they were best: a stiffness would else make anything rise with the deflection.
    """
    design = choice.design(samples.values)
    own = samples.normal(design).through(choice.map)
    moved = samples.jacobian @ own.solved(choice.penalty(own))[: own.params]
    nothing = np.empty((moved.size, 0))
    alone = replace(samples, jacobian=nothing, left=samples.left - moved)
    own = alone.normal(design).through(choice.map)
    free = own.mean(own.judged(choice.penalty(own)))
    for words, held in _conditions(choice):
        tried = replace(choice, held=held, shape=(*choice.shape, words))
        if own.mean(own.judged(tried.penalty(own))) < free + SIMPLER * (base - choice.mse):
            return tried
    return choice


def _conditions(choice: Choice) -> list[tuple[str, Array]]:
    """Conditions that may hold, each in words and as rows (m, k) that take the coefficients to what is not below zero.

    Coefficients that rise make a spline that rises. A force takes energy where it has the sign of the velocity.
    """
    sizes = [a.many for a in choice.axes]
    place = np.arange(int(np.prod(sizes))).reshape(sizes)
    eye = np.eye(place.size)
    out = []
    for k, each in enumerate(choice.axes):
        first = np.take(place, range(sizes[k] - 1), k).ravel()
        second = np.take(place, range(1, sizes[k]), k).ravel()
        for word, sign in (("rising", 1.0), ("falling", -1.0)):
            out.append((f"{word} with {each.quantity}", sign * (eye[second] - eye[first])))
    if "velocity" in choice.quantities:
        grid = np.meshgrid(*(_middles(a) for a in choice.axes), indexing="ij")
        points = [g.ravel() for g in grid]
        way = np.sign(points[choice.quantities.index("velocity")])
        out.append(("dissipative", way[:, None] * design(choice.axes, points)))
    return out


def _middles(each: Axis) -> Array:
    """Where each coefficient of an axis acts most (Greville abscissae)."""
    return np.array([float(np.mean(each.knots[i + 1 : i + 4])) for i in range(each.many)])
