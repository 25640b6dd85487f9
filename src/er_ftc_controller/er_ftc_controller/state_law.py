r"""One sample of the scheduled state feedback: from the sensors to the yield force that the damper is to head for.

.. math::  c = -\sum_i \theta_i K_i \, [z_{def}, \dot z_s, z_t, \dot z_{us}, F_{er}]^T, \quad
           \theta_i \ge 0, \quad \sum_i \theta_i \le 1

The state is read, not observed: deflection and its rate are measured, the body's velocity is the leaky integral of its
acceleration, the wheel's is that less the deflection's, the tyre's deflection follows from both accelerations, and the
force loop follows the yield force. Two measures of the last half period of the body tell which gain acts:

- its frequency, the root of the mean square of its acceleration over that of its velocity: below the body's own the
  gain of a slow road, about it that of the resonance. Above it none, once it has been above for a while: a bump begins
  with a fast edge, too, and the resonance is what follows.
- the share of the deflection's mean square about the body's frequency, times the square of the frequency: large where a
  road moves the body and the wheel at once, small for any single tone. Then the gain of a rough road acts.

Source: Gupta 1980 (weights by frequency); Savaresi and Spelta 2007 (acceleration over velocity); shares are ours.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

Gain: TypeAlias = tuple[float, float, float, float, float]
SLOW, FAST = (0.51, 0.70), (1.165, 1.467)
"""Edges over the body's frequency: from slow to resonance, from resonance to none."""
MEMORY, LONG = 0.52, 1.3
"""Memory of the frequency; of the share, and of being fast: in periods of the body."""
LASTING = (0.3, 0.6)
"""How lasting a fast motion is from which on the gains fall, and are gone."""
ROUGH = (0.7, 1.1)
"""Edges of the share times the square of the frequency."""
QUIET = 0.014
"""Acceleration over that of a swing by the stroke that counts as none."""


@dataclass(frozen=True)
class StateLaw:
    """Gains of the regimes `slow`, `resonance` and `rough`; sprung, unsprung mass [kg], tyre [N/m].

    corner: of the leaky integral [rad/s]; frequency: of the body [Hz]; swing: its acceleration in a swing by the stroke
    [m/s2].
    """

    gains: tuple[Gain, Gain, Gain]
    body: tuple[float, float, float]
    corner: float
    frequency: float
    swing: float


class Shares(NamedTuple):
    """Shares of the gains."""

    slow: float
    resonance: float
    rough: float


class Told(NamedTuple):
    """What tells the regime.

    a2, v2, x2, band2: mean squares of acceleration, velocity, deflection and its part about the body's frequency;
    filters: of that part; fast: how lasting a fast motion is.
    """

    a2: float = 0.0
    v2: float = 0.0
    x2: float = 0.0
    band2: float = 0.0
    filters: tuple[float, float, float, float] = (0.0, 0.0, 0.0, 0.0)
    fast: float = 0.0


class State(NamedTuple):
    """The body's velocity [m/s]; last accelerations [m/s2] and for how long none came [s]; the regime."""

    velocity: float = 0.0
    sprung: float = math.nan
    unsprung: float = math.nan
    missing: float = math.inf
    told: Told = Told()
    shares: Shares = Shares(0.0, 0.0, 0.0)


START = State()


def step(
    p: StateLaw, state: State, motion: tuple[float, float], accelerations: tuple[float, float],
    force: float, dt: float,
) -> tuple[State, float]:  # fmt: skip
    """Yield force to head for [N]; motion: deflection [m], rate [m/s]; accelerations: NaN for those of before.

    force: yield force now [N]; dt: since the sample before [s].
    """
    (x, v), (sprung, unsprung), missing = motion, accelerations, 0.0
    if not math.isfinite(sprung + unsprung):
        sprung, unsprung, missing = state.sprung, state.unsprung, state.missing + dt
    before = state.sprung if math.isfinite(state.sprung) else sprung
    velocity = state.velocity * math.exp(-p.corner * dt) + 0.5 * dt * (before + sprung)
    told, ratio = _told(p, state.told, x, sprung, velocity, dt)
    shares = _shares(told, ratio)
    m_s, m_us, k_t = p.body
    tyre, wheel, goal = -(m_s * sprung + m_us * unsprung) / k_t, velocity - v, 0.0
    for share, k in zip(shares, p.gains):
        if share:
            goal -= share * (
                k[0] * x + k[1] * velocity + k[2] * tyre + k[3] * wheel + k[4] * force
            )
    return State(velocity, sprung, unsprung, missing, told, shares), goal


def _told(
    p: StateLaw, before: Told, x: float, sprung: float, velocity: float, dt: float
) -> tuple[Told, float]:
    """What tells the regime one sample on; the frequency of the body's motion over its own."""
    band, filters = _about(p.frequency, before.filters, x, dt)
    short, long = math.exp(-dt * p.frequency / MEMORY), math.exp(-dt * p.frequency / LONG)
    a2 = short * before.a2 + (1.0 - short) * sprung * sprung
    v2 = short * before.v2 + (1.0 - short) * velocity * velocity
    x2 = long * before.x2 + (1.0 - long) * x * x
    band2 = long * before.band2 + (1.0 - long) * band * band
    quiet, ratio = (QUIET * p.swing) ** 2, _ratio(p, a2, v2)
    fast = long * before.fast + (1.0 - long) * _ramp(ratio, FAST) * a2 / (a2 + quiet)
    return Told(a2, v2, x2, band2, filters, fast), ratio


def _shares(told: Told, ratio: float) -> Shares:
    """Shares of the gains."""
    calm = 1.0 - _ramp(told.fast, LASTING)
    slow = min(1.0 - _ramp(ratio, SLOW), calm)
    many = told.band2 / told.x2 * ratio**2 if told.x2 > 0.0 else 0.0
    return Shares(slow, calm - slow, _ramp(many, ROUGH) * (1.0 - calm))


def _ratio(p: StateLaw, a2: float, v2: float) -> float:
    """Frequency of the body's motion over its own; the least acceleration that counts keeps it finite."""
    omega = 2.0 * math.pi * p.frequency
    floor = (0.1 * QUIET * p.swing / omega) ** 2
    return math.sqrt(a2 / (v2 + floor)) / omega


def _ramp(value: float, edges: tuple[float, float]) -> float:
    """From 0 at the first edge to 1 at the second."""
    return min(max((value - edges[0]) / (edges[1] - edges[0]), 0.0), 1.0)


def _about(
    hertz: float, s: tuple[float, float, float, float], x: float, dt: float
) -> tuple[float, tuple[float, float, float, float]]:
    """The part of x about a frequency: two band passes of quality one, integrated by trapezia, and their states."""
    g = math.tan(math.pi * min(hertz * dt, 0.25))
    band, first = _pass(g, s[0], s[1], x)
    band, second = _pass(g, s[2], s[3], band)
    return band, (*first, *second)


def _pass(g: float, s1: float, s2: float, x: float) -> tuple[float, tuple[float, float]]:
    """One band pass, gain one at its frequency."""
    high = (x - (1.0 + g) * s1 - s2) / (1.0 + g + g * g)
    band = g * high + s1
    low = g * band + s2
    return band, (g * high + band, g * band + low)
