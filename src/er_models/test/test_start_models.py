"""Start models of dampers of other kinds: each takes energy, and shows in figures what its file says."""

from __future__ import annotations

import numpy as np
import pytest
from er_models.files import load_model
from er_models.model import Array, Model
from er_models.prediction import motion, predict

DT = 1e-3
T = np.arange(2001) * DT
OMEGA = 2.0 * np.pi * 1.0


def cycled(model: Model, share: float, duty: float) -> tuple[Array, Array]:
    """Velocity and force (n,) of the second cycle of a sine of 1 Hz that takes a share of the fastest."""
    top = share * model.scales.velocity
    x, v = top / OMEGA * np.sin(OMEGA * T), top * np.cos(OMEGA * T)
    force = predict(model, motion(DT, x, v, duty + 0.0 * T, -(OMEGA**2) * x))
    return v[1000:], force[1000:]


@pytest.mark.parametrize("name", ["monotube_passive", "mr_hysteretic", "friction_brake"])
def test_a_cycle_takes_energy(name: str) -> None:
    for duty in (0.0, 1.0):
        v, force = cycled(load_model(name), 0.9, duty)
        assert np.isfinite(force).all()
        assert np.sum(force * v) * DT > 0.0


def test_the_monotube_has_a_knee_in_each_direction() -> None:
    """Slopes beyond the knees are those of the file: 4500 less 2800 and 3400 N s/m, less what the width still takes."""
    v, force = cycled(load_model("monotube_passive"), 0.9, 0.0)
    for sign, beyond, knee in ((1.0, 1700.0, 0.15), (-1.0, 1100.0, 0.10)):
        near, far = (sign * v > 0.03) & (sign * v < knee), sign * v > 0.3
        slopes = [np.polyfit(v[rows], force[rows], 1)[0] for rows in (near, far)]
        assert slopes[0] == pytest.approx(4500.0, rel=0.05)
        assert slopes[1] == pytest.approx(beyond, rel=0.05)


def test_the_hysteretic_damper_has_spencers_levels() -> None:
    """At the fastest: 2100 + 788 u N s/m, and 90 + 1007 u N of the sliding bristle, about the 71.5 N of the gas."""
    for duty in (0.0, 1.0):
        v, force = cycled(load_model("mr_hysteretic"), 0.9, duty)
        swing = float(np.ptp(force[np.abs(v) > 0.999 * 0.225])) / 2.0
        assert swing == pytest.approx(
            (2100.0 + 788.0 * duty) * 0.225 + 90.0 + 1007.0 * duty, rel=0.02
        )


def test_the_brake_is_idle_in_its_play() -> None:
    """200 + 2300 u N when it slides, and nothing but 300 N s/m for the play after each reversal."""
    model = load_model("friction_brake")
    v, force = cycled(model, 0.9, 1.0)
    assert np.abs(force - 300.0 * v).max() == pytest.approx(2500.0, rel=0.01)
    idle = np.abs(force - 300.0 * v) < 1e-6
    travel = float(np.sum(np.abs(v[idle])) * DT)
    assert travel == pytest.approx(2.0 * 2.0 * 4.5e-4, rel=0.2)
