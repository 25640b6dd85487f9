"""Splines of a measured term: knots, bases along the samples, what makes them smooth, and their symmetries."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np
from er_models.measured import LAGGED, ORDER
from er_models.model import Array
from scipy.interpolate import BSpline

TURNING = ("deflection", "velocity", "acceleration", "yield_force", "force")
"""Quantities that change their sign with the motion."""
FLAT = 0.02
"""Weight of the slope beside that of the curvature: where nothing was seen a term goes on level."""
LEVELS = 8
"""A quantity of so few values needs no more coefficients than one beyond them."""
SPACINGS = ("even", "as often", "dense at zero")
"""How knots lie: at equal distances, where samples are, or where a motion turns."""


@dataclass(frozen=True)
class Axis:
    """One quantity of a term: its knots (n + 4,), and whether it changes its sign with the motion."""

    quantity: str
    knots: Array

    @property
    def turns(self) -> bool:
        """Whether it changes its sign when the motion does."""
        return self.quantity.removesuffix(LAGGED) in TURNING

    @property
    def many(self) -> int:
        """Number of coefficients."""
        return self.knots.size - ORDER

    def basis(self, values: Array) -> Array:
        """Splines (n, many) at values (n,), held at the ends."""
        inside = np.clip(values, self.knots[0], self.knots[-1])
        return np.asarray(BSpline.design_matrix(inside, self.knots, ORDER - 1).toarray())


def axis(quantity: str, values: Array, many: int, spacing: str) -> Axis:
    """Knots over the range of values (n,), mirrored where the quantity turns with the motion."""
    made = Axis(quantity, np.empty(0))
    few = np.unique(np.round(values, 9))
    if few.size <= LEVELS:
        many = min(many, max(few.size + 1, ORDER))
    low, high = float(values.min()), float(values.max())
    share = np.linspace(0.0, 1.0, many - ORDER + 2)
    if made.turns:
        high = max(abs(low), abs(high))
        low = -high
    knots = low + (high - low) * share
    if spacing == "as often" and few.size > LEVELS:
        both = np.concatenate([values, -values]) if made.turns else values
        knots = 0.5 * (knots + np.quantile(both, share))
    elif spacing == "dense at zero" and made.turns:
        s = 2.0 * share - 1.0
        knots = high * np.sign(s) * np.abs(s) ** 2
    knots[0], knots[-1] = low, high
    ends = np.ones(ORDER - 1)
    return Axis(quantity, np.concatenate([low * ends, knots, high * ends]))


def design(axes: Sequence[Axis], values: Sequence[Array], times: Array | None = None) -> Array:
    """Products of the splines (n, coefficients) along values (n,) of each quantity, times (n,) where it is given."""
    out = axes[0].basis(values[0])
    for each, value in zip(axes[1:], values[1:], strict=True):
        out = (out[:, :, None] * each.basis(value)[:, None, :]).reshape(value.size, -1)
    return out if times is None else out * times[:, None]


def roughness(axes: Sequence[Axis], weights: Sequence[float] = (1.0, 1.0)) -> Array:
    """Penalty (k, k) of curvature and slope along each quantity, weighted."""
    sizes = [a.many for a in axes]
    total = np.zeros((int(np.prod(sizes)),) * 2)
    for k, (many, weight) in enumerate(zip(sizes, weights, strict=False)):
        eye = np.eye(many)
        bend, slope = np.diff(eye, 2, axis=0), np.diff(eye, axis=0)
        own = bend.T @ bend + FLAT * slope.T @ slope
        parts = [own if i == k else np.eye(m) for i, m in enumerate(sizes)]
        total += weight * (parts[0] if len(parts) == 1 else np.kron(*parts))
    return total


def mirrored(axes: Sequence[Axis], sign: float) -> Array:
    """Map (k, r) from the coefficients of a term that is even (sign 1) or odd (-1) in the motion to all of them."""
    sizes = [a.many for a in axes]
    place = np.arange(int(np.prod(sizes))).reshape(sizes)
    other = place
    for k, each in enumerate(axes):
        other = np.flip(other, k) if each.turns else other
    first, second = place.ravel(), other.ravel()
    keep = (first < second) | ((first == second) & (sign > 0.0))
    out = np.zeros((first.size, int(keep.sum())))
    columns = np.arange(out.shape[1])
    out[second[keep], columns] = sign
    out[first[keep], columns] = 1.0
    return out
