"""Every effect the generator can hide, the only list."""

from __future__ import annotations

import numpy as np

from test.blind.effect import Effect
from test.blind.errors import BlindError
from test.blind.truth import (
    accelerometer,
    actuation,
    asymmetric_damping,
    bouc_wen_hysteresis,
    cavitation,
    coulomb_friction,
    effectiveness_fade,
    end_stop,
    field,
    fluid_inertia,
    force_fade,
    gas_spring,
    joint,
    outside_force,
    outside_signal,
    position_dependent_damping,
    preload,
    quadratic_damping,
    response,
    self_heating,
    sensing,
    shear_thinning,
    stribeck_friction,
    suspension,
    tyre,
    viscoelastic_branch,
)

INSIDE: tuple[Effect, ...] = (
    gas_spring.EFFECT,
    preload.EFFECT,
    coulomb_friction.EFFECT,
    stribeck_friction.EFFECT,
    quadratic_damping.EFFECT,
    asymmetric_damping.EFFECT,
    shear_thinning.EFFECT,
    position_dependent_damping.EFFECT,
    end_stop.EFFECT,
    bouc_wen_hysteresis.EFFECT,
    viscoelastic_branch.EFFECT,
    fluid_inertia.EFFECT,
    joint.BUSH,
    joint.GAP,
    cavitation.EFFECT,
    field.VISCOSITY,
    field.STIFFNESS,
    response.VARYING,
    response.ASYMMETRY,
    actuation.DELAY,
    actuation.LAW,
    actuation.BAND,
    actuation.LAG,
    self_heating.EFFECT,
    effectiveness_fade.EFFECT,
    sensing.DELAY,
    sensing.LAG,
    sensing.VELOCITY,
    sensing.ZERO,
    force_fade.EFFECT,
)

OUTSIDE: tuple[Effect, ...] = (
    outside_force.COGGING,
    outside_signal.HUM,
    outside_force.COUPLING,
    outside_force.MEMORY,
    outside_signal.DRIFT,
    outside_force.STICK,
    outside_signal.RESONANCE,
    outside_signal.CROSSTALK,
)

VEHICLE: tuple[Effect, ...] = (
    tyre.DAMPING,
    tyre.LIFT,
    suspension.FRICTION,
    suspension.STIFFENING,
    suspension.LOAD,
    accelerometer.EFFECT,
)
"""Effects of the car: the damper force along the measured motion does not show them."""

BY_NAME = {effect.name: effect for effect in (*INSIDE, *OUTSIDE, *VEHICLE)}


def choose(effect: str | list[str] | None, rng: np.random.Generator) -> list[Effect]:
    """Effects asked for: none, one, several, or ``random`` (one of the catalogue's own).

    Raises:
        BlindError: an unknown name, or the same effect twice.
    """
    names = [] if effect is None else [effect] if isinstance(effect, str) else list(effect)
    if len(set(names)) != len(names):
        raise BlindError(f"--effect: expected different effects, found {', '.join(names)}")
    chosen = []
    for name in names:
        if name == "random":
            chosen.append(INSIDE[int(rng.integers(len(INSIDE)))])
        elif name in BY_NAME:
            chosen.append(BY_NAME[name])
        else:
            known = ", ".join(BY_NAME)
            raise BlindError(f"--effect: expected one of {known}, random or none, found {name!r}")
    return chosen
