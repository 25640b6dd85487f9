"""Which parameter is estimated in which stage: read off what it changes, not off its name."""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
from er_models.effect import Effect
from er_models.model import Array, Model
from er_models.prediction import Motion, predict, predict_many
from numpy.typing import NDArray

from er_model_lab.fitting.fit import Box
from er_model_lab.problem.forward import Free, free_parameters
from er_model_lab.problem.problem import Problem

SEEN = 1e-6
"""Change of the force over its size from which a parameter counts as having an influence."""


@dataclass(frozen=True)
class Roles:
    """Parameters that act without field, those that shape the yield force, and those of its response time.

    What is in none of them (a dead time, an amplifier) shows only while the duty changes: it is left to the
    joint refinement.
    """

    linear: Free
    shape: Free
    response: Free


def delays_yield(effect: Effect) -> bool:
    """Whether an effect gives or scales the response time of the yield force."""
    return not {"response_time", "tau_scale"}.isdisjoint(effect.hooks)


def static(model: Model) -> Model:
    """The model whose yield force follows at once (1.10), (1.5)."""
    kept = {k: v for k, v in model.effects.items() if not delays_yield(model.catalogue[k])}
    return replace(model, effects=kept)


def roles(model: Model, problem: Problem) -> Roles:
    """Sort the fitted parameters of a model by their influence along the motion of a problem."""
    free = free_parameters(model)
    response = tuple((e, p) for e, p in free if delays_yield(model.catalogue[e]))
    rest = tuple(q for q in free if q not in response)
    bare, m = static(model), problem.motion
    held = _influential(bare, rest, replace(m, u=np.full(m.n, problem.scales.duty)), problem)
    off = _influential(bare, rest, replace(m, u=np.zeros(m.n)), problem)
    linear = tuple(q for q, seen in zip(rest, off, strict=True) if seen)
    shape = tuple(q for q, a, b in zip(rest, held, off, strict=True) if a and not b)
    return Roles(linear, shape, response)


def _influential(model: Model, free: Free, motion: Motion, problem: Problem) -> NDArray[np.bool_]:
    """Mask of the parameters that change the force, tried from where the effect acts."""
    if not free:
        return np.zeros(0, bool)
    box = Box(model, free, problem.scales)
    middle = np.where(box.start() == 0.0, box.size, box.start())
    acting = box.model_at(middle)
    changed = middle + 0.1 * np.diag(np.maximum(np.abs(middle), box.size))
    change: Array = predict_many(acting, box.vectors(changed), motion) - predict(acting, motion)
    return np.asarray(np.abs(change).max(axis=1) > SEEN * problem.scales.force)
