"""Measurements of a damper with Coulomb friction on an imposed motion, for tests of commands."""

from collections.abc import Sequence
from pathlib import Path

import numpy as np
from er_models.files import load_model
from er_models.model import Model
from er_models.prediction import motion, predict
from er_models.simulation import simulate

from test.conftest import ROOT


def with_friction(damper: str) -> Model:
    """A shipped damper with Coulomb friction."""
    model = load_model(ROOT / f"config/dampers/{damper}.yaml")
    return model.with_effect("coulomb_friction", {"F_c": 1.0, "v_0": 0.003})


def write_sample(
    path: Path, *, seed: int, seconds: float = 20.0, truth: Model | None = None,
    levels: Sequence[float] = (0.0, 0.1, 0.2, 0.3), hold: int = 150,
) -> Path:  # fmt: skip
    """Write a CSV with the contract's columns: six sines, steps of duty, noise of every sensor.

    truth: the damper, by default the Guo damper with friction; levels, hold: duties and samples each is held.
    """
    truth = truth or with_friction("inove_guo")
    rng, dt = np.random.default_rng(seed), 0.005
    n = round(seconds / dt)
    t = np.arange(n) * dt
    w = 2 * np.pi * np.array([0.7, 1.3, 2.1, 3.4, 5.2, 7.3])
    amplitude = 0.09 / w / 2.5
    arg = np.multiply.outer(t, w) + rng.uniform(0, 2 * np.pi, w.size)
    x, v, a = (
        np.sin(arg) @ amplitude,
        np.cos(arg) @ (amplitude * w),
        -np.sin(arg) @ (amplitude * w**2),
    )
    u = np.repeat(rng.choice(levels, n // hold + 1), hold)[:n]
    columns = {
        "t": t,
        "deflection": x + 2e-5 * rng.standard_normal(n),
        "deflection_velocity": v + 1e-3 * rng.standard_normal(n),
        "duty": u,
        "damper_force": predict(truth, motion(dt, x, v, u, a)) + 0.15 * rng.standard_normal(n),
        "sprung_acceleration": a + 0.025 * rng.standard_normal(n),
        "unsprung_acceleration": 0.025 * rng.standard_normal(n),
    }
    table = np.stack(list(columns.values()), axis=1)
    np.savetxt(path, table, delimiter=",", header=",".join(columns), comments="")
    return path


def write_ride(path: Path, *, seed: int, seconds: float = 8.0) -> Path:
    """Write a CSV of a quarter car with friction beside its damper: six sines of road, noise of every sensor."""
    car = load_model(ROOT / "config/vehicles/inove_quarter_car.yaml")
    truth = car.with_effect("guide_friction", {"F_g": 0.8, "v_0": 0.003})
    rng, dt = np.random.default_rng(seed), 0.005
    n = round(seconds / dt)
    t, f = np.arange(n) * dt, np.array([1.1, 1.9, 2.7, 3.6, 4.6, 6.1])
    phase = np.multiply.outer(t, 2 * np.pi * f) + rng.uniform(0, 2 * np.pi, f.size)
    u = np.repeat(rng.choice((0.0, 0.1, 0.2, 0.3), n // 100 + 1), 100)[:n]
    run = simulate(truth, dt, np.sin(phase) @ (0.012 / f), u)
    noise = {
        "damper_force": 0.15,
        "sprung_acceleration": 0.025,
        "unsprung_acceleration": 0.025,
        "deflection": 2e-5,
    }
    columns = {"t": t, "road": run["road"], "duty": u}
    columns |= {name: run[name] + sd * rng.standard_normal(n) for name, sd in noise.items()}
    table = np.stack(list(columns.values()), axis=1)
    np.savetxt(path, table, delimiter=",", header=",".join(columns), comments="")
    return path
