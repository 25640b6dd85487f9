"""What becomes of values that new data say nothing of: they are kept, within an envelope that allows them."""

from __future__ import annotations

from dataclasses import astuple, replace
from itertools import product

import numpy as np
from er_models.errors import InputError
from er_models.model import Model
from er_models.scales import Scales

from er_model_lab.fitting.fit import Box
from er_model_lab.problem.problem import Problem

UNFELT = 1e-6
"""Change of the force, over its size, below which the data say nothing of a value."""
NO_DUTY = 1e-3
"""Largest duty [1] of data without a field."""


def with_unfelt(found: Model, given: Model, problem: Problem) -> Model:
    """A fitted model with the given values that the force does not feel.

    Fits begin within the bounds that the data set. A stop at 9 mm would be written as one at 6 mm after a record of
    3 mm, which tells nothing of it. Of a field without a duty a search may have kept any start.
    """
    box = Box(given, problem.forward.free(given), problem.scales, problem.forward.limits)
    begun = box.model_at(box.start())
    felt = UNFELT * problem.scales.force
    for effect, name in box.free:
        value = given.value(effect, name)
        if effect not in found.effects or found.value(effect, name) == value:
            continue
        told = np.isfinite(found.deviations.get(effect, {}).get(name, np.inf))
        if told and begun.value(effect, name) == value:
            continue
        kept = found.with_effect(effect, {**found.effects[effect], name: value})
        if np.max(np.abs(problem.predict(kept) - problem.predict(found))) <= felt:
            found = kept
    return found


def in_bounds(model: Model, problem: Problem, given: Scales) -> Model:
    """The model with the envelope of the data, as far as every value lies in its bounds there, else the given one's.

    Raises:
        InputError: A value is beyond its bounds in either.
    """
    data = problem.scales
    if float(problem.motion.u.max()) <= NO_DUTY:
        data = replace(data, duty=given.duty)
        model = _without_field(model, data, given)
    sizes = tuple(zip(astuple(data), astuple(given), strict=True))
    for choice in sorted(product((0, 1), repeat=len(sizes)), key=sum):
        scaled = replace(model, scales=Scales(*(s[k] for s, k in zip(sizes, choice, strict=True))))
        outside = _outside(scaled)
        if outside is None:
            return scaled
    assert outside is not None
    effect, name = outside
    low, high = scaled.bounds(effect, name)
    unit = scaled.catalogue[effect].parameter(name).unit
    expected, found = f"{low:.4g} to {high:.4g} {unit}", f"{scaled.value(effect, name):.6g}"
    raise InputError(model.name, f"effects.{effect}.{name}", expected, found)


def _without_field(model: Model, *scales: Scales) -> Model:
    """The model with neutral values per duty where a search left a start that none of the scales allows.

    Without a field no force feels them.
    """
    for effect, values in model.effects.items():
        for q in model.catalogue[effect].parameters:
            ends = [(q.low * s.of(q.unit), q.high * s.of(q.unit)) for s in scales]
            allowed = any(low <= values[q.name] <= high for low, high in ends)
            if "/duty" in q.unit and q.neutral is not None and not allowed:
                model = model.with_effect(effect, {**model.effects[effect], q.name: q.neutral})
    return model


def _outside(model: Model) -> tuple[str, str] | None:
    """First parameter, by effect and name, that lies outside its bounds; None when there is none."""
    for effect, values in model.effects.items():
        for q in model.catalogue[effect].parameters:
            low, high = model.bounds(effect, q.name)
            if not low <= values[q.name] <= high and values[q.name] != q.neutral:
                return effect, q.name
    return None
