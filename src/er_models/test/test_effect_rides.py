"""What every effect of the car must be; it acts in the car and nowhere else."""

from __future__ import annotations

import inspect

import numpy as np
import pytest
import worked
from er_models.catalogue import CATALOGUE
from er_models.effect import Effect
from er_models.linear import fingerprint, relative_form
from er_models.model import Array, Model
from er_models.prediction import predict
from er_models.scales import Scales
from er_models.simulation import initial_state, prepare, simulate, step
from models_help import DT, LARGE, SMALL, box, car, guo, imposed, neutral, span, started

RIDES = pytest.mark.parametrize(
    "effect",
    [e for e in CATALOGUE.effects if e.stage == "vehicle" and e.name != "quarter_car"],
    ids=lambda e: e.name,
)
SCALES = pytest.mark.parametrize("scales", [SMALL, LARGE], ids=("20 N", "2000 N"))
CORE = ("passive", "guo_yield", "response", "quarter_car")


def rough(scales: Scales, n: int = 200, dt: float = DT) -> tuple[Array, Array]:
    """Road [m] and duty of n samples: three sines, the fastest near the resonance of the wheel, and a step of duty."""
    t = np.arange(n) * dt
    road = sum(
        share * np.sin(2.0 * np.pi * f * t) for share, f in ((0.4, 1.7), (0.2, 4.0), (0.2, 16.0))
    )
    duty = np.repeat([0.2, 0.8], (n + 1) // 2)[:n]
    return scales.deflection * np.asarray(road), scales.duty * duty


def violent(model: Model, effect: Effect) -> tuple[Array, Array]:
    """The rough road, so high that the wheel leaves it where an effect waits for that."""
    road, duty = rough(model.scales)
    return road * getattr(worked.of(effect.name), "ROAD", 1.0), duty


@RIDES
def test_neutral_gives_exactly_nothing(effect: Effect) -> None:
    road, duty = violent(car(), effect)
    without, with_it = (simulate(m, DT, road, duty) for m in (car(), neutral(car(), effect)))
    for channel, values in without.items():
        assert np.abs(with_it[channel] - values).max() <= 1e-9 * span(values), channel


@SCALES
@RIDES
def test_has_an_effect(effect: Effect, scales: Scales) -> None:
    model = started(scales, *CORE)
    road, duty = violent(model, effect)
    runs = [simulate(m, DT, road, duty) for m in (model, model.with_effect(effect.name))]
    change = [
        np.abs(runs[1][c] - runs[0][c]).max() / span(runs[0][c])
        for c in ("sprung_acceleration", "unsprung_acceleration")
    ]
    assert max(change) > 3e-3


@RIDES
def test_the_damper_by_itself_does_not_know_it(effect: Effect) -> None:
    """A model of a car predicts the force of its damper from measured motion as the damper alone does."""
    inputs = imposed(SMALL, 1.0)
    force = predict(guo(), inputs)
    for values in box(effect, SMALL):
        model = car().with_effect(effect.name, values)
        assert np.array_equal(predict(model, inputs), force)


@SCALES
@RIDES
def test_is_finite_over_its_whole_box(effect: Effect, scales: Scales) -> None:
    model = started(scales, *CORE)
    road, duty = violent(model, effect)
    for values in box(effect, scales):
        run = simulate(model.with_effect(effect.name, values), DT, road, duty)
        for channel, found in run.items():
            assert np.isfinite(found).all(), (channel, values)
            if channel == "deflection":
                assert np.abs(found).max() < 100.0 * span(road), values


ALONG = {"spring_force": "v", "tyre_force": "v_t"}
"""Velocity that a force of the car acts along."""


@RIDES
def test_dissipates_as_declared(effect: Effect) -> None:
    """Declared where every force goes against its velocity, at each point of the box, and nowhere else."""
    speeds = np.linspace(-1.0, 1.0, 41) * SMALL.velocity
    forces = [
        (ALONG[hook], function)
        for hook, function in effect.hooks.items()
        if ALONG.get(hook) in inspect.signature(function).parameters
    ]
    if len(forces) < len(effect.hooks):
        assert not effect.dissipative
        return
    power = [
        v * function(**values, **{along: v})  # type: ignore[operator]
        for values in box(effect, SMALL)
        for along, function in forces
        for v in speeds
    ]
    assert (min(power) >= 0.0 < max(power)) == effect.dissipative


@RIDES
def test_one_sample_at_a_time_is_the_whole_record(effect: Effect) -> None:
    model = car().with_effect(effect.name)
    road, _ = violent(model, effect)
    plant, run = prepare(model, DT), simulate(model, DT, road, np.full(200, 0.2))
    state = initial_state(plant, road[0], 0.2)
    for k in range(1, 60):
        state, out = step(plant, state, (road[k], 0.2))
        assert out.deflection == pytest.approx(run["deflection"][k], abs=1e-12)
        assert out.sprung_acceleration == pytest.approx(run["sprung_acceleration"][k], abs=1e-6)


@RIDES
def test_starts_mean_the_same_for_every_car(effect: Effect) -> None:
    """A car 5 times as long and 1000 times as strong moves alike; only gravity has a size of its own."""
    scales = Scales(1000.0 * SMALL.force, 5.0 * SMALL.deflection, 5.0 * SMALL.velocity, SMALL.duty)

    def shape(s: Scales) -> Array:
        model = started(s, *CORE).with_effect(effect.name)
        if effect.name == "tyre_lift_off":
            weight = s.force / s.acceleration  # the first start weighs the same share of the force
            model = model.with_effect(effect.name, {"r": 0.2 * s.force / weight / 9.80665})
        road, duty = rough(s)
        return simulate(model, DT, 3.0 * road, duty)["deflection"] / s.deflection

    assert np.abs(shape(scales) - shape(SMALL)).max() < 1e-6


def test_a_heavier_body_is_a_heavier_body_in_the_forms() -> None:
    values = car().effects["quarter_car"]
    heavier = car().with_effect("quarter_car", {**values, "m_s": 1.2 * values["m_s"]})
    form, expected = (
        relative_form(m) for m in (car().with_effect("sprung_mass_error", {"e": 0.2}), heavier)
    )
    assert np.array_equal(form.A, expected.A)
    assert np.array_equal(form.C, expected.C)
    assert fingerprint(heavier) != fingerprint(car())


def test_accelerometers_are_off_by_their_bias_from_the_first_sample_on() -> None:
    road, duty = rough(SMALL)
    biased = car().with_effect("accelerometer_bias", {"b_s": 0.3, "b_us": -0.2})
    true, run = simulate(car(), DT, road, duty), simulate(biased, DT, road, duty)
    assert run["sprung_acceleration"] - true["sprung_acceleration"] == pytest.approx(0.3)
    assert run["unsprung_acceleration"] - true["unsprung_acceleration"] == pytest.approx(-0.2)
    for channel in set(run) - {"sprung_acceleration", "unsprung_acceleration"}:
        assert np.array_equal(run[channel], true[channel])


def test_a_wheel_in_the_air_falls_freely() -> None:
    """Thrown off a step, body and wheel together feel gravity alone until the tyre touches again."""
    dt, n = 1e-3, 300
    road = np.where(np.arange(n) < 20, 0.0, -0.04)
    model = car().with_effect("tyre_lift_off")
    run = simulate(model, dt, road, np.zeros(n))
    m, k_t = model.effects["quarter_car"], model.value("quarter_car", "k_t")
    total = m["m_s"] * run["sprung_acceleration"] + m["m_us"] * run["unsprung_acceleration"]
    weight = (m["m_s"] + m["m_us"]) * 9.80665
    air = run["tyre_deflection"] > weight / k_t
    air[:21] = False
    assert air.sum() > 20
    assert total[air] == pytest.approx(-weight, rel=1e-9)
    ground = ~air
    ground[:21] = False
    assert total[ground] == pytest.approx(
        -k_t * run["tyre_deflection"][ground], rel=1e-6, abs=1e-6
    )


def test_friction_of_the_guide_is_not_in_the_measured_force() -> None:
    """Coulomb friction in the damper and beside it move the car alike; only one is in the load cell."""
    road, duty = rough(SMALL)
    values = {"v_0": 0.004}
    inside = simulate(
        car().with_effect("coulomb_friction", {"F_c": 1.0, **values}), DT, road, duty
    )
    beside = simulate(car().with_effect("guide_friction", {"F_g": 1.0, **values}), DT, road, duty)
    assert beside["deflection"] == pytest.approx(inside["deflection"], abs=1e-9)
    friction = np.tanh(beside["deflection_velocity"] / 0.004)
    assert inside["damper_force"] - beside["damper_force"] == pytest.approx(friction, abs=1e-6)


def test_tyre_damping_lowers_the_resonance_of_the_wheel() -> None:
    """With a stiff body and no damper the wheel is one mass: its decrement is that of c_t."""
    values = {"m_s": 1e5, "m_us": 0.25, "k_s": 1e-3, "k_t": 12270.0}
    bare = Model("wheel", {"passive": {"k0": 0.0, "c0": 0.0}, "quarter_car": values}, SMALL)
    model = bare.with_effect("tyre_damping", {"c_t": 4.0})
    dt, n = 2.5e-4, 2000
    run = simulate(model, dt, np.zeros(n), np.zeros(n), np.array([0.0, 0.0, 0.001, 0.0]))
    omega, decay = np.sqrt(12270.0 / 0.25 - (4.0 / 0.5) ** 2), 4.0 / 0.5
    t = np.arange(n) * dt
    exact = 0.001 * np.exp(-decay * t) * (np.cos(omega * t) + decay / omega * np.sin(omega * t))
    assert np.abs(run["tyre_deflection"] - exact).max() < 2e-3 * 0.001


def test_the_hook_of_a_car_cannot_have_a_state() -> None:
    for effect in CATALOGUE.effects:
        assert effect.stage != "vehicle" or not effect.has_state
