"""Gains of the channels cannot be known: their effect on the force is one of the damper's own parameters.

The derivative of the predicted force by the gain lies in the span of the derivatives by the parameters of the
damper, so no record and no estimator can tell them apart.
"""

from __future__ import annotations

import numpy as np
import pytest
from er_models.catalogue import CATALOGUE
from er_models.effect import Effect
from er_models.model import Array, Model
from er_models.prediction import Motion, motion, predict
from models_help import DT, SMALL, Sine, bingham, guo, started

STEP = 1e-3
"""Relative step of the difference quotients; their error is of the sixth order."""
NOTHING = 1e-7
"""Share of a direction that is left where it is, up to rounding, in the span of others."""

STATIC = {
    "static Guo": ("passive", "guo_yield"),
    "static Bingham": ("passive", "bingham_yield"),
    "dynamic Guo": ("passive", "guo_yield", "response"),
    "dynamic Bingham": ("passive", "bingham_yield", "response"),
}
CORES = {
    **{name: started(SMALL, *effects) for name, effects in STATIC.items()},
    "thesis Guo": guo(),
    "thesis Bingham": bingham(),
}
ABSORBS = {
    "force_gain": {"k0", "c0", "f_c", "sigma"},
    "velocity_gain": {"c0", "c1", "v_0"},
    "duty_gain": {"f_c", "sigma"},
}
"""Parameters of the damper that take up a gain, as its card says."""
GAINS = pytest.mark.parametrize("gain", CATALOGUE.unknowable(), ids=lambda e: e.name)


def rich(seconds: float = 10.0) -> Motion:
    """Six sines of incommensurable frequency with a duty that steps through ten levels."""
    t = np.arange(round(seconds / DT)) * DT
    parts = [Sine(SMALL, share) for share in (0.3, 0.25, 0.2)]
    x, v, a = (
        sum(
            s.derivative(t * (1.0 + 0.37 * i), k) * (1.0 + 0.37 * i) ** k
            for i, s in enumerate(parts)
        )
        for k in range(3)
    )
    levels = SMALL.duty * np.random.default_rng(4).permutation(np.arange(10) / 9.0)
    return motion(DT, x, v, np.repeat(np.resize(levels, t.size // 80 + 1), 80)[: t.size], a)


def column(model: Model, effect: str, name: str, inputs: Motion) -> Array:
    """Derivative of the force by a parameter, times its value (n,)."""
    value, total = model.value(effect, name), np.zeros(inputs.n)
    for factor, weight in ((1, 3.0 / 4.0), (2, -3.0 / 20.0), (3, 1.0 / 60.0)):
        for sign in (1, -1):
            moved = {**model.effects[effect], name: value * (1.0 + sign * factor * STEP)}
            total += sign * weight * predict(model.with_effect(effect, moved), inputs)
    return total / STEP


def columns(model: Model, inputs: Motion) -> dict[str, Array]:
    """Derivatives by all parameters of a model that change its force at all."""
    found = {
        name: column(model, effect, name, inputs)
        for effect, values in model.effects.items()
        for name, value in values.items()
        if value
    }
    return {name: c for name, c in found.items() if np.abs(c).max() > 1e-9 * SMALL.force}


def left(direction: Array, others: dict[str, Array]) -> float:
    """Share of a direction outside the span of others."""
    basis = np.array([c / np.linalg.norm(c) for c in others.values()]).T
    rest = direction - basis @ np.linalg.lstsq(basis, direction, rcond=None)[0]
    return float(np.linalg.norm(rest) / np.linalg.norm(direction))


def condition(directions: dict[str, Array]) -> float:
    """Smallest over largest singular value of the directions, each of length 1."""
    matrix = np.array([c / np.linalg.norm(c) for c in directions.values()]).T
    values = np.linalg.svd(matrix, compute_uv=False)
    return float(values[-1] / values[0])


@pytest.mark.parametrize("core", CORES)
@GAINS
def test_a_gain_is_in_the_span_of_the_dampers_own_parameters(gain: Effect, core: str) -> None:
    inputs = rich()
    own = columns(CORES[core], inputs)
    (parameter,) = gain.names
    for value in (1.0, 1.3):
        model = CORES[core].with_effect(gain.name, {parameter: value})
        direction, at = column(model, gain.name, parameter, inputs), columns(model, inputs)
        del at[parameter]
        assert left(direction, at) < NOTHING
        assert condition({**at, parameter: direction}) < NOTHING
        absorbing = {name: c for name, c in at.items() if name in ABSORBS[gain.name]}
        assert left(direction, absorbing) < NOTHING
    assert condition(own) > 1e-4, "the record must show every parameter of the damper itself"


@pytest.mark.parametrize("core", CORES)
def test_effects_that_can_be_known_are_not_in_that_span(core: str) -> None:
    """The measure tells a gain from a friction, a dead band and a lag of the force."""
    inputs = rich()
    for name, parameter in (
        ("coulomb_friction", "F_c"),
        ("duty_dead_band", "u_0"),
        ("force_lag", "T_f"),
    ):
        model = CORES[core].with_effect(name)
        at = columns(model, inputs)
        direction = at.pop(parameter)
        assert left(direction, at) > 100.0 * NOTHING


def test_a_gain_of_the_duty_shows_where_a_term_is_a_known_function_of_the_duty() -> None:
    """A response time from a table of the duty, not fitted, is a scale for it: what the card says."""
    model = started(SMALL, "passive", "guo_yield", "response_table", "duty_gain")
    at = columns(model, rich())
    fixed = {n: c for n, c in at.items() if n in model.effects["response_table"]}
    direction = at.pop("g_u")
    assert left(direction, {n: c for n, c in at.items() if n not in fixed}) > 1e-3


@pytest.mark.parametrize("more", ["field_viscosity", "duty_dead_band", "varying_time_constant"])
def test_fitted_terms_in_the_duty_scale_along(more: str) -> None:
    model = started(SMALL, "passive", "guo_yield", "response", more, "duty_gain")
    at = columns(model, rich())
    assert left(at.pop("g_u"), at) < NOTHING


@GAINS
def test_a_gain_says_why_it_cannot_be_known(gain: Effect) -> None:
    said = set(
        gain.unknowable_because.replace(",", " ").replace(")", " ").replace("(", " ").split()
    )
    assert ABSORBS[gain.name] <= said
