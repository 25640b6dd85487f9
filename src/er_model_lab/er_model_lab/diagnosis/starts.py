"""Where the fit of an effect begins: multiples of the natural scales, over many sizes where it has a gap."""

from __future__ import annotations

import itertools

import numpy as np
from er_models.effect import SMOOTH, Effect, arguments

from er_model_lab.problem.problem import Problem

GAPS, NARROWEST, WIDEST = 9, 0.1, 3.0
"""Gaps that are looked at, and the first and the last of them as shares of the least and the largest start."""


def starts(effect: Effect, problem: Problem) -> list[dict[str, float]]:
    """Combinations of starting values of an effect [SI], at most eight."""
    scales = problem.scales
    grids = [[s * scales.of(q.unit) for s in q.starts] for q in effect.parameters]
    points = list(itertools.islice(itertools.product(*grids), 8))
    return [dict(zip(effect.names, point, strict=True)) for point in points]


def amplitudes(effect: Effect) -> list[int]:
    """Places of the parameters that switch the effect on: those of a finite neutral value, refinements left out."""
    return [
        i
        for i, q in enumerate(effect.parameters)
        if q.neutral is not None and np.isfinite(q.neutral) and not q.optional
    ]


def of_each_form(effect: Effect, points: list[dict[str, float]]) -> list[dict[str, float]]:
    """The first of some starts of each form that refinements give the effect: fits do not get from one to another."""
    form = [q.name for q in effect.parameters if q.optional]
    first = {tuple(p[name] for name in form): p for p in reversed(points)}
    return [p for p in points if p in first.values()]


def is_limit(effect: Effect) -> bool:
    """Whether one value of the car says from where on something is cut off."""
    return effect.stage == "vehicle" and len(effect.parameters) == 1 and not amplitudes(effect)


def is_gap(effect: Effect) -> bool:
    """Whether the first parameter is a gap: below it nothing is felt, and each one has a valley of its own."""
    q = effect.parameters[0]
    return effect.stage != "vehicle" and q.unit == "m" and q.neutral == 0.0 and q.step > SMOOTH


def play(effect: Effect) -> str:
    """The parameter that is the play of an effect, the first argument of its `bound`; '' where it has none."""
    first = arguments(effect.hooks["bound"])[:1] if "bound" in effect.hooks else ()
    own = [
        q.name for q in effect.parameters if q.name in first and q.unit == "m" and q.step > SMOOTH
    ]
    return next(iter(own), "")


def gaps(effect: Effect, problem: Problem) -> list[dict[str, float]]:
    """Starting values of an effect over many sizes of its gap; empty where it has none.

    What a gap does grows neither in a straight line with it nor smoothly, so that a start far off stays there.
    """
    if not is_gap(effect):
        return []
    q, *_ = effect.parameters
    sizes = np.geomspace(NARROWEST * min(q.starts), WIDEST * max(q.starts), GAPS)
    others = {tuple((k, v) for k, v in p.items() if k != q.name) for p in starts(effect, problem)}
    scale = problem.scales.of(q.unit)
    return [{q.name: float(s * scale), **dict(rest)} for s in sizes for rest in sorted(others)]


def scaled(
    point: dict[str, float], effect: Effect, amplitude: float, problem: Problem
) -> dict[str, float]:
    """Start with its amplitudes moved towards the size that fits the residual in a straight line."""
    out = dict(point)
    factor = float(np.clip(amplitude, -3.0, 3.0))
    for i in amplitudes(effect):
        q = effect.parameters[i]
        scale, neutral = problem.scales.of(q.unit), q.neutral or 0.0
        value = neutral * scale + factor * (point[q.name] - neutral * scale)
        low, high = q.low * scale, q.high * scale
        inside = min(max(value, low), high)
        out[q.name] = point[q.name] if inside in (low, high) else inside
    return out
