"""Effects the demonstration can hide in its plant, with strengths drawn from a seed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from er_models.errors import UnknownName
from er_models.model import Model

RANGES: dict[str, dict[str, tuple[float, float]]] = {
    "coulomb_friction": {"F_c": (0.6, 1.2), "v_0": (0.002, 0.004)},
    "quadratic_damping": {"c_2": (150.0, 300.0)},
    "asymmetric_damping": {"c_a": (10.0, 20.0)},
    "gas_spring": {"k_2": (4e4, 8e4), "k_3": (8e6, 1.6e7)},
    "preload": {"F_0": (0.4, 1.0)},
    "bouc_wen_hysteresis": {"F_h": (0.8, 1.5), "F_u": (0.0, 0.0), "z_y": (3e-4, 6e-4)},
    "shear_thinning": {"n": (0.55, 0.75), "v_r": (0.015, 0.025)},
    "field_viscosity": {"c_u": (70.0, 120.0)},
    "field_stiffness": {"k_u": (1200.0, 2000.0)},
    "dead_time": {"T_d": (0.008, 0.016)},
    "rise_fall_asymmetry": {"r": (1.5, 2.0)},
    "duty_dead_band": {"u_0": (0.03, 0.05)},
    "force_lag": {"T_f": (0.004, 0.008)},
}
"""Range of every parameter [SI]: sizes reported for dampers of this class, within what the catalogue allows."""

SPREAD = 0.06
"""Parameters of the damper itself are off by up to this share, as on any real rig."""


def choose(effect: str, seed: int) -> str | None:
    """The effect to hide: a name, `none`, or one at random; raises `UnknownName` for others."""
    if effect == "none":
        return None
    names = tuple(RANGES)
    if effect == "random":
        return str(np.random.default_rng(seed).choice(names))
    if effect not in RANGES:
        raise UnknownName("effect to hide", effect, (*names, "none", "random"))
    return effect


def hide(damper: Model, effect: str | None, seed: int) -> Model:
    """The damper with its own values a little off, and the effect in it at a random strength."""
    rng = np.random.default_rng((seed, 1))
    effects = {
        name: {
            key: value * (1.0 + SPREAD * rng.uniform(-1.0, 1.0)) for key, value in values.items()
        }
        for name, values in damper.effects.items()
    }
    model = replace(damper, name="hidden", effects=effects, history=())
    if effect is None:
        return model
    return model.with_effect(
        effect, {k: float(rng.uniform(*span)) for k, span in RANGES[effect].items()}
    )
