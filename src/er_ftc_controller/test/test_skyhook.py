"""Skyhook (3.81): the switching law, and the leaky integral against its closed form."""

import math

import numpy as np
import pytest
from er_ftc_controller.skyhook import START, Sample, Skyhook, State, step, usable
from er_models.errors import InputError

P = Skyhook(u_min=0.02, u_max=0.3, corner_frequency=0.1)
DT = 0.005


def velocities(p: Skyhook, t: np.ndarray, a: np.ndarray) -> np.ndarray:
    """Velocity [m/s] the controller believes at each sample."""
    state, seen = START, []
    for when, acceleration in zip(t, a, strict=True):
        state, command = step(p, state, Sample(float(when), float(acceleration), 0.0))
        seen.append(command.sprung_velocity)
    return np.array(seen)


@pytest.mark.parametrize(
    ("body", "deflection", "duty"),
    [
        (0.1, 0.05, 0.3),
        (-0.1, -0.05, 0.3),
        (0.1, -0.05, 0.02),
        (-0.1, 0.05, 0.02),
        (0.1, 0.0, 0.3),
    ],
)
def test_full_field_only_where_it_brakes_the_body(
    body: float, deflection: float, duty: float
) -> None:
    state = State(body, Sample(0.0, 0.0, 0.0))
    _, command = step(P, state, Sample(DT, 0.0, deflection))
    assert command.duty == duty


def test_constant_acceleration_follows_the_closed_form() -> None:
    t = DT * np.arange(400)
    w = 2 * math.pi * P.corner_frequency
    assert np.allclose(
        velocities(P, t, np.full(400, 1.5)), 1.5 / w * (1 - np.exp(-w * t)), atol=1e-12
    )


def test_a_ramp_of_acceleration_is_exact_at_any_sample_time() -> None:
    for dt in (0.001, 0.02):
        t = dt * np.arange(200)
        w = 2 * math.pi * P.corner_frequency
        exact = 3.0 * (t / w - (1 - np.exp(-w * t)) / w**2)
        assert np.allclose(velocities(P, t, 3.0 * t), exact, atol=1e-12)


def test_velocity_of_a_body_at_resonance_is_right_in_size_and_phase() -> None:
    w, t = 2 * math.pi * 4.0, DT * np.arange(8000)
    seen = velocities(P, t, -w * 0.1 * np.sin(w * t))[4000:]
    true = 0.1 * np.cos(w * t)[4000:]
    gain = np.sqrt(np.mean(seen**2) / np.mean(true**2))
    assert gain == pytest.approx(1.0, abs=0.005)
    lead = math.degrees(
        math.acos(np.mean(seen * true) / np.sqrt(np.mean(seen**2) * np.mean(true**2)))
    )
    assert lead == pytest.approx(math.degrees(math.atan(0.1 / 4.0)), abs=0.1)


def test_a_biased_accelerometer_cannot_run_away() -> None:
    seen = velocities(P, DT * np.arange(20_000), np.full(20_000, 0.025))
    assert seen[-1] == pytest.approx(0.025 / (2 * math.pi * 0.1), rel=1e-3)


@pytest.mark.parametrize("jump", [0.06, 10.0, 0.0, -5.0])
def test_the_integral_starts_anew_after_a_jump_of_time(jump: float) -> None:
    state = State(0.7, Sample(20.0, 5.0, 0.0))
    state, command = step(P, state, Sample(20.0 + jump, 5.0, 0.1))
    assert (command.sprung_velocity, state.resets) == (0.0, 1)


@pytest.mark.parametrize("field", Sample._fields)
def test_values_that_are_not_finite_are_seen(field: str) -> None:
    good = Sample(0.0, 1.0, 2.0)
    assert usable(good)
    assert not usable(good._replace(**{field: math.nan}))


@pytest.mark.parametrize(
    "values", [(0.4, 0.3, 0.1), (0.0, 1.1, 0.1), (0.0, 0.3, 0.0), (0.0, 0.3, math.nan)]
)
def test_impossible_parameters_are_named(values: tuple[float, float, float]) -> None:
    with pytest.raises(InputError, match=r"skyhook_controller: (u_min|corner)"):
        Skyhook(*values)
