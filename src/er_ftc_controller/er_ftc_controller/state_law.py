r"""One sample of the scheduled state feedback: from the sensors to the yield force that the damper is to head for.

.. math::  c = -\sum_i \theta_i K_i \, [z_{def}, \dot z_s, z_t, \dot z_{us}, F_{er}]^T, \quad
           \theta_i \ge 0, \quad \sum_i \theta_i \le 1

The state is read, not observed: deflection and its rate are measured, the body's velocity is the leaky integral of its
acceleration, the wheel's is that less the deflection's, the tyre's deflection follows from both accelerations, and the
force loop follows the yield force. Two measures of the last half period of the body tell which gain acts:

- its frequency, the root of the mean square of its acceleration over that of its velocity: below the body's own the
  gain of a slow road, about it that of the resonance. Above it none, once it has been above for a while: a bump begins
  with a fast edge, too, and the resonance is what follows.
- the irregularity of the deflection, the variance of its rate over the standard deviations of deflection and second
  rate: 1 for any single tone, far below where a road moves the body and the wheel at once. Then the gain of a rough
  road acts: that of the healthy car, or of one whose damper leaks, mixed by the viscous force that faults leave.

Source: Gupta 1980 (weights by frequency); Savaresi and Spelta 2007 (acceleration over velocity); Rice 1945
(irregularity); shares are ours.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from typing import NamedTuple, TypeAlias

from er_ftc_controller.force_loop import ahead

Gain: TypeAlias = tuple[float, float, float, float, float]
SLOW, FAST = (0.51, 0.70), (1.165, 1.467)
"""Edges over the body's frequency: from slow to resonance, from resonance to none."""
MEMORY, LONG = 0.52, 1.3
"""Memory of the frequency; of the irregularity, and of being fast: in periods of the body."""
LASTING = (0.3, 0.6)
"""How lasting a fast motion is from which on the gains fall, and are gone."""
TONE = (0.4, 0.6)
"""Square of the irregularity: a rough road up to the first, a tone from the second on."""
LEAKING = 0.6
"""Share f_2 f_3 of the viscous force at which the gain of the leaking car acts alone; above, a mixture."""
COMFORT = (0.06, 0.23)
"""Share of the resonance's gain that goes to that of a rough road, which weighs comfort: healthy, and at that loss."""
QUIET = 0.014
"""Acceleration over that of a swing by the stroke that counts as none."""


@dataclass(frozen=True)
class StateLaw:
    """Gains of the regimes `slow`, `resonance`, `rough` and `leaking`; sprung, unsprung mass [kg], tyre [N/m].

    corner: of the leaky integral [rad/s]; frequency: of the body [Hz]; swing: its acceleration in a swing by the stroke
    [m/s2].
    """

    gains: tuple[Gain, Gain, Gain, Gain]
    body: tuple[float, float, float]
    corner: float
    frequency: float
    swing: float


class Shares(NamedTuple):
    """Shares of the gains."""

    slow: float
    resonance: float
    rough: float
    leaking: float


class Told(NamedTuple):
    """What tells the regime.

    a2, v2: mean squares of the body's acceleration and velocity; x, x2, w2, b2: mean of the deflection, mean squares of
    deflection, its rate and second rate; fast: how lasting a fast motion is.
    """

    a2: float = 0.0
    v2: float = 0.0
    x: float = 0.0
    x2: float = 0.0
    w2: float = 0.0
    b2: float = 0.0
    fast: float = 0.0


class State(NamedTuple):
    """The body's velocity [m/s]; last accelerations [m/s2] and for how long none came [s]; the regime."""

    velocity: float = 0.0
    sprung: float = math.nan
    unsprung: float = math.nan
    missing: float = math.inf
    told: Told = Told()
    shares: Shares = Shares(0.0, 0.0, 0.0, 0.0)


START = State()


