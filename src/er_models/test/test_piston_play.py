"""Damped play of the piston: its plateau by hand, and the whole loop by another integrator."""

from __future__ import annotations

import numpy as np
import pytest
from er_models.model import Array, Model
from er_models.prediction import Motion, motion, predict
from models_help import DT, SMALL, Sine, guo, span

B, C_P, DUTY = 4e-4, 100.0, 0.25


def damper(*, tau: float) -> Model:
    """A steep yield force with play, and nothing else."""
    gate = {"f_c": 20.0, "k1": 0.0, "c1": 2000.0}
    play = {"b": B, "c_p": C_P}
    effects = {"guo_yield": gate, "response": {"tau": tau}, "piston_play": play}
    return Model("play", effects, SMALL)


def reversed_once(v: float, seconds: float) -> Motion:
    """To one side and back, at a constant velocity [m/s] each."""
    t = np.arange(round(2 * seconds / DT)) * DT
    forth = t < seconds
    x = np.where(forth, v * t, 2.0 * v * seconds - v * t)
    return motion(DT, x, np.where(forth, v, -v), np.full(t.size, DUTY), np.zeros(t.size))


@pytest.mark.parametrize("v", [0.01, 0.03])
def test_the_play_carries_its_damping_and_then_the_yield_force(v: float) -> None:
    """20 N per duty at 0.25 is 5 N; the play 2 b lets 1 N or 3 N through, for 80 ms or 27 ms."""
    force = predict(damper(tau=1e-4), reversed_once(v, 0.5))
    back = force[round(0.5 / DT) :]
    assert force[round(0.4 / DT)] == pytest.approx(5.0, rel=1e-6)
    plateau = back[2 : int(2 * B / v / DT) - 1]
    assert plateau.size >= 2
    slip = np.arctanh(C_P * v / 5.0) / 2000.0
    assert plateau == pytest.approx(-C_P * v, rel=1.1 * slip / v)
    assert back[int(2 * B / v / DT) + 3 :] == pytest.approx(-5.0, rel=1e-6)


def by_small_steps(model: Model, t: Array, every: int) -> Array:
    """Force at each `every`-th of the times t, by explicit steps of the play in series with the yield."""
    sine, h = Sine(SMALL).derivative, float(t[1] - t[0])
    x, v = sine(t, 0), sine(t, 1)
    p, y, play = (model.effects[e] for e in ("passive", "guo_yield", "piston_play"))
    b, c_p = play["b"], play["c_p"]
    tau = model.effects["response"]["tau"]
    w, f_y, force = 0.0, 0.0, np.empty(t.size)
    for i in range(t.size):
        pressed = abs(w) >= b and w * f_y > 0.0
        v_f = v[i] if pressed else v[i] - f_y / c_p
        force[i] = p["k0"] * x[i] + p["c0"] * v[i] + f_y
        goal = y["f_c"] * DUTY * np.tanh(y["k1"] * (x[i] - w) + y["c1"] * v_f)
        w = min(max(w + h * (v[i] - v_f), -b), b)
        f_y += h / tau * (goal - f_y)
    return force[::every]


def test_agrees_with_small_steps_of_the_contact() -> None:
    h = 1e-5
    t = np.arange(round(1.2 / h) + 1) * h
    model = guo().with_effect("piston_play", {"b": 1e-3, "c_p": 30.0})
    exact = by_small_steps(model, t, round(DT / h))
    t = np.arange(exact.size) * DT
    sine = Sine(SMALL).derivative
    inputs = motion(DT, sine(t, 0), sine(t, 1), np.full(t.size, DUTY), sine(t, 2))
    faded = t > 0.4  # both begin somewhere in the play
    error = (predict(model, inputs) - exact)[faded]
    assert error.std() < 1e-3 * span(exact)
    assert (predict(guo(), inputs) - exact)[faded].std() > 3e-2 * span(exact)
