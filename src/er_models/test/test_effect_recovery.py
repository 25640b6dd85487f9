"""What an effect does to a record gives its parameters back: least squares on its own simulation.

Effects of the damper from the force along an imposed motion, effects of the car from the accelerations and the
deflection of the car on a road.
"""

from __future__ import annotations

from collections.abc import Callable

import numpy as np
import pytest
import worked
from er_models.catalogue import CATALOGUE
from er_models.effect import SWITCH, Effect, Param
from er_models.model import Array, Model
from er_models.prediction import predict
from er_models.simulation import simulate
from models_help import DT, SMALL, imposed, started
from scipy.optimize import least_squares

OFF = (1.25, 0.8)
"""Starts of the fit, as multiples of the truth, alternating over the parameters."""
DAMPER = ("passive", "guo_yield", "response")
CAR = (*DAMPER, "quarter_car")
RIDES = [e for e in CATALOGUE.effects if e.stage == "vehicle" and e.name != "quarter_car"]
RECORD = imposed(SMALL, 6.0)


def truth(base: Model, effect: Effect) -> Model:
    """The model with the effect at a size that shows: its last starts, or what its file in `effects/` says."""
    values = {q.name: base.start(effect.name, q.name, -1) for q in effect.parameters}
    return base.with_effect(effect.name, values | getattr(worked.of(effect.name), "SHOWN", {}))


def free(effect: Effect) -> list[Param]:
    """Parameters that are fitted."""
    return [q for q in effect.parameters if q.fitted]


def limit(effect: Effect) -> float:
    """Largest share by which a fit may miss a parameter: more where equations jump."""
    return 3e-2 if any(q.step == SWITCH for q in effect.parameters) else 1e-3


def recovered(model: Model, effect: Effect, outputs: Callable[[Model], Array]) -> dict[str, float]:
    """Share by which each parameter misses the truth, fitted from a start that is off."""
    exact = {q.name: model.value(effect.name, q.name) for q in free(effect)}
    wanted, names = outputs(model), list(exact)
    size = np.array([abs(v) for v in exact.values()])
    box = np.array([model.bounds(effect.name, n) for n in names]).T

    def misfit(theta: Array) -> Array:
        values = {**model.effects[effect.name], **dict(zip(names, theta * size))}
        return outputs(model.with_effect(effect.name, values)) - wanted

    start = np.array([v * OFF[i % 2] for i, v in enumerate(exact.values())])
    found = least_squares(
        misfit, np.clip(start, *box) / size, bounds=box / size, diff_step=[q.step for q in free(effect)],
        xtol=1e-14, ftol=1e-14, gtol=1e-14,
    ).x  # fmt: skip
    return {n: abs(float(f - v / s)) for n, f, v, s in zip(names, found, exact.values(), size)}


@pytest.mark.parametrize("effect", CATALOGUE.candidates(), ids=lambda e: e.name)
def test_the_force_gives_the_parameters_back(effect: Effect) -> None:
    model = truth(started(SMALL, *DAMPER), effect)
    missed = recovered(model, effect, lambda m: predict(m, RECORD))
    assert max(missed.values()) < limit(effect), missed


def road() -> tuple[Array, Array]:
    """Three sines that reach the resonances of body and wheel, and a step of the duty."""
    t = np.arange(800) * DT
    tones = ((0.3, 1.7), (0.15, 4.0), (0.25, 16.0))
    height = sum(part * np.sin(2.0 * np.pi * f * t) for part, f in tones)
    return SMALL.deflection * np.asarray(height), SMALL.duty * np.repeat([0.2, 0.8], 400)


@pytest.mark.parametrize("effect", RIDES, ids=lambda e: e.name)
def test_the_ride_gives_the_parameters_back(effect: Effect) -> None:
    height, duty = road()
    height = height * getattr(worked.of(effect.name), "ROAD", 1.0)
    model = truth(started(SMALL, *CAR), effect)

    def outputs(m: Model) -> Array:
        run = simulate(m, DT, height, duty)
        channels = ("sprung_acceleration", "unsprung_acceleration", "deflection")
        return np.concatenate([run[c] / np.std(run[c]) for c in channels])

    missed = recovered(model, effect, outputs)
    assert max(missed.values()) < limit(effect), missed
