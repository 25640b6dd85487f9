r"""Control of heave, roll and pitch by four semi-active dampers: a clipped linear-quadratic regulator.

The state of the car is read, not observed: deflections and their rates are measured, the body's velocities are leaky
integrals of its accelerations, a wheel's velocity is the body's above it less the deflection's, and a tyre's
deflection follows from the forces at its wheel. The regulator asks for a yield force in each damper, and the force
loop of the corner gives the duty that comes nearest to it: a damper cannot push.

Source: Karnopp, Crosby and Harwood 1974 (clipping); `synthesis.body_lqr` makes the gain.
"""

from __future__ import annotations

import math
from dataclasses import dataclass
from functools import cached_property
from typing import NamedTuple

import numpy as np
from er_models.car.body import Car
from er_models.model import Array
from er_models.static_damper import HEALTHY, static_damper

from er_ftc_controller.force_loop import ForceLoop, LoopState, Motion, ahead, duty_for, follow
from er_ftc_controller.skyhook import LARGEST, leaky


@dataclass(frozen=True, eq=False)
class BodyLaw:
    """Gain K (4, 15), the car, force loops of its corners; corner frequency [Hz] of the integrals, longest gap [s]."""

    gain: Array
    car: Car
    loops: tuple[ForceLoop, ...]
    corner_frequency: float
    gap: float = 0.05

    @cached_property
    def quarters(self) -> tuple[Array, Array, Array]:
        """Springs [N/m], tyres [N/m] and unsprung masses [kg] of the corners, (4,) each."""
        names = ("k_s", "k_t", "m_us")
        rows = ([m.value("quarter_car", name) for m in self.car.corners] for name in names)
        springs, tyres, wheels = (np.array(row) for row in rows)
        return springs, tyres, wheels


class BodySample(NamedTuple):
    """One tick: time [s]; deflections [m], their rates [m/s], accelerations of body and wheels [m/s2], (4,) each."""

    t: float
    x: Array
    v: Array
    sprung: Array
    unsprung: Array


class BodyState(NamedTuple):
    """Rates of heave, roll, pitch, (3,), their last accelerations, (3,), force loops, time of the last sample [s]."""

    rates: Array
    accelerations: Array
    loops: tuple[LoopState, ...]
    t: float = math.nan


def law_of(
    car: Car, gain: Array, duties: tuple[float, float], horizon: float, corner_frequency: float
) -> BodyLaw:
    """The law of a car: a force loop at each corner, duties (lowest, highest), forces to be reached in a horizon [s].

    Raises `InputError` where a damper has no static law, or the limits contradict.
    """
    loops = tuple(
        ForceLoop(
            static_damper(model),
            model.value("response", "tau") if "response" in model.effects else 0.0,
            duties,
            horizon=horizon,
        )
        for model in car.corners
    )
    return BodyLaw(gain, car, loops, corner_frequency)


def start() -> BodyState:
    """Before the first sample: at rest, no field."""
    return BodyState(np.zeros(3), np.zeros(3), (LoopState(),) * 4)


def usable(sample: BodySample) -> bool:
    """Whether all values are finite and believable."""
    accelerations = np.concatenate([sample.sprung, sample.unsprung / 10.0])
    believable = np.abs(accelerations).max() <= LARGEST[0] and np.abs(sample.v).max() <= LARGEST[1]
    return bool(believable and np.isfinite(sample.x).all() and math.isfinite(sample.t))


def step(p: BodyLaw, state: BodyState, sample: BodySample) -> tuple[BodyState, Array]:
    """Duties (4,) for a sample that is `usable`; after a gap the integrals start anew from zero."""
    h = sample.t - state.t
    accelerations = p.car.motions @ sample.sprung
    if 0.0 < h <= p.gap:
        rates = leaky(p.corner_frequency, h, state.rates, state.accelerations, accelerations)
    else:
        rates, h = np.zeros(3), 0.0
    loops = tuple(
        follow(loop, held, Motion(x, v), h, HEALTHY)
        for loop, held, x, v in zip(p.loops, state.loops, sample.x.tolist(), sample.v.tolist())
    )
    wanted = -p.gain @ read(p, sample, rates, np.array([each.force for each in loops]))
    made = []
    for i, (loop, held) in enumerate(zip(p.loops, loops)):
        rate = float(sample.sprung[i] - sample.unsprung[i])
        gate = float(
            loop.damper.gate(*ahead(float(sample.x[i]), float(sample.v[i]), rate, loop.horizon))
        )
        made.append(duty_for(loop, held, float(wanted[i]), gate, h, HEALTHY))
    return BodyState(rates, accelerations, tuple(m[0] for m in made), sample.t), np.array(
        [m[1] for m in made]
    )


def read(p: BodyLaw, sample: BodySample, rates: Array, yielding: Array) -> Array:
    """State (15,) of `linear_car` from what is measured; yielding: yield forces of the dampers, (4,) [N]."""
    wheels = p.car.shape @ rates - sample.v
    passive = np.array(
        [loop.damper.passive(x, v) for loop, x, v in zip(p.loops, sample.x, sample.v)]
    )
    twist = p.car.bars * (sample.x - sample.x[[1, 0, 3, 2]])
    springs, stiff, masses = p.quarters
    pressed = springs * sample.x + passive + yielding + twist
    tyres = (pressed - masses * sample.unsprung) / stiff
    return np.concatenate([sample.x, rates, tyres, wheels])
