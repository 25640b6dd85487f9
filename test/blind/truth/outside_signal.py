"""Disturbances of the force channel that no catalogue is expected to hold.

mains_hum          A sin(2 pi f t + phase), f near 50 Hz
random_walk_drift  a random walk of the zero, of rms A within a record
fixture_resonance  F + s (G - 1) F, G a lightly damped frame of frequency f and damping z
field_crosstalk    k times each duty step, decaying with T: the high voltage's edges in the cable
"""

from __future__ import annotations

import math

import numpy as np

from test.blind.effect import Effect, Scene
from test.blind.jit import Array, entry
from test.blind.slots import OF, OUT_CROSSTALK, OUT_DRIFT, OUT_HUM, OUT_RESONANCE


@entry
def frame(force: Array, step: float, frequency: float, damping: float) -> Array:
    """Response of the frame to a finely sampled force (n,) [N], semi-implicit Euler."""
    omega = 2.0 * math.pi * frequency
    out = force.copy()
    q, rate = force[0], 0.0
    for j in range(1, force.size):
        rate += step * (omega * omega * (force[j] - q) - 2.0 * damping * omega * rate)
        q += step * rate
        out[j] = q
    return out


def framed(shown: Array, step: float, share: float, frequency: float, damping: float) -> None:
    """The force beyond the frame [N]."""
    shown[:, OF] += share * (frame(shown[:, OF], step, frequency, damping) - shown[:, OF])


def hum(t: Array, row: Array) -> Array:
    """Mains in the force channel [N] at times t [s]."""
    return np.asarray(row[0] * np.sin(2.0 * np.pi * row[1] * t + row[2]))


def drift(n: int, rms: float, rng: np.random.Generator) -> Array:
    """Random walk of n samples with the rms [N] asked for, zero mean."""
    walk = np.cumsum(rng.standard_normal(n))
    walk -= walk.mean()
    return np.asarray(rms * walk / walk.std())


def crosstalk(duty: Array, step: float, row: Array) -> Array:
    """Decaying pulses [N] of the duty's steps, duty (n,) at sampling interval step [s]."""
    keep = math.exp(-step / row[1])
    out = np.zeros(duty.size)
    for j in range(1, duty.size):
        out[j] = keep * out[j - 1] + row[0] * (duty[j] - duty[j - 1])
    return out


def draw_hum(rng: np.random.Generator, scene: Scene) -> tuple[float, ...]:
    """Frequency [Hz] and phase [rad]."""
    del scene
    return rng.uniform(49.9, 50.1), rng.uniform(0.0, 2.0 * np.pi)


def draw_frame(rng: np.random.Generator, scene: Scene) -> tuple[float, ...]:
    """Frequency [Hz] and damping ratio of the frame."""
    del scene
    return rng.uniform(12.0, 35.0), rng.uniform(0.02, 0.06)


def draw_cable(rng: np.random.Generator, scene: Scene) -> tuple[float, ...]:
    """Decay [s] of a pulse."""
    del scene
    return (rng.uniform(0.015, 0.04),)


def draw_walk(rng: np.random.Generator, scene: Scene) -> tuple[float, ...]:
    """Seed of the walk, kept with the truth so that a calibration sees one and the same walk."""
    del scene
    return (float(rng.integers(2**31)),)


HUM = Effect(
    "outside:mains_hum",
    (("A", "N"), ("f", "Hz"), ("phase", "rad")),
    0.3,
    0.03,
    4.0,
    draw_hum,
    slot=OUT_HUM,
)
DRIFT = Effect(
    "outside:random_walk_drift",
    (("A", "N"), ("seed", "1")),
    0.2,
    0.03,
    4.0,
    draw_walk,
    slot=OUT_DRIFT,
)
RESONANCE = Effect(
    "outside:fixture_resonance",
    (("s", "1"), ("f", "Hz"), ("z", "1")),
    0.3,
    0.01,
    10.0,
    draw_frame,
    acts={"shown": framed},
    slot=OUT_RESONANCE,
)
CROSSTALK = Effect(
    "outside:field_crosstalk",
    (("k", "N"), ("T", "s")),
    4.0,
    0.3,
    80.0,
    draw_cable,
    slot=OUT_CROSSTALK,
)
