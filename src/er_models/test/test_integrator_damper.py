"""The integrator along an imposed motion: against SciPy, closed forms, and itself cut into pieces."""

from __future__ import annotations

import dataclasses
from pathlib import Path

import er_models.prediction as prediction
import numpy as np
import pytest
from er_models.catalogue import CATALOGUE
from er_models.model import Array, Model
from er_models.prediction import join, motion, predict, predict_many
from er_models.simulation import simulate
from models_help import DT, SMALL, Sine, bingham, car, guo, imposed, span, typical
from reference import damper_force
from scipy.integrate import solve_ivp

CONTACTS = ("freeplay", "piston_play", "cavitation", "friction_with_play", "remanence")
"""They jump; their tests are of their own."""
STATES = [
    e.name for e in CATALOGUE.effects if e.has_state and e.name not in ("response", *CONTACTS)
]


def errors(model: Model, steps: tuple[float, ...]) -> list[float]:
    """Largest error at each step, as a share of the force range."""
    inputs = imposed(SMALL, 0.6)
    exact = damper_force(model, inputs, Sine(SMALL).derivative)
    out = []
    for step in steps:
        out.append(np.abs(predict(model, inputs, longest=step) - exact).max() / span(exact))
    return out


def wide(model: Model) -> Model:
    """The model with a gate so wide that all is smooth on the scale of a sample."""
    return model.with_effect("guo_yield", {"f_c": 29.0, "k1": 20.0, "c1": 20.0})


def test_converges_with_second_order() -> None:
    """Half the step, a quarter of the error, until the interpolation of the motion limits it."""
    e = errors(wide(guo()), (5e-3, 2.5e-3, 1.25e-3))
    assert 3.5 < e[0] / e[1] < 4.6
    assert 3.5 < e[1] / e[2] < 4.6


@pytest.mark.parametrize("r", [0.2, 3.0])
def test_a_pace_that_hangs_on_the_yield_force_needs_no_search(r: float) -> None:
    """Half the step, a quarter of the error but for where the pace turns within a step."""
    model = wide(guo()).with_effect("rise_fall_asymmetry", {"r": r})
    assert model.compiled().links.size == 0
    e = errors(model, (5e-3, 2.5e-3, 1.25e-3, 6.25e-4))
    assert e[0] / e[3] > 2.8**3
    assert e[3] < 3e-4


@pytest.mark.parametrize("name", STATES)
def test_error_at_200_hz_with_every_state(name: str) -> None:
    (error,) = errors(typical(guo(), guo().catalogue[name]), (prediction.SUBSTEP,))
    assert error < 1e-3


@pytest.mark.parametrize("model", [guo(), guo().without_effect("response"), bingham()])
def test_error_at_200_hz_on_a_smooth_motion(model: Model) -> None:
    (error,) = errors(model, (prediction.SUBSTEP,))
    assert error < 3e-4


def scenario() -> tuple[Array, Array]:
    """Road of the first scenario of the thesis (3.6.1), shortened, and steps of the duty."""
    t = np.arange(801) * DT
    levels = np.random.default_rng(1).uniform(0.0, 0.3, 21)
    return 0.004 * np.sin(2.0 * np.pi * 10.0 / 8.0 * t**2), np.repeat(levels, 40)[: t.size]


def thesis_force(tau: float, road: Array, duty: Array) -> Array:
    """Rows t, x, v, a, F of (2.5) with (1.12), written here once more and solved by SciPy."""
    k0, c0, f_c, k1, c1 = 263.1168, 64.6433, 29.2780, 204.0283, 492.6448
    m_s, m_us, k_s, k_t = 2.27, 0.25, 1396.0, 12270.0

    def rate(_t: float, y: Array, u: float, slope: float) -> list[float]:
        x, v = y[0], y[1] - y[3]
        force = k0 * x + c0 * v + y[4]
        target = f_c * u * np.tanh(k1 * x + c1 * v)
        a_s, a_us = -(k_s * x + force) / m_s, (k_s * x + force - k_t * y[2]) / m_us
        return [v, a_s, y[3] - slope, a_us, (target - y[4]) / tau]

    y, rows = np.zeros(5), []
    for k, u in enumerate(duty):
        slope = (road[k + 1] - road[k]) / DT if k + 1 < duty.size else 0.0
        dy = rate(0.0, y, u, slope)
        rows.append([y[0], dy[0], dy[1] - dy[3], k0 * y[0] + c0 * dy[0] + y[4]])
        if k + 1 < duty.size:
            y = solve_ivp(rate, (0, DT), y, "LSODA", args=(u, slope), rtol=1e-9, atol=1e-11).y[
                :, -1
            ]
    return np.array(rows).T


