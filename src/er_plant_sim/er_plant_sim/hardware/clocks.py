r"""Time of a device on the host's clock, from questions and answers over a link that delays both.

The host asks at t_1, the device receives at t_2 and answers at t_3, the answer arrives at t_4 (t_1, t_4 on
the host's clock, t_2, t_3 on the device's). Delays are not negative, so the offset (host minus device)
lies in

.. math::  t_1 - t_2 \le \theta \le t_4 - t_3 ,

an interval as wide as the link delayed both ways together, whatever the jitter. A Kalman filter of offset and drift
takes the middle of each interval with half its width as standard deviation: an exchange that was held up
says little, one that was not says much. An interval that the estimate cannot reach means that a clock was
set or the device restarted: the filter begins anew.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple


@dataclass(frozen=True, slots=True)
class ClockModel:
    """What is known of the clocks beforehand.

    drift: standard deviation of the relative difference of pace (crystals: 100 ppm or less) [1]; wander:
    of its change in a second [1/sqrt(s)]; floor: no exchange is taken to be better than this [s];
    reach: standard deviations beyond an interval that mean another clock [1].
    """

    drift: float = 2e-4
    wander: float = 1e-7
    floor: float = 2e-6
    reach: float = 6.0


class Exchange(NamedTuple):
    """A question and its answer [ns]: asked and heard on the host's clock, the others on the device's."""

    asked: int
    received: int
    answered: int
    heard: int


class ClockState(NamedTuple):
    """Offset [s] beyond `host` minus `device` [ns] at device time `at` [ns], drift [1], their covariance.

    exchanges: used since the clocks began; restarts: times they began anew; width: of the last interval [s].
    """

    host: int = 0
    device: int = 0
    at: int = 0
    offset: float = 0.0
    drift: float = 0.0
    p_oo: float = math.inf
    p_od: float = 0.0
    p_dd: float = 0.0
    exchanges: int = 0
    restarts: int = 0
    width: float = math.inf


def step(p: ClockModel, state: ClockState, exchange: Exchange) -> ClockState:
    """The state after one more exchange; one that cannot be (an answer before its question) changes nothing."""
    width = 1e-9 * ((exchange.heard - exchange.asked) - (exchange.answered - exchange.received))
    if width < 0.0 or exchange.answered < exchange.received:
        return state
    if not state.exchanges:
        return _begin(p, exchange, width, state.restarts)
    middle = (exchange.asked - exchange.received + exchange.heard - exchange.answered) // 2
    measured = 1e-9 * (middle - (state.host - state.device))
    predicted = _predicted(p, state, exchange.answered)
    error = measured - predicted.offset
    if abs(error) > 0.5 * width + p.reach * (math.sqrt(predicted.p_oo) + p.floor):
        return _begin(p, exchange, width, state.restarts + 1)
    return _updated(p, predicted, error, width)


def to_host(state: ClockState, time: int) -> int:
    """A time of the device on the host's clock [ns]."""
    ahead = 1e-9 * (time - state.at)
    return time + state.host - state.device + round(1e9 * (state.offset + state.drift * ahead))


def deviation(state: ClockState) -> float:
    """Standard deviation of the offset at the last exchange [s]; infinite before the first.

    What the link delays one way more than the other, always, cannot be seen and is not in it: half the
    shortest way there and back at most.
    """
    return math.sqrt(state.p_oo)


def deviation_later(p: ClockModel, state: ClockState, after: int) -> float:
    """The same so long after the last exchange [ns]: it grows with what is not known of the drift."""
    return deviation(_predicted(p, state, state.at + after))


def _begin(p: ClockModel, exchange: Exchange, width: float, restarts: int) -> ClockState:
    host, device = (
        (exchange.asked + exchange.heard) // 2,
        (exchange.received + exchange.answered) // 2,
    )
    variance = (0.5 * width) ** 2 + p.floor**2
    return ClockState(
        host, device, exchange.answered, p_oo=variance, p_dd=p.drift**2, exchanges=1,
        restarts=restarts, width=width,
    )  # fmt: skip


def _predicted(p: ClockModel, s: ClockState, at: int) -> ClockState:
    """The state at a later device time: the offset grows with the drift, the drift wanders."""
    h = 1e-9 * (at - s.at)
    grown = s.p_dd + p.wander**2 * abs(h)
    p_oo = s.p_oo + h * (2.0 * s.p_od + h * s.p_dd) + p.wander**2 * abs(h) ** 3 / 3.0
    return s._replace(
        at=at, offset=s.offset + h * s.drift, p_oo=p_oo, p_od=s.p_od + h * s.p_dd, p_dd=grown
    )


def _updated(p: ClockModel, s: ClockState, error: float, width: float) -> ClockState:
    total = s.p_oo + (0.5 * width) ** 2 + p.floor**2
    k_o, k_d = s.p_oo / total, s.p_od / total
    return s._replace(
        offset=s.offset + k_o * error,
        drift=s.drift + k_d * error,
        p_oo=(1.0 - k_o) * s.p_oo,
        p_od=(1.0 - k_o) * s.p_od,
        p_dd=s.p_dd - k_d * s.p_od,
        exchanges=s.exchanges + 1,
        width=width,
    )
