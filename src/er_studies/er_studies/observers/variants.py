"""Every theorem in every form: what it reaches, or why it has no solution."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from typing import NamedTuple

import numpy as np
from er_models.model import Array, Model
from er_observers.forms import form_of
from er_observers.programs import OBSERVERS
from er_observers.scaling import scaling_of
from er_observers.synthesis import nlpv_gridding
from er_observers.synthesis.make import Wish, output_of, solve
from er_observers.synthesis.proof import prove
from er_observers.synthesis.spec import LIPSCHITZ, SLOPE, Spec, SynthesisFailed
from er_observers.synthesis.vertices import vertex_gain

SMALL, NEAR, WHOLE = (0.0, 0.05), (0.0, 0.25), (0.0, 1.0)
"""Ranges of the duty: where the Lipschitz bound still has solutions, below its limit, all."""


class Variant(NamedTuple):
    """One theorem with one wish; observer: as in `make`."""

    title: str
    observer: str
    wish: Wish


class Reached(NamedTuple):
    """What came of a variant.

    gamma: proved, NaN for none; slopes: gamma with the gate as an uncertain slope (LFT), NaN where
    not asked; reason: why there is no gamma, or ''.
    """

    title: str
    gamma: float
    slopes: float
    reason: str


def variants(spec: Spec) -> list[Variant]:
    """The forms of the thesis and ours, about one specification."""
    lipschitz = replace(spec, sector=LIPSCHITZ)
    found = []
    for observer in OBSERVERS:
        for duty in (WHOLE, NEAR, SMALL):
            found += [
                Variant(
                    f"{observer}, {each.sector.name}, duty to {duty[1]:g}",
                    observer,
                    Wish(replace(each, rho=duty)),
                )
                for each in (spec, lipschitz)
            ]
    found += [
        Variant(f"unified, {name}, slope, duty to 1", "unified", Wish(spec, structure=name))
        for name in ("proportional", "integral")
    ]
    printed = Wish(replace(spec, gamma_max=1.0001), "thesis", "absolute")
    found += [
        Variant("nlpv_polytopic, as printed: absolute, C_z, gamma 1.0001", "nlpv_polytopic", printed),
        Variant("unified, absolute velocities, slope", "unified", Wish(spec, coordinates="absolute")),
        Variant("nlpv_polytopic, C_z without absolute velocities", "nlpv_polytopic", Wish(spec, "thesis")),
        Variant("nlpv_polytopic, all states", "nlpv_polytopic", Wish(spec, "states")),
        Variant("nlpv_polytopic, deflection sensor 1 mm", "nlpv_polytopic", Wish(spec, deflection=1e-3)),
        Variant("unified, deflection sensor 1 mm", "unified", Wish(spec, deflection=1e-3)),
    ]  # fmt: skip
    return found


def reach(model: Model, variant: Variant) -> Reached:
    """Solve and prove one variant."""
    try:
        claim = solve(variant.observer, model, variant.wish)
    except SynthesisFailed as error:
        return Reached(
            variant.title, np.nan, np.nan, f"{error.reason} (solver: {error.solver_status})"
        )
    _, failed = prove(claim)
    if failed:
        return Reached(variant.title, np.nan, np.nan, f"the solver's answer is no proof: {failed}")
    low = 0.0 if variant.wish.spec.sector is SLOPE else -1.0
    try:
        slopes = vertex_gain(claim, low)
    except SynthesisFailed:
        slopes = np.nan
    return Reached(variant.title, claim.solution.gamma, slopes, "")


def rate_bounds(
    model: Model, spec: Spec, duties: dict[str, Array], period: float
) -> Iterator[tuple[str, float, float, float]]:
    """For each duty signal (k,): name, scenario bound of its rate [1/s], gamma there, size of P_1 over that of P.

    The scenario bound is the largest rate between samples; with k of them the next is above it with
    a probability below 1 - 0.001^(1/k), with confidence 0.999 (Calafiore and Campi 2006, one
    unknown). The extremes 0 and one range a sample are given as well.
    """
    form = form_of(model)
    scaling, output = scaling_of(model, form), output_of(Wish(spec), form, model)
    bounds = {name: float(np.abs(np.diff(duty)).max() / period) for name, duty in duties.items()}
    whole = (spec.rho[1] - spec.rho[0]) / period
    for name, rate in {"no change": 0.0, **bounds, "any change within a sample": whole}.items():
        s = nlpv_gridding.solve(form, output, spec, scaling, rate)
        size = scaling.state[:, None] * scaling.state
        share = np.linalg.norm(s.P_1 * size) / np.linalg.norm(s.P * size)
        yield name, rate, s.gamma, float(share)