def test_error_at_200_hz_on_the_thesis_scenario() -> None:
    """Damper and car against equations typed independently, with duty steps and a gate of 2 mm/s."""
    road, duty = scenario()
    x, v, a, exact = thesis_force(0.0365, road, duty)
    predicted = predict(guo(), motion(DT, x, v, duty, a)) - exact
    simulated = simulate(car(), DT, road, duty)["damper_force"] - exact
    assert np.sqrt(np.mean(predicted**2)) < 5e-4 * span(exact)
    assert np.abs(predicted).max() < 5e-3 * span(exact)
    assert np.abs(simulated).max() < 5e-4 * span(exact)


def test_response_to_a_step_of_the_duty_is_exact() -> None:
    """tau f_y' + f_y = y with y constant: an exponential, whatever the step of the integrator."""
    model = Model(
        "step",
        {"guo_yield": {"f_c": 20.0, "k1": 0.0, "c1": 1e4}, "response": {"tau": 0.003}},
        SMALL,
    )
    n = 40
    t, ones = np.arange(n) * DT, np.ones(n)
    duty = np.where(t < 10 * DT, 0.1, 0.3)
    force = predict(model, motion(DT, 0.1 * t, 0.1 * ones, duty, 0.0 * ones))
    since = np.maximum(t - 10 * DT, 0.0)
    assert force == pytest.approx(2.0 + 4.0 * (1.0 - np.exp(-since / 0.003)), abs=1e-8)


@pytest.mark.parametrize("delay", [0.0, 0.0031, 0.005, 0.015, 0.0175, 0.035])
def test_dead_time_is_exact(delay: float) -> None:
    """The exponential begins at the delayed instant, also between samples."""
    model = Model(
        "delayed",
        {
            "guo_yield": {"f_c": 20.0, "k1": 0.0, "c1": 1e4},
            "response": {"tau": 0.01},
            "dead_time": {"T_d": delay},
        },
        SMALL,
    )
    t, ones = np.arange(60) * DT, np.ones(60)
    duty = np.where(np.arange(60) < 10, 0.1, 0.3)
    force = predict(model, motion(DT, 0.1 * t, 0.1 * ones, duty, 0.0 * ones))
    since = np.maximum(t - 10 * DT - delay, 0.0)
    assert force == pytest.approx(2.0 + 4.0 * (1.0 - np.exp(-since / 0.01)), abs=1e-8)


@pytest.mark.parametrize("samples", [1, 3, 7])
def test_dead_time_of_whole_samples_shifts_the_duty(samples: int) -> None:
    inputs = imposed(SMALL, 2.0)
    later = np.concatenate([np.full(samples, inputs.u[0]), inputs.u[:-samples]])
    shifted = predict(guo(), dataclasses.replace(inputs, u=later))
    delayed = predict(guo().with_effect("dead_time", {"T_d": samples * DT}), inputs)
    assert delayed == pytest.approx(shifted, abs=1e-12)


def test_force_delay_shifts_the_force() -> None:
    """Whole samples exactly; a part of a sample as the smooth force at the earlier time."""
    model, inputs = wide(guo()), imposed(SMALL, 2.0)
    inputs = dataclasses.replace(inputs, u=np.full(inputs.n, 0.2))
    force = predict(model, inputs)
    by_two = predict(model.with_effect("force_delay", {"d": 2 * DT}), inputs)
    assert by_two[2:] == pytest.approx(force[:-2], abs=1e-12)
    early = predict(model.with_effect("force_delay", {"d": -2 * DT}), inputs)
    assert early[:-2] == pytest.approx(force[2:], abs=1e-12)
    part = predict(model.with_effect("force_delay", {"d": 0.4 * DT}), inputs)
    fine = imposed(SMALL, 2.0, dt=0.2 * DT)
    exact = predict(model, dataclasses.replace(fine, u=np.full(fine.n, 0.2)))[3::5]
    assert part[1:] == pytest.approx(exact[: part.size - 1], abs=2e-3 * span(force))


def test_records_joined_are_records_apart() -> None:
    model = guo().with_effect("self_heating").with_effect("force_delay").with_effect("dead_time")
    parts = [imposed(SMALL, seconds, seed=i) for i, seconds in enumerate((1.0, 0.5, 2.0))]
    apart = np.concatenate([predict(model, part) for part in parts])
    assert np.array_equal(predict(model, join(parts)), apart)


