"""Alignment of a device's clock: right within its own deviation, whatever the jitter."""

import numpy as np
import pytest
from er_plant_sim.hardware import clocks
from er_plant_sim.hardware.clocks import ClockModel, ClockState, Exchange

DRIFT, START = 8e-5, 7_123_456_789_000


def device(host: float) -> int:
    """Time of the device [ns] at a time of the host [s]."""
    return START + round(1e9 * host * (1.0 + DRIFT))


def exchanges(seed: int, count: int, jitter: float, least: float = 3e-4) -> list[Exchange]:
    """Ten a second, each way delayed by at least so much and exponentially more, now and then by 20 ms."""
    draw = np.random.default_rng(seed)
    found = []
    for k in range(count):
        ways = least + jitter * draw.exponential(size=2) + 0.02 * (draw.random(2) < 0.05)
        asked, received = 0.1 * k, 0.1 * k + ways[0]
        answered = received + 5e-5
        heard = answered + ways[1]
        found.append(
            Exchange(round(1e9 * asked), device(received), device(answered), round(1e9 * heard))
        )
    return found


def errors(state: ClockState, host: float) -> float:
    """Error of a stamp at a time of the host [s]."""
    return 1e-9 * clocks.to_host(state, device(host)) - host


@pytest.mark.parametrize("jitter", [0.0, 2e-4, 5e-3])
def test_offset_and_drift_are_found_within_their_deviation(jitter: float) -> None:
    ratios = []
    for seed in range(20):
        state = ClockState()
        for exchange in exchanges(seed, 300, jitter):
            state = clocks.step(ClockModel(), state, exchange)
        error = errors(state, 30.0)
        ratios.append(error / clocks.deviation(state))
        # far better than the least delay itself, 0.6 ms there and back
        assert abs(error) < 1e-4 + 0.1 * jitter
        # host seconds per device second, less one
        assert state.drift == pytest.approx(-DRIFT, abs=2e-6 + 2e-3 * jitter)
        assert state.restarts == 0
    assert np.mean(np.abs(ratios) < 3.0) >= 0.95


def test_a_device_that_restarts_is_noticed_at_once() -> None:
    state = ClockState()
    for exchange in exchanges(1, 100, 1e-3):
        state = clocks.step(ClockModel(), state, exchange)
    late = Exchange(*(round(v) for v in (1e10, 500, 1000, 1e10 + 700_000)))
    state = clocks.step(ClockModel(), state, late)
    assert (state.restarts, state.exchanges) == (1, 1)
    assert clocks.to_host(state, 750) == pytest.approx(1e10 + 350_000, abs=2)


def test_an_answer_before_its_question_changes_nothing() -> None:
    state = clocks.step(ClockModel(), ClockState(), Exchange(0, 10, 20, 100))
    assert clocks.step(ClockModel(), state, Exchange(100, 10, 20, 50)) is state
    assert clocks.step(ClockModel(), state, Exchange(0, 20, 10, 100)) is state
