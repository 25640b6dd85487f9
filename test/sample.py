"""Measurements of a damper with Coulomb friction on an imposed motion, for tests of commands."""

from pathlib import Path

import numpy as np
from er_models.files import load_model
from er_models.predict import motion, predict

from test.conftest import ROOT


def write_sample(path: Path, *, seed: int, seconds: float = 20.0) -> Path:
    """Write a CSV with the contract's columns: six sines, steps of duty, noise of every sensor."""
    truth = load_model(ROOT / "config/dampers/inove_guo.yaml")
    truth = truth.with_effect("coulomb_friction", {"F_c": 1.0, "v_0": 0.003})
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
    u = np.repeat(rng.choice([0.0, 0.1, 0.2, 0.3], n // 150 + 1), 150)[:n]
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