def test_many_are_one_after_another() -> None:
    model, inputs = guo().with_effect("mount_compliance"), imposed(SMALL, 1.0)
    vectors = np.repeat(model.compiled().p[None], 3, axis=0)
    vectors[:, CATALOGUE.column("guo_yield", "f_c")] = (20.0, 25.0, 30.0)
    forces = predict_many(model, vectors, inputs)
    for f_c, force in zip((20.0, 25.0, 30.0), forces):
        other = model.with_effect("guo_yield", {**model.effects["guo_yield"], "f_c": f_c})
        assert np.array_equal(force, predict(other, inputs))


def test_static_model_is_its_formula_row_by_row() -> None:
    inputs = imposed(SMALL, 2.0)
    p, y = guo().effects["passive"], guo().effects["guo_yield"]
    gate = np.tanh(y["k1"] * inputs.x + y["c1"] * inputs.v)
    formula = p["k0"] * inputs.x + p["c0"] * inputs.v + y["f_c"] * inputs.u * gate
    assert predict(guo().without_effect("response"), inputs) == pytest.approx(formula, abs=1e-12)


def test_mount_in_series_with_a_static_damper_carries_one_force() -> None:
    """Spring and damper in series, written as the scalar equation it is; the yield force acts at once."""
    model = bingham().with_effect("mount_compliance")
    q, passive = model.value("mount_compliance", "q"), model.effects["passive"]
    sigma, beta, v_0 = (model.value("bingham_yield", n) for n in ("sigma", "beta", "v_0"))
    sine, u = Sine(SMALL).derivative, 0.2

    def velocity(x: float, stretch: float) -> float:
        low, high = -10.0, 10.0
        for _ in range(80):
            v = 0.5 * (low + high)
            own = passive["k0"] * (x - stretch) + passive["c0"] * v
            excess = own + sigma * u**beta * np.tanh(v / v_0) - stretch / q
            low, high = (low, v) if excess > 0.0 else (v, high)
        return 0.5 * (low + high)

    t = np.arange(61) * DT
    inputs = motion(DT, sine(t, 0), sine(t, 1), np.full(t.size, u), sine(t, 2))
    start = predict(model, inputs)[0] * q
    exact = solve_ivp(
        lambda s, w: [float(sine(s, 1)) - velocity(float(sine(s, 0)), w[0])],
        (0.0, t[-1]), [start], "Radau", t_eval=t, rtol=1e-7, atol=1e-11,
    ).y[0] / q  # fmt: skip
    error = predict(model, inputs) - exact
    assert np.abs(error).max() < 1e-2 * span(exact)
    assert error.std() < 1e-3 * span(exact)


def test_a_mount_beside_a_damper_without_damping_is_that_beside_one_of_next_to_none() -> None:
    """Where the field makes all of the force the mount takes as much of the motion."""
    sine, t = Sine(SMALL).derivative, np.arange(400) * DT
    inputs = motion(DT, sine(t, 0), sine(t, 1), np.full(t.size, 0.2), sine(t, 2))

    def force(c0: float, *effects: str) -> Array:
        model = bingham()
        model = model.with_effect("passive", {**model.effects["passive"], "c0": c0})
        for name in effects:
            model = model.with_effect(name)
        return predict(model, inputs)

    little = 1e-4 * bingham().value("passive", "c0")
    made = force(little, "mount_compliance") - force(little)
    off = force(0.0, "mount_compliance") - force(little, "mount_compliance")
    assert np.std(off) < 0.01 * np.std(made)
    assert np.std(made) > 0.01 * span(force(little))


