"""Faults: compiled effects against the law that mimics them on a healthy damper."""

from __future__ import annotations

import numpy as np
import pytest
from er_models.errors import InputError
from er_models.forms.loss import Factors, damaged
from er_models.model import Array, Model
from er_models.prediction import motion, predict
from er_models.simulation import simulate
from er_models.static_damper import HEALTHY, static_damper
from models_help import DT, bingham, car, guo

STEP = {"t_0": 0.0, "t_r": 0.0, "q": 0.0, "d": 0.5}
FAULTS = {
    "f1": (Factors(electrical=0.5), {"electrical_fault": 0.5}),
    "f2": (Factors(leakage=0.9), {"oil_leakage": 0.9}),
    "f3": (Factors(deformation=0.9), {"duct_deformation": 0.9}),
    "all": (
        Factors(0.8, 0.95, 0.9),
        {"electrical_fault": 0.8, "oil_leakage": 0.95, "duct_deformation": 0.9},
    ),
}


def faulty(model: Model, left: dict[str, float]) -> Model:
    """The model with fault effects from the first instant on."""
    for name, f in left.items():
        model = model.with_effect(name, {**STEP, "f": f})
    return model


def ride() -> tuple[Array, Array]:
    """Deflection and velocity (n,) of a motion over the envelope of the damper."""
    t = DT * np.arange(800)
    w = 2.0 * np.pi * np.array([1.7, 5.3])
    x = 0.005 * np.sin(w[0] * t) + 0.002 * np.sin(w[1] * t)
    return x, 0.005 * w[0] * np.cos(w[0] * t) + 0.002 * w[1] * np.cos(w[1] * t)


@pytest.mark.parametrize("name", FAULTS)
@pytest.mark.parametrize("base", ["bingham", "guo"])
def test_mimic_is_the_faulty_force_where_a_duty_exists(name: str, base: str) -> None:
    model = bingham() if base == "bingham" else guo().without_effect("response")
    (x, v), (left, effects) = ride(), FAULTS[name]
    u = np.full(x.size, 0.3)
    force = predict(faulty(model, effects), motion(DT, x, v, u))
    found = static_damper(model).mimic(x, v, u, left)
    copied = predict(model, motion(DT, x, v, found.duty))
    assert 0.5 < found.exists.mean() <= 1.0
    apart = np.abs(copied - force)
    assert apart[found.exists].max() < 0.01 * np.ptp(force)
    assert np.all(apart[~found.exists] > 0.0)  # where it says there is none, none is hit
    assert np.abs(predict(model, motion(DT, x, v, u)) - force).max() > 0.03 * np.ptp(force)


@pytest.mark.parametrize(
    ("left", "printed"),
    [
        (Factors(electrical=0.5), lambda d, x, v, u: 0.5 ** (1 / d.beta) * u),
        (
            Factors(leakage=0.9),
            lambda d, x, v, u: (
                (-0.1 / d.sigma * (d.k0 * x + d.c0 * v) * np.sign(v) + 0.9 * u**d.beta)
                ** (1 / d.beta)
            ),
        ),
        (
            Factors(deformation=0.9),
            lambda d, x, v, u: (-0.1 / d.sigma * d.c0 * abs(v) + 0.9 * u**d.beta) ** (1 / d.beta),
        ),
    ],
    ids=["6.3", "6.7", "6.11"],
)
def test_duty_is_the_printed_one(left, printed) -> None:  # type: ignore[no-untyped-def]
    damper = static_damper(bingham())
    for x, v in ((0.004, 0.05), (0.004, -0.05), (-0.003, 0.08)):
        found = damper.mimic(np.array([x]), np.array([v]), np.array([0.3]), left)
        assert found.exists[0]
        assert found.duty[0] == pytest.approx(printed(damper, x, v, 0.3), rel=1e-6)


def test_without_field_no_duty_mimics_a_leak() -> None:
    """A healthy damper cannot give less than its passive force, nor more than its limits allow."""
    damper, x, v = static_damper(bingham()), np.array([0.004]), np.array([0.1])
    found = damper.mimic(x, v, np.zeros(1), Factors(leakage=0.9))
    assert not found.exists[0]
    assert found.duty[0] == 0.0
    held = damper.mimic(x, v, np.array([0.3]), HEALTHY, (0.0, 0.2))
    assert not held.exists[0]
    assert held.duty[0] == 0.2


@pytest.mark.parametrize("name", FAULTS)
def test_a_fault_during_a_ride_is_the_weaker_car_from_then_on(name: str) -> None:
    """Healthy to the last bit before it appears; long after, as with the parameters of (6.8)."""
    left, effects = FAULTS[name]
    model = car()
    for effect, f in effects.items():
        model = model.with_effect(effect, {**STEP, "f": f, "t_0": 1.0})
    t = DT * np.arange(801)
    road, duty = 0.008 * np.sin(2.0 * np.pi * 3.0 * t), np.full(801, 0.1)
    records = [
        simulate(m, DT, road, duty)["damper_force"] for m in (model, car(), damaged(car(), left))
    ]
    found, healthy, weaker = records
    assert np.array_equal(found[:200], healthy[:200])
    assert np.abs(found - weaker)[600:].max() < 3e-3 * np.ptp(weaker)
    assert np.abs(found - healthy)[600:].max() > 0.015 * np.ptp(weaker)


def test_domain_holds_every_duty_and_shrinks_with_faults() -> None:
    damper, (x, v) = static_damper(guo()), ride()
    healthy = damper.domain(x, v, (0.0, 1.0))
    leaking = damper.domain(x, v, (0.0, 1.0), Factors(leakage=0.6))
    for duty in (0.0, 0.4, 1.0):
        force = damper.force(x, v, duty)
        assert np.all((healthy.low <= force) & (force <= healthy.high))
    assert np.allclose(leaking.low, 0.6 * healthy.low)
    assert np.allclose(leaking.high, 0.6 * healthy.high)


def test_dampers_with_other_terms_are_refused() -> None:
    with pytest.raises(InputError, match="passive and one of"):
        static_damper(guo().with_effect("coulomb_friction"))
