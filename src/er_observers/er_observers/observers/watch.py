r"""Watches an observer's state: how fast errors decay, whether sensors contradict the model.

*Decay.* Accelerometers see the deflection only through the force it makes. When the sprung
acceleration is explained, an error of the deflection decays with the rate of the zero dynamics,
here with the yield force in equilibrium with its gate of slope s:

.. math::  r = \frac{C_{1x} + s \rho\, k}{C_{1v} + s \rho\, c}

For (2.5) that is (k_s + k_0 + s f_c u k_1) / (c_0 + s f_c u c_1): 25.7 1/s without field, 0.53 1/s
at duty 1 before yield, whatever the gain.

*Contradiction.* The deflection velocity must change by what the two accelerometers integrate to;
what the observer adds is what model and sensors disagree about. Noise and the straight line
between samples explain some of it.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from er_models.linear import LinearForm
from er_models.model import Array

from er_observers.forms import SENSORS
from er_observers.observers.compiled import compiled
from er_observers.observers.status import (
    BLIND,
    CONFLICTING,
    FINE,
    GONE,
    REPAIRED,
    ROUNDING,
    UNSETTLED,
    Limits,
)

SHARE = 4.0
"""Correction, in multiples of what noise and sampling explain, that is a contradiction."""

DOUBT, DECAY, LOST, HEALING, POWER, FLOOR, WEAK, CONTRADICTED = range(8)
"""Places of `status.Health` in its array."""
SIZE = CONTRADICTED + 1
(
    STIFFNESS, DAMPING, GATE_STIFFNESS, GATE_DAMPING, PACE, NOISE_GAIN,
    HOLD, BRIDGE, RECOVER, WINDOW, SETTLED, WEAK_RATE, STRONG_RATE, NOISE, CLEAR,
    SPRUNG, UNSPRUNG, DEFLECTION,
) = range(18)  # fmt: skip
"""Places in the rules (18,): numbers of `Watch`, of `status.Limits`, and the largest accelerations [m/s2] and
deflection [m] that are believed."""
RULES = DEFLECTION + 1


class Watch(NamedTuple):
    """Constants of the watch.

    stiffness, damping: entries of the sprung acceleration's row; gate_stiffness, gate_damping:
    what an open gate at duty 1 adds to them; pace: fastest decay of the observer [1/s];
    noise_gain: from accelerometer noise to the correction [s].
    """

    stiffness: float
    damping: float
    gate_stiffness: float
    gate_damping: float
    pace: float
    noise_gain: float


def watch_of(form: LinearForm, poles: Array) -> Watch:
    """Constants from the linear form in relative coordinates and the poles of the observer [1/s].

    Where the deflection is measured its error decays as fast as the observer, whatever the gate. So it does without
    any damping, where the sprung acceleration tells it at once; noise then moves the velocity at the observer's pace.
    """
    at = int(np.argmax(np.abs(form.B)))
    through = -form.C[0, at] * form.B[at] / form.A[at, at]
    pace = float(-np.max(poles.real))
    told = abs(float(form.C[0, 1])) or abs(float(form.C[0, 0])) / pace
    return Watch(
        stiffness=float(form.C[0, 0]) if form.C.shape[0] < len(SENSORS) else -math.inf,
        damping=float(form.C[0, 1]),
        gate_stiffness=float(through * form.Gamma[0]),
        gate_damping=float(through * form.Gamma[1]),
        pace=pace,
        noise_gain=math.sqrt(2.0) / told,
    )


def rules_of(watch: Watch, limits: Limits) -> Array:
    """Watch and limits as the compiled functions take them (18,)."""
    rules = np.full(RULES, math.nan)
    rules[STIFFNESS], rules[DAMPING] = watch.stiffness, watch.damping
    rules[GATE_STIFFNESS], rules[GATE_DAMPING] = watch.gate_stiffness, watch.gate_damping
    rules[PACE], rules[NOISE_GAIN] = watch.pace, watch.noise_gain
    rules[HOLD], rules[BRIDGE], rules[RECOVER] = limits.hold, limits.bridge, limits.recover
    rules[WINDOW], rules[SETTLED] = limits.window, limits.settled
    rules[WEAK_RATE], rules[STRONG_RATE] = limits.weak, limits.strong
    rules[NOISE], rules[CLEAR] = limits.noise, limits.clear
    rules[SPRUNG], rules[UNSPRUNG] = limits.acceleration
    rules[DEFLECTION] = limits.deflection
    return rules


@compiled
def follows(
    rules: Array, lost: float, dt: float, sprung: float, unsprung: float, deflection: float, m: int
) -> bool:
    """Whether a sample of m outputs simply goes on from the one dt [s] before; comparisons with NaN are false."""
    hold = rules[HOLD] + ROUNDING
    believed = abs(sprung) <= rules[SPRUNG] and abs(unsprung) <= rules[UNSPRUNG]
    if m > 2 and not abs(deflection) <= rules[DEFLECTION]:
        return False
    return bool(0.0 < dt <= hold and believed and lost + dt <= hold)


@compiled
def decay_rate(rules: Array, rho: float, slope: float) -> float:
    """Rate at which an error of the deflection decays [1/s], for the gate's slope (0 to 1); at most the observer's."""
    share = rho * slope
    stiffness = rules[STIFFNESS] + share * rules[GATE_STIFFNESS]
    damping = rules[DAMPING] + share * rules[GATE_DAMPING]
    if damping == 0.0:
        return float(rules[PACE])
    return float(min(stiffness / damping, rules[PACE]))


def begin(rules: Array) -> Array:
    """Health (8,) at the first valid sample."""
    health = np.zeros(SIZE)
    health[DOUBT], health[DECAY] = 1.0, rules[PACE]
    return health


@compiled
def missed(rules: Array, health: Array, dt: float) -> None:
    """Health (8,), in place, after a sample that could not be used, dt [s] after the one before."""
    bridge, recover = rules[BRIDGE], rules[RECOVER]
    health[LOST] += dt
    if health[LOST] > bridge + ROUNDING:
        health[HEALING] = recover


@compiled
def follow(
    rules: Array, health: Array, dt: float, rate: float, correction: float, bend: float,
    repaired: bool,
) -> None:  # fmt: skip
    """Health (8,), in place, after a valid sample, dt [s] after the one before.

    rate: of `decay_rate` [1/s]; correction: velocity the observer added [m/s]; bend: second
    difference of the relative acceleration [m/s2], whose twelfth times dt is the error of a
    straight line between samples; repaired: whether the duty had to be.
    """
    recover, clear = rules[RECOVER], rules[CLEAR]
    weight = min(1.0, dt / rules[WINDOW])
    health[DECAY] += weight * (rate - health[DECAY])
    _powers(rules, health, dt, correction, bend)
    ratio = contradiction(health[POWER], health[FLOOR])
    health[DOUBT] *= math.exp(-rate * dt)
    health[LOST] = 0.0
    health[HEALING] = recover if repaired else max(0.0, health[HEALING] - dt)
    health[WEAK] = health[DECAY] < rules[STRONG_RATE if health[WEAK] > 0.0 else WEAK_RATE]
    health[CONTRADICTED] = ratio > (clear if health[CONTRADICTED] > 0.0 else 1.0)


@compiled
def _powers(rules: Array, health: Array, dt: float, correction: float, bend: float) -> None:
    """Averages of the squared correction and of what explains it [m2/s2], in place.

    They start with the noise that is allowed and rest while an error of the start or of a repair is
    still being corrected.
    """
    allowed = (rules[NOISE_GAIN] * rules[NOISE]) ** 2
    if health[DOUBT] > rules[SETTLED]:
        health[POWER], health[FLOOR] = 0.0, allowed
    elif not (health[LOST] > 0.0 or health[HEALING] > 0.0):
        weight = min(1.0, dt / rules[WINDOW])
        explained = allowed + (dt * bend / 12.0) ** 2
        health[POWER] += weight * (correction * correction - health[POWER])
        health[FLOOR] += weight * (explained - health[FLOOR])


@compiled
def contradiction(power: float, floor: float) -> float:
    """Correction over its gate; above one the accelerations contradict the model."""
    return math.sqrt(power / floor) / SHARE if floor > 0.0 else 0.0


@compiled
def judge(rules: Array, health: Array) -> int:
    """Which of `status.VERDICTS` the health says, worst first."""
    if health[LOST] > rules[HOLD] + ROUNDING:
        return GONE
    if health[DOUBT] > rules[SETTLED]:
        return BLIND if health[WEAK] > 0.0 else UNSETTLED
    if health[LOST] > rules[BRIDGE] + ROUNDING or health[HEALING] > 0.0:
        return REPAIRED
    if health[CONTRADICTED] > 0.0:
        return CONFLICTING
    return BLIND if health[WEAK] > 0.0 else FINE
