"""How far a rig reaches, as the data show it: written into a model, and kept up where later data go beyond."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import astuple, replace
from typing import Any

import numpy as np
from er_models.model import Array, Model

from er_model_lab.problem.problem import Problem

LEFT = 0.05
"""Share by which data may pass a limit of the rig before it is another rig: motions are noisy."""
OTHER = 2.0
"""Factor from which on it is another rig, whose sensors are others, too."""
SHOWN = {"stroke": (1e3, "mm"), "velocity_max": (1.0, "m/s"), "duty_max": (1.0, "")}
BEFORE, GIVEN = "rig_before", "envelope_before"
"""Keys in the history of a model: its rig and its envelope before a fit."""


def rig_of(x: Array, v: Array, u: Array | None) -> dict[str, float]:
    """Largest |deflection| [m], |velocity| [m/s] and duty of data (n,); no duty where they have none."""
    limits = {"velocity_max": float(np.max(np.abs(v))), "stroke": float(np.max(np.abs(x)))}
    return limits if u is None or not np.any(u) else {"duty_max": float(np.max(u)), **limits}


def kept_up(model: Model, problem: Problem) -> Model:
    """A fitted model whose rig reaches as far as the data, with the old rig and envelope in its last history entry.

    Limits that the data keep stay as they are, and so does a model without a rig.
    """
    reach = rig_of(problem.motion.x, problem.motion.v, problem.motion.u)
    left = {k: v for k, v in reach.items() if k in model.rig and v > (1.0 + LEFT) * model.rig[k]}
    if not left:
        return model
    rig = {**model.rig, **left}
    if any(left[k] > OTHER * model.rig[k] for k in left):
        rig = {k: v for k, v in rig.items() if not k.endswith("_noise")}
    *past, last = model.history or ({},)
    return replace(model, rig=rig, history=(*past, {**last, BEFORE: dict(model.rig)}))


def with_old_envelope(model: Model, before: Model) -> Model:
    """The model with the envelope it had before in its last history entry, where that has changed."""
    if model.scales == before.scales or not model.history:
        return model
    names = ("force", "deflection", "velocity", "duty")
    old = dict(zip(names, map(float, astuple(before.scales)), strict=True))
    *past, last = model.history
    return replace(model, history=(*past, {**last, GIVEN: old}))


def rig_note(model: Model, given: Model) -> tuple[str, ...]:
    """What the fits since a given model have rewritten of its rig, in words; nothing where the data kept to it."""
    made = model.history[len(given.history) :]
    old: Mapping[str, Any] | None = next((e[BEFORE] for e in made if BEFORE in e), None)
    if old is None:
        return ()
    new = model.rig
    said = [
        f"{name} {scale * old[name]:.3g} to {scale * new[name]:.3g} {unit}".rstrip()
        for name, (scale, unit) in SHOWN.items() if name in new and old[name] != new[name]
    ]  # fmt: skip
    other = "; the noise of its sensors is left out, as those of another rig" * (
        len(old) > len(new)
    )
    return (
        f"the data leave the model's rig, which is rewritten: {', '.join(said)}{other} (the history keeps the old one)",
    )
