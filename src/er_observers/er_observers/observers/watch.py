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

from er_observers.observers.status import ROUNDING, Health, Limits

SHARE = 4.0
"""Correction, in multiples of what noise and sampling explain, that is a contradiction."""


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


class Facts(NamedTuple):
    """What one valid sample tells.

    rate: of `decay_rate` [1/s]; correction: velocity the observer added [m/s]; bend: second
    difference of the relative acceleration [m/s2], whose twelfth times dt is the error of a
    straight line between samples; repaired: whether the duty had to be.
    """

    rate: float
    correction: float
    bend: float
    repaired: bool


def watch_of(form: LinearForm, poles: Array) -> Watch:
    """Constants from the linear form in relative coordinates and the poles of A - L C [1/s]."""
    at = int(np.argmax(np.abs(form.B)))
    through = -form.C[0, at] * form.B[at] / form.A[at, at]
    return Watch(
        stiffness=float(form.C[0, 0]),
        damping=float(form.C[0, 1]),
        gate_stiffness=float(through * form.Gamma[0]),
        gate_damping=float(through * form.Gamma[1]),
        pace=float(-np.max(poles.real)),
        noise_gain=math.sqrt(2.0) / abs(float(form.C[0, 1])),
    )


def decay_rate(watch: Watch, rho: float, slope: float) -> float:
    """Rate at which an error of the deflection decays [1/s], for the gate's slope (0 to 1)."""
    share = rho * slope
    stiffness = watch.stiffness + share * watch.gate_stiffness
    return min(stiffness / (watch.damping + share * watch.gate_damping), watch.pace)


def begin(watch: Watch) -> Health:
    """Health at the first valid sample."""
    return Health(1.0, watch.pace, 0.0, 0.0, 0.0, 0.0, weak=False, contradicted=False)


def missed(limits: Limits, health: Health, dt: float) -> Health:
    """Health after a sample that could not be used, dt [s] after the one before."""
    lost = health.lost + dt
    return health._replace(
        lost=lost, healing=limits.recover if lost > limits.bridge + ROUNDING else health.healing
    )


def follow(watch: Watch, limits: Limits, health: Health, dt: float, facts: Facts) -> Health:
    """Health after a valid sample, dt [s] after the one before."""
    weight = min(1.0, dt / limits.window)
    decay = health.decay + weight * (facts.rate - health.decay)
    power, floor = _powers(watch, limits, health, dt, facts)
    ratio = contradiction(power, floor)
    return Health(
        doubt=health.doubt * math.exp(-facts.rate * dt),
        decay=decay,
        lost=0.0,
        healing=limits.recover if facts.repaired else max(0.0, health.healing - dt),
        power=power,
        floor=floor,
        weak=decay < (limits.strong if health.weak else limits.weak),
        contradicted=ratio > (limits.clear if health.contradicted else 1.0),
    )


def _powers(
    watch: Watch, limits: Limits, health: Health, dt: float, facts: Facts
) -> tuple[float, float]:
    """Averages of the squared correction and of what explains it [m2/s2].

    They start with the noise that is allowed and rest while an error of the start or of a repair is
    still being corrected.
    """
    noise = (watch.noise_gain * limits.noise) ** 2
    if health.doubt > limits.settled:
        return 0.0, noise
    if health.lost > 0.0 or health.healing > 0.0:
        return health.power, health.floor
    weight = min(1.0, dt / limits.window)
    explained = noise + (dt * facts.bend / 12.0) ** 2
    power = health.power + weight * (facts.correction * facts.correction - health.power)
    return power, health.floor + weight * (explained - health.floor)


def contradiction(power: float, floor: float) -> float:
    """Correction over its gate; above one the accelerations contradict the model."""
    return math.sqrt(power / floor) / SHARE if floor > 0.0 else 0.0
