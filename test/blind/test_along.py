"""The truth run along a measured motion gives the force it gave, and feels the sensors of that motion."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from test.blind.along import force_along
from test.blind.case import Case
from test.blind.generator import make_case

pytestmark = pytest.mark.slow


def made(effect: str | None, folder: Path) -> Case:
    return make_case(effect, 3, out=folder / "case", n_records=2, seconds=8.0)


def channels(case: Case, record: int) -> np.ndarray:
    """Noiseless deflection, velocity and acceleration, (n, 3)."""
    k = case.clean[record]
    a = k["sprung_acceleration"] - k["unsprung_acceleration"]
    return np.stack([k["deflection"], k["deflection_velocity"], a], axis=1)


@pytest.mark.parametrize(
    "effect", [None, "mount_compliance", "force_delay", "deflection_zero", "viscoelastic_branch"]
)
def test_the_exact_motion_gives_the_exact_force(effect: str | None, tmp_path: Path) -> None:
    case = made(effect, tmp_path)
    for record in range(2):
        left = force_along(case, record, channels(case, record))
        left = left - case.clean[record]["damper_force"]
        assert np.sqrt(np.mean(left**2)) < 0.005


def test_noise_of_the_velocity_shows_in_the_force(tmp_path: Path) -> None:
    case = made(None, tmp_path)
    noisy = channels(case, 0)
    noisy[:, 1] += 1e-3 * np.random.default_rng(0).standard_normal(noisy.shape[0])
    left = force_along(case, 0, noisy) - case.clean[0]["damper_force"]
    assert 0.05 < np.sqrt(np.mean(left**2)) < 1.0