def step(
    p: StateLaw, state: State, motion: tuple[float, float], accelerations: tuple[float, float],
    force: float, dt: float, left: float = 1.0, late: float = 0.0,
) -> tuple[State, float]:  # fmt: skip
    """Yield force to head for [N]; motion: deflection [m], rate [m/s]; accelerations: NaN for those of before.

    force: yield force now [N]; dt: since the sample before [s]; left: share f_2 f_3 of the viscous force; late: time
    until the duty acts [s], over which the accelerations lead the motion on.
    """
    (x, v), (sprung, unsprung), missing = motion, accelerations, 0.0
    if not math.isfinite(sprung + unsprung):
        sprung, unsprung, missing = state.sprung, state.unsprung, state.missing + dt
    before = state.sprung if math.isfinite(state.sprung) else sprung
    velocity = state.velocity * math.exp(-p.corner * dt) + 0.5 * dt * (before + sprung)
    told, ratio = _told(p, state.told, motion, (velocity, sprung, sprung - unsprung), dt)
    shares = _shares(told, ratio, left)
    m_s, m_us, k_t = p.body
    tyre, goal = -(m_s * sprung + m_us * unsprung) / k_t, 0.0
    x, v = ahead(x, v, sprung - unsprung, late)
    led = velocity + late * sprung
    wheel = led - v
    for share, k in zip(shares, p.gains):
        if share:
            goal -= share * (k[0] * x + k[1] * led + k[2] * tyre + k[3] * wheel + k[4] * force)
    return State(velocity, sprung, unsprung, missing, told, shares), goal


def _told(
    p: StateLaw, before: Told, deflection: tuple[float, float], body: tuple[float, float, float], dt: float
) -> tuple[Told, float]:  # fmt: skip
    """What tells the regime one sample on; the frequency of the body's motion over its own.

    deflection: it and its rate; body: velocity, acceleration, and that of the deflection.
    """
    (x, w), (v, a, b) = deflection, body
    short, long = math.exp(-dt * p.frequency / MEMORY), math.exp(-dt * p.frequency / LONG)
    new, late = 1.0 - short, 1.0 - long
    a2, v2 = short * before.a2 + new * a * a, short * before.v2 + new * v * v
    quiet, ratio = (QUIET * p.swing) ** 2, _ratio(p, a2, v2)
    told = Told(
        a2, v2, long * before.x + late * x, long * before.x2 + late * x * x, long * before.w2 + late * w * w,
        long * before.b2 + late * b * b,
        long * before.fast + late * _ramp(ratio, FAST) * a2 / (a2 + quiet),
    )  # fmt: skip
    return told, ratio


def _shares(told: Told, ratio: float, left: float) -> Shares:
    """Shares of the gains."""
    calm = 1.0 - _ramp(told.fast, LASTING)
    slow = min(1.0 - _ramp(ratio, SLOW), calm)
    rough = (1.0 - _ramp(_irregularity2(told), TONE)) * (1.0 - calm)
    lost = _ramp(1.0 - left, (0.0, 1.0 - LEAKING))
    comfort = COMFORT[0] + (COMFORT[1] - COMFORT[0]) * lost
    resonance = calm - slow
    return Shares(
        slow, (1.0 - comfort) * resonance, comfort * resonance + rough * (1.0 - lost), rough * lost
    )


def _irregularity2(told: Told) -> float:
    """Square of the deflection's irregularity, where it rests about any mean; 1 at rest."""
    spread = (told.x2 - told.x**2) * told.b2
    return told.w2**2 / spread if spread > 0.0 else 1.0


def _ratio(p: StateLaw, a2: float, v2: float) -> float:
    """Frequency of the body's motion over its own; the least acceleration that counts keeps it finite."""
    omega = 2.0 * math.pi * p.frequency
    floor = (0.1 * QUIET * p.swing / omega) ** 2
    return math.sqrt(a2 / (v2 + floor)) / omega


def _ramp(value: float, edges: tuple[float, float]) -> float:
    """From 0 at the first edge to 1 at the second."""
    return min(max((value - edges[0]) / (edges[1] - edges[0]), 0.0), 1.0)
