"""What is dragged along and what slides behind a play: against small explicit steps and the play written once more."""

from __future__ import annotations

import numpy as np
from er_models.model import Model
from er_models.prediction import motion, predict
from er_models.simulation import simulate
from models_help import DT, SMALL, Sine, car, guo, span


def test_a_bristle_behind_a_play_slides_and_comes_back() -> None:
    """Against small explicit steps of the gap and of Dahl's bristle, each a state of its own."""
    F_h, z_y, b, h = 4.0, 6e-4, 8e-4, 5e-6
    sine = Sine(SMALL).derivative
    fine = np.arange(round(2.0 / h) + 1) * h
    v, gap, z = sine(fine, 1), 0.0, 0.0
    force = np.empty(fine.size)
    for i, speed in enumerate(v):
        force[i] = F_h * z / z_y
        inside = gap + h * speed
        if z == 0.0 and abs(inside) <= b:
            gap = inside
            continue
        gap = b if gap > 0.0 else -b
        after = z + h * (speed - abs(speed) * z / z_y)
        z = after if after * gap > 0.0 else 0.0
    every = slice(None, None, round(DT / h))
    t = np.arange(fine[every].size) * DT
    inputs = motion(DT, sine(t, 0), sine(t, 1), 0.0 * t, sine(t, 2))
    brake = {"F_h": F_h, "F_u": 0.0, "z_y": z_y, "b": b}
    error = predict(Model("brake", {"friction_with_play": brake}, SMALL), inputs) - force[every]
    assert error.std() < 2e-3 * span(force)
    assert np.mean(force[every] == 0.0) > 0.05
    brake = {**brake, "b": 0.0}
    error = predict(Model("brake", {"friction_with_play": brake}, SMALL), inputs) - force[every]
    assert error.std() > 5e-2 * span(force)


def test_an_elastic_share_bends_before_it_slides() -> None:
    """Against small explicit steps; and nearly all of it against a spring with a slider (Jenkins), behind a play."""
    F_h, z_y, b, h = 4.0, 6e-4, 3e-4, 5e-6
    sine = Sine(SMALL).derivative
    fine = np.arange(round(2.0 / h) + 1) * h
    x, v = sine(fine, 0), sine(fine, 1)
    every = slice(None, None, round(DT / h))
    t = np.arange(fine[every].size) * DT
    inputs = motion(DT, sine(t, 0), sine(t, 1), 0.0 * t, sine(t, 2))

    def missed(e: float, wanted: np.ndarray) -> float:
        brake = {"F_h": F_h, "F_u": 0.0, "z_y": z_y, "b": b, "e": e}
        error = predict(Model("brake", {"friction_with_play": brake}, SMALL), inputs) - wanted
        return float(error[200:].std() / span(wanted))  # both forget where they began

    w, shared = 0.0, np.empty(fine.size)
    for i, speed in enumerate(v):
        beyond = max(w - b - 0.6 * z_y, 0.0) + min(w + b + 0.6 * z_y, 0.0)
        shared[i] = F_h * (max(w - b, 0.0) + min(w + b, 0.0)) / z_y
        w += h * (speed - abs(speed) * beyond / (0.4 * z_y))
    assert missed(0.6, shared[every]) < 2e-3
    w, slider = 0.0, np.empty(fine.size)
    for i in range(fine.size):
        w = min(max(w + (x[i] - x[max(i - 1, 0)]), -b - z_y), b + z_y)
        slider[i] = F_h * (max(w - b, 0.0) + min(w + b, 0.0)) / z_y
    assert missed(0.98, slider[every]) < 6e-3
    assert missed(0.0, slider[every]) > 5e-2


def test_the_field_is_dragged_along_by_the_duty_and_stays() -> None:
    """Against the play operator, on steps, a ramp and a slow sine of the duty, with and without a response time."""
    r, s, n = 0.04, 0.7, 900
    t, ones = np.arange(n) * DT, np.ones(n)
    duty = np.repeat(np.random.default_rng(2).choice([0.0, 0.1, 0.13, 0.2, 0.3], 10), 30)
    duty = np.concatenate([duty, np.linspace(0.0, 0.3, 300), 0.15 + 0.15 * np.sin(9.0 * t[:300])])
    w, field = 0.0, np.empty(n)
    for k, u in enumerate(duty):
        w = min(max(w, u - r), u + r)
        field[k] = u + s * (w - u)
    model = guo().with_effect("remanence", {"r": r, "s": s})
    inputs = motion(DT, 0.0 * t, 0.1 * ones, duty, 0.0 * ones)
    dragged = motion(DT, 0.0 * t, 0.1 * ones, field, 0.0 * ones)
    for damper in (model, model.without_effect("response")):
        plain = damper.without_effect("remanence")
        assert np.abs(predict(damper, inputs) - predict(plain, dragged)).max() < 1e-8
    assert np.abs(predict(model, inputs) - predict(guo(), inputs)).max() > 0.5


def test_the_field_is_dragged_along_in_the_car_too() -> None:
    """Steps of the duty, which come within a sample, move the body as the duties of the play operator would."""
    r, s, duty = 0.04, 0.7, np.repeat([0.0, 0.3, 0.1, 0.05, 0.2, 0.0], 30)
    w, field = 0.0, np.empty(duty.size)
    for k, u in enumerate(duty):
        w = min(max(w, u - r), u + r)
        field[k] = u + s * (w - u)
    road = 0.004 * np.sin(30.0 * np.arange(duty.size) * DT)
    late = car().with_effect("dead_time", {"T_d": 0.0031})
    wanted = simulate(late, DT, road, field)["damper_force"]
    dragged = late.with_effect("remanence", {"r": r, "s": s})
    found = simulate(dragged, DT, road, duty)["damper_force"]
    assert np.abs(found - wanted).max() < 1e-6 * span(wanted)


def test_a_joint_with_play_presses_before_friction_slides() -> None:
    """Against the balance of joint and damper, solved at small steps: friction holds until the contact pushes more."""
    F_c, v_0, c_0, k_0, b, q, h = 20.0, 2e-3, 2.0, 100.0, 8e-4, 4e-5, 2e-5
    sine = Sine(SMALL).derivative
    fine = np.arange(round(1.0 / h) + 1) * h
    x, inner, force = sine(fine, 0), sine(fine, 0)[0], np.zeros(fine.size)
    for i in range(1, fine.size):
        low, high = -5.0, 5.0  # the velocity of the damper, for which the balance grows
        for _ in range(50):
            v = 0.5 * (low + high)
            s = x[i] - inner - h * v
            push = (max(s - b, 0.0) - max(-s - b, 0.0)) / q
            own = k_0 * (inner + h * v) + c_0 * v + F_c * np.tanh(v / v_0)
            low, high = (low, v) if own > push else (v, high)
        inner += h * v
        force[i] = push
    every = slice(None, None, round(DT / h))
    t = np.arange(fine[every].size) * DT
    inputs = motion(DT, sine(t, 0), sine(t, 1), 0.0 * t, sine(t, 2))
    brake = {"passive": {"k0": k_0, "c0": c_0}, "coulomb_friction": {"F_c": F_c, "v_0": v_0}}
    model = Model("brake", brake, SMALL).with_effect("freeplay", {"b": b, "q": q})
    error = (predict(model, inputs) - force[every])[60:]
    assert np.mean(np.abs(force[every]) < 1e-9) > 0.03
    assert error.std() < 0.01 * span(force)
