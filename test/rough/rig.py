"""The rig of a case: device, size, sampling, channels and instruments, all drawn; base values from the size."""

from __future__ import annotations

from dataclasses import dataclass
from math import ceil, log, pi

import numpy as np

from test.rough.device import BASE, Array

DEVICES = ("passive", "er", "mr", "brake", "pneumatic")
DRIVEN = ("er", "mr", "pneumatic")
FORCES, STROKES = (20.0, 50e3), (5e-3, 0.2)
"""Peak force [N], and the whole stroke [m]."""
RATES = (100.0, 200.0, 250.0, 500.0, 1000.0, 2000.0, 5000.0, 10000.0)
OFTEN = (0.2, 0.26, 0.16, 0.16, 0.12, 0.04, 0.03, 0.03)
TOP = 3.0
"""Highest frequency of a motion over its typical one."""
SAMPLES, SHORTEST, LONGEST = 8000.0, 15.0, 30.0
"""Samples of all records together that a case has about; length of a record [s]."""
FINEST = 8000.0
"""Least rate of the simulation [Hz]."""
CHANNELS = {
    "full": ("deflection", "deflection_velocity", "sprung_acceleration", "unsprung_acceleration"),
    "no_accelerations": ("deflection", "deflection_velocity"),
    "deflection_only": ("deflection",),
    "encoder": ("deflection",),
}
_SHARE = (0.35, 0.25, 0.22, 0.18)


def log_uniform(rng: np.random.Generator, low: float, high: float) -> float:
    """A number whose logarithm is evenly spread."""
    return float(np.exp(rng.uniform(log(low), log(high))))


@dataclass(frozen=True)
class Rig:
    """One device on one bench.

    Attributes:
        device: one of `DEVICES`.
        force, stroke, velocity, duty: peak values [N], [m] (half the stroke), [m/s], [1].
        rate, fine: sampling and simulation [Hz]; fine is a multiple.
        seconds, records: length of each record [s], and how many.
        base: `BASE` (10,).
        sensors: a key of `CHANNELS`; noise: of force [N], deflection [m], velocity [m/s], acceleration [m/s2] (4,).
        count: step of the encoder [m], 0 without.
    """

    device: str
    force: float
    stroke: float
    velocity: float
    duty: float
    rate: float
    fine: float
    seconds: float
    records: int
    base: Array
    sensors: str
    noise: Array
    count: float

    @property
    def frequency(self) -> float:
        """Typical frequency of the motion [Hz]."""
        return self.velocity / (2.0 * pi * self.stroke)

    @property
    def every(self) -> int:
        """Fine steps in a sample."""
        return round(self.fine / self.rate)

    @property
    def n(self) -> int:
        """Samples of a record."""
        return round(self.seconds * self.rate)


def draw_base(
    device: str,
    force: float,
    stroke: float,
    velocity: float,
    duty: float,
    rng: np.random.Generator,
) -> Array:
    """Values of `BASE` (10,) [SI] that share the peak force among spring, fluid, field and friction."""
    spring, fluid, field = rng.uniform(0.08, 0.25), rng.uniform(0.25, 0.5), rng.uniform(0.3, 0.6)
    steep = log_uniform(rng, 12.0, 45.0) / velocity
    driven, brake = device in DRIVEN, device == "brake"
    if not driven:
        field = 0.0
    base = dict.fromkeys(BASE, 0.0) | {
        "k0": spring * force / stroke, "c0": (0.15 if brake else fluid) * force / velocity,
        "f_c": field * force / duty, "k1": rng.uniform(-0.5, 1.0) / stroke, "c1": steep,
        "tau": log_uniform(rng, 0.006, 0.05) if driven else 0.0, "beta": 1.0, "u_m": duty,
        "F_c": rng.uniform(0.3, 0.6) * force if brake else 0.0,
        "v_0": rng.uniform(0.01, 0.04) * velocity,
    }  # fmt: skip
    if device == "mr":
        base |= {"k1": 0.0, "beta": rng.uniform(0.7, 1.4)}
    return np.array([base[name] for name in BASE])


def draw_rig(
    device: str,
    rng: np.random.Generator,
    *,
    force: float = 0.0,
    rate: float = 0.0,
    sensors: str = "",
) -> Rig:
    """A rig of any size; force, rate and sensors where they are asked for."""
    force = force or log_uniform(rng, *FORCES)
    stroke = 0.5 * log_uniform(rng, *STROKES)
    low, high = max(0.02, 2.0 * pi * 0.6 * stroke), min(2.0, 2.0 * pi * 6.0 * stroke)
    velocity = log_uniform(rng, min(low, high), max(low, high))
    duty = {"er": 0.3, "mr": float(rng.choice([0.5, 1.0]))}.get(device, 1.0)
    least = 12.0 * TOP * velocity / (2.0 * pi * stroke)
    odds = np.where(np.array(RATES) >= least, OFTEN, 0.0)
    rate = max(
        rate or float(rng.choice(RATES, p=odds / odds.sum())), next(r for r in RATES if r >= least)
    )
    records = 1 if rate >= 500.0 else int(rng.integers(1, 4))
    seconds = round(float(np.clip(SAMPLES / rate / records, SHORTEST, LONGEST)))
    sensors = sensors or str(rng.choice(list(CHANNELS), p=_SHARE))
    count = 2.0 * stroke / log_uniform(rng, 2000.0, 16000.0) if sensors == "encoder" else 0.0
    noise = [
        force * log_uniform(rng, 1e-3, 1e-2), 0.0 if count else stroke * log_uniform(rng, 5e-5, 5e-4),
        velocity * log_uniform(rng, 1e-3, 6e-3), velocity**2 / stroke * log_uniform(rng, 2e-3, 1e-2),
    ]  # fmt: skip
    return Rig(
        device, force, stroke, velocity, duty, rate, rate * ceil(FINEST / rate), seconds, records,
        draw_base(device, force, stroke, velocity, duty, rng), sensors, np.array(noise), count,
    )  # fmt: skip