def test_freeplay_is_a_rigid_gap() -> None:
    """Against small explicit steps of the contact: stuck to an edge while pressed, free in between."""
    b, u, h = 2e-4, 0.2, 5e-6
    p, y = guo().effects["passive"], guo().effects["guo_yield"]
    sine = Sine(SMALL).derivative
    fine = np.arange(round(0.5 / h) + 1) * h
    x, v = sine(fine, 0), sine(fine, 1)
    w, force = b, np.empty(fine.size)
    f_y = y["f_c"] * u * np.tanh(y["k1"] * (x[0] - w) + y["c1"] * v[0])
    for i in range(fine.size):
        own = p["k0"] * (x[i] - w) + f_y
        together = own + p["c0"] * v[i]
        stuck = together > 0.0 if w >= b else together < 0.0 and w <= -b
        v_d = v[i] if stuck else -own / p["c0"]
        force[i] = together if stuck else 0.0
        f_y += h / 0.0365 * (y["f_c"] * u * np.tanh(y["k1"] * (x[i] - w) + y["c1"] * v_d) - f_y)
        w = min(max(w + h * (v[i] - v_d), -b), b)
    n = fine[:: round(DT / h)].size
    t = np.arange(n) * DT
    inputs = motion(DT, sine(t, 0), sine(t, 1), np.full(n, u), sine(t, 2))
    model = guo().with_effect("freeplay", {"b": b, "q": 0.0})
    error = predict(model, inputs) - force[:: round(DT / h)]
    assert error.std() < 1e-3 * span(force)
    assert (predict(guo(), inputs) - force[:: round(DT / h)]).std() > 1e-2 * span(force)


@pytest.mark.parametrize("stiffness", [4e4, 4e6], ids=["40 N/mm", "nearly rigid"])
def test_freeplay_is_a_gap_with_a_spring_at_either_end(stiffness: float) -> None:
    """Against small explicit steps of a spring that is touched beyond the gap, in series with the damper."""
    b, u, h = 1e-4, 0.2, 5e-6
    p, y = guo().effects["passive"], guo().effects["guo_yield"]
    sine = Sine(SMALL).derivative
    fine = np.arange(round(0.5 / h) + 1) * h
    x, v = sine(fine, 0), sine(fine, 1)
    w, force = b, np.empty(fine.size)
    f_y = y["f_c"] * u * np.tanh(y["k1"] * (x[0] - w) + y["c1"] * v[0])
    for i in range(fine.size):
        force[i] = stiffness * (max(w - b, 0.0) + min(w + b, 0.0))
        v_d = (force[i] - p["k0"] * (x[i] - w) - f_y) / p["c0"]
        f_y += h / 0.0365 * (y["f_c"] * u * np.tanh(y["k1"] * (x[i] - w) + y["c1"] * v_d) - f_y)
        w += h * (v[i] - v_d)
    every, settled = slice(None, None, round(DT / h)), slice(30, None)
    t = np.arange(fine[every].size) * DT
    inputs = motion(DT, sine(t, 0), sine(t, 1), np.full(t.size, u), sine(t, 2))

    def error(q: float) -> float:
        model = guo().with_effect("freeplay", {"b": b, "q": q})
        return float((predict(model, inputs) - force[every])[settled].std())

    assert error(1.0 / stiffness) < 1e-3 * span(force)
    assert error(0.0) > (1e-2 if stiffness < 1e5 else 0.0) * span(force)


@pytest.mark.parametrize("r", [0.0, 400.0], ids=["lost motion", "nearly a bare cut-off"])
def test_cavitation_is_a_void_that_opens_and_closes(r: float) -> None:
    """Against small explicit steps: the void begins where the fluid would pull harder than it can, and ends at zero."""
    F_v, w_s, u, h = 6.0, 2e-5, 0.2, 5e-6
    p, y = guo().effects["passive"], guo().effects["guo_yield"]
    sine = Sine(SMALL).derivative
    fine = np.arange(round(0.5 / h) + 1) * h
    x, v = sine(fine, 0), sine(fine, 1)
    target = y["f_c"] * u * np.tanh(y["k1"] * x + y["c1"] * v)
    w, f_y, force, open_for = 0.0, target[0], np.empty(fine.size), 0
    for i in range(fine.size):
        pull = p["c0"] * v[i] + f_y
        force[i] = p["k0"] * x[i] + pull + (F_v - pull) * w / (w + w_s)
        open_for += w > 0.0
        w = max(w + h * ((pull - F_v) / p["c0"] - r * w), 0.0)
        f_y += h / 0.0365 * (target[i] - f_y)
    assert 0.1 < open_for / fine.size < 0.9
    n = fine[:: round(DT / h)].size
    t = np.arange(n) * DT
    inputs = motion(DT, sine(t, 0), sine(t, 1), np.full(n, u), sine(t, 2))
    model = guo().with_effect("cavitation", {"F_v": F_v, "r": r, "w_s": w_s})
    error = predict(model, inputs) - force[:: round(DT / h)]
    assert error.std() < 2e-4 * span(force)
    assert (predict(guo(), inputs) - force[:: round(DT / h)]).std() > 1e-2 * span(force)


def test_models_of_the_repository_are_found() -> None:
    assert (Path(__file__).parents[3] / "config" / "dampers").is_dir()
