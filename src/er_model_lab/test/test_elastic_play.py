"""A play whose contact gives way, by equations of its own: it is one effect, and no lag of the force beside another."""

from math import tanh

import numpy as np
import pytest
from er_model_lab.diagnosis.candidates import baseline, effect_size, finished, refit
from er_models.files import load_model
from lab_help import DT, FORCE_NOISE, GUO, imposed, problem_of
from scipy.interpolate import BPoly

GAP, STIFFNESS = 1.5e-4, 4e4
"""Half the gap [m], and the spring at either end of it [N/m]: half a millimetre at the largest force."""
FINE = 250
"""Steps of a sample."""


def through_play(force, x):
    """Force (n,) in place of another along the same motion: the damper behind the play, in explicit steps of 20 us."""
    del force
    x, v, a, u = imposed(np.random.default_rng(1), x.size)
    t = np.arange(x.size) * DT
    course = BPoly.from_derivatives(t, np.column_stack([x, v, a]))
    fine = np.arange((x.size - 1) * FINE + 1) * (DT / FINE)
    path, pace = course(fine).tolist(), course(fine, nu=1).tolist()
    k0, c0, f_c, k1, c1, tau = (
        load_model(GUO).value(*name)
        for name in (
            ("passive", "k0"), ("passive", "c0"), ("guo_yield", "f_c"), ("guo_yield", "k1"), ("guo_yield", "c1"),
            ("response", "tau"),
        )
    )  # fmt: skip
    gap, f_y, out, h = GAP, 0.0, [], DT / FINE
    for i, (x_i, v_i) in enumerate(zip(path, pace, strict=True)):
        out.append(STIFFNESS * (max(gap - GAP, 0.0) + min(gap + GAP, 0.0)))
        own, duty = x_i - gap, float(u[i // FINE])
        speed = (out[-1] - k0 * own - f_y) / c0
        f_y += h / tau * (f_c * duty * tanh(k1 * own + c1 * speed) - f_y)
        gap += h * (v_i - speed)
    return np.array(out[::FINE])


def test_a_contact_that_gives_way_is_no_lag_of_the_force():
    model, problem = problem_of(None, {}, seconds=12.0, bent=through_play)
    play = refit(baseline(model, problem), model.catalogue["freeplay"], problem)
    play = finished(play, problem)
    found = play.fit.model.effects["freeplay"]
    assert found == pytest.approx({"b": GAP, "q": 1.0 / STIFFNESS}, rel=0.05)
    lag = refit(play, model.catalogue["force_lag"], problem)
    assert effect_size(play, lag) < 0.12 * FORCE_NOISE
    assert np.sqrt(play.mse) < 1.15 * FORCE_NOISE
