"""A sensor that repeats itself is stuck; one that stands still, or is coarse, is not."""

from __future__ import annotations

import math
from random import Random

import pytest
from er_ros_common.stuck import Watched, check

MS = 1_000_000
RESTING = (0.2, 0.2)


def found(samples: list[tuple[float, float]]) -> int | None:
    """First sample of these, 5 ms apart, at which something is stuck."""
    state = Watched()
    for k, values in enumerate(samples):
        state, bad = check(state, values, RESTING, 10**15 + 5 * MS * k)
        if bad:
            return k
    return None


def noise(n: int, seed: int = 1) -> list[tuple[float, float]]:
    """Accelerations that move."""
    random = Random(seed)
    return [(random.gauss(0.0, 1.0), random.gauss(0.0, 5.0)) for _ in range(n)]


@pytest.mark.parametrize("field", [0, 1])
def test_one_stuck_field_is_found_within_150_ms(field: int) -> None:
    samples = noise(60)
    held = samples[20][field]
    for k in range(20, 60):
        samples[k] = (held, samples[k][1]) if field == 0 else (samples[k][0], held)
    k = found(samples)
    assert k is not None
    assert 5 * (k - 20) <= 150


def test_a_whole_message_that_is_stuck_in_motion_is_found() -> None:
    samples = noise(20) + [(1.5, -3.0)] * 40
    k = found(samples)
    assert k is not None
    assert 5 * (k - 20) <= 150


def test_noise_is_never_stuck() -> None:
    assert found(noise(12_000, seed=2)) is None


def test_a_coarse_sensor_is_not_stuck() -> None:
    """A resolution as coarse as the noise repeats values, in both fields."""
    coarse = [(float(round(a)), 5.0 * round(b / 5.0)) for a, b in noise(12_000, seed=3)]
    assert found(coarse) is None


def test_standing_still_is_not_stuck() -> None:
    assert found([(0.02, -0.01)] * 400) is None


def test_what_is_not_a_number_stays_what_it_is() -> None:
    assert found([(math.nan, float(k)) for k in range(60)]) is not None
