"""One sample after another gives what a whole record gives."""

from __future__ import annotations

import numpy as np
import pytest
from er_models.errors import InputError
from er_models.files import load_model
from er_models.following import Sample, begin, follow, follower
from er_models.model import Array, Model
from er_models.prediction import Motion, motion, predict

DT = 0.005
CASES = {
    "as it is": {},
    "hysteresis": {"bouc_wen_hysteresis": None},
    "states that feed back": {"mount_compliance": {"q": 2e-5}},
    "dead time in samples": {"dead_time": {"T_d": 0.010}},
    "dead time between samples": {"dead_time": {"T_d": 0.0123}},
    "late force": {"force_delay": {"d": 0.0131}},
    "fading with time": {"effectiveness_fade": None},
}


@pytest.fixture(scope="module")
def ride() -> Motion:
    t = np.arange(400) * DT
    x = 4e-3 * np.sin(12.0 * t) + 1e-3 * np.sin(46.0 * t)
    return motion(DT, x, np.gradient(x, DT), 0.05 + 0.2 * ((2.0 * t).astype(int) % 2))


def along(model: Model, m: Motion, apart: tuple[float, ...] = (0.0,)) -> Array:
    """Forces (n, m) [N] sample by sample."""
    f = follower(model, m.dt, apart)
    samples = [Sample(*each) for each in zip(m.x, m.v, m.a, m.u, m.theta, strict=True)]
    state = begin(f, samples[0])
    found = [state.forces]
    for sample in samples[1:]:
        state = follow(f, state, sample)
        found.append(state.forces)
    return np.array(found)


@pytest.mark.parametrize("case", CASES)
def test_it_is_the_prediction_of_the_record(ride: Motion, case: str) -> None:
    model = load_model("inove_guo")
    for name, values in CASES[case].items():
        model = model.with_effect(name, values)
    expected = predict(model, ride)
    found = along(model, ride)[:, 0]
    error = np.abs(found - expected)
    # a force that is shown late: what was before the record is held, and its last slopes are one-sided
    assert error[5:-1].max() < 1e-12 * np.abs(expected).max()
    assert error.max() < 1e-3 * np.abs(expected).max()


def test_a_force_that_is_shown_at_once_is_not_foreseen(ride: Motion) -> None:
    model = load_model("inove_guo").with_effect("force_delay", {"d": 0.002})
    found, expected = along(model, ride)[:, 0], predict(model, ride)
    assert 0.0 < np.abs(found - expected).max() < 0.05 * expected.std()


def test_dampers_apart_are_those_of_other_velocities(ride: Motion) -> None:
    model = load_model("inove_guo")
    found = along(model, ride, (0.0, 1e-3, -1e-3))
    for i, more in enumerate((0.0, 1e-3, -1e-3)):
        other = Motion(ride.dt, ride.x, ride.v + more, ride.a, ride.u, ride.theta, ride.starts)
        assert np.allclose(found[:, i], predict(model, other), rtol=1e-12, atol=1e-12)


def test_a_step_is_pure(ride: Motion) -> None:
    f = follower(load_model("inove_guo"), DT)
    start = begin(f, Sample(0.0, 0.0, 0.0, 0.1))
    once, again = (follow(f, start, Sample(1e-3, 0.1, 0.0, 0.2)) for _ in range(2))
    assert once.forces[0] == again.forces[0] != start.forces[0]
    with pytest.raises(InputError, match="dt: expected a time above 0 s, found 0 s"):
        follower(load_model("inove_guo"), 0.0)
