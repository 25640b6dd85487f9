"""What the sensors of the rig read when the model holds sensing effects.

In the lab such an effect maps the measured motion to the true one before the damper sees it. In
simulation it is the other way round: the damper lives in the true motion and the channel is spoilt.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from er_models.errors import InputError
from er_models.model import Array, Model

SPOILT = ("deflection_zero", "velocity_lag", "force_delay")
"""Sensing effects that act on channels; a lag of the force is a state of the damper model itself."""
DEPTH = 16
"""Forces remembered for the delay of their channel, in samples."""


@dataclass(frozen=True)
class Channels:
    """Zero of the deflection sensor x_0 [m], lag of the velocity [s], delay of the force [s]."""

    zero: float
    lag: float
    delay: float
    dt: float


class Memory(NamedTuple):
    """Velocity before and after its lag [m/s], and the last forces [N], the newest last."""

    velocity: float
    lagged: float
    forces: Array


def split(model: Model, dt: float) -> tuple[Model, Channels]:
    """The physical model, and what its sensing effects do to the channels.

    Raises:
        InputError: A force channel that is early, or later than the memory holds: it cannot be simulated.
    """
    delay = _value(model, "force_delay", "d")
    if not 0.0 <= delay <= (DEPTH - 2) * dt:
        raise InputError(
            model.name, "force_delay.d", f"0 to {(DEPTH - 2) * dt:.3g} s in a simulation", delay
        )
    physical = model
    for name in SPOILT:
        if name in model.effects:
            physical = physical.without_effect(name)
    channels = Channels(
        _value(model, "deflection_zero", "x_0"), _value(model, "velocity_lag", "T_v"), delay, dt
    )
    return physical, channels


def _value(model: Model, effect: str, parameter: str) -> float:
    """A parameter, zero when the effect is absent."""
    return model.value(effect, parameter) if effect in model.effects else 0.0


def start(velocity: float, force: float) -> Memory:
    """Memory of a sensor that has seen the same values for long."""
    return Memory(velocity, velocity, np.full(DEPTH, force))


def read(
    p: Channels, memory: Memory, true: tuple[float, float, float]
) -> tuple[Memory, tuple[float, float, float]]:
    """Measured (deflection [m], velocity [m/s], force [N]) of true ones, one sample later.

    The lag is exact for a velocity that is straight between samples.
    """
    x, v, force = true
    lagged = v
    if p.lag > 0.0:
        decay = np.exp(-p.dt / p.lag)
        slope = (v - memory.velocity) / p.dt
        lagged = float(
            v - p.lag * slope + (memory.lagged - memory.velocity + p.lag * slope) * decay
        )
    forces = np.append(memory.forces[1:], force)
    s = DEPTH - 1 - p.delay / p.dt
    i = min(int(s), DEPTH - 2)
    late = float(forces[i] + (s - i) * (forces[i + 1] - forces[i])) if p.delay > 0.0 else force
    return Memory(v, lagged, forces), (x - p.zero, lagged, late)


def read_all(p: Channels, x: Array, v: Array, force: Array) -> tuple[Array, Array, Array]:
    """Measured deflection, velocity and force (n,) of a whole record."""
    memory, out = start(float(v[0]), float(force[0])), np.empty((3, x.shape[0]))
    out[:, 0] = x[0] - p.zero, v[0], force[0]
    for k in range(1, x.shape[0]):
        memory, out[:, k] = read(p, memory, (float(x[k]), float(v[k]), float(force[k])))
    return out[0], out[1], out[2]
