r"""What a run is judged by: deflection, comfort, road holding, and whether the faulty domain was respected.

Comfort is the rms of the body's acceleration weighted with W_k of ISO 2631-1, whose analogue filter is applied over
frequency, so that no sampling bends it.

Source: ISO 2631-1:1997, annex A, Table A.1; dynamic tyre load k_t (z_us - z_r) about the load at rest.
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from er_models.forms.loss import Factors
from er_models.model import Array
from er_models.static_damper import StaticDamper

_F1, _F2, _F3, _Q4, _F5, _Q5, _F6, _Q6 = 0.4, 100.0, 12.5, 0.63, 2.37, 0.91, 3.35, 0.91
"""Corners [Hz] and resonances of W_k: band limits, acceleration to velocity, upward step."""


class Measures(NamedTuple):
    """Deflection, rms and peak [m]; weighted acceleration, rms [m/s2]; tyre load, rms [N]; violations, wishes [1].

    Shares of the samples, NaN for a controller that asks for no force: violations, at which the force given, the
    projection on the domain of the faults in use, lies outside the domain of the true ones by more than a tolerance;
    wishes, at which the force that the law asks for does. safe: share of samples in safe mode.
    """

    rms: float
    peak: float
    comfort: float
    tyre: float
    violations: float
    wishes: float
    safe: float


NAMES = ("rms", "peak", "comfort", "tyre")
"""Measures of which less is better."""


def w_k(hertz: Array) -> Array:
    """Magnitude of the weight W_k at frequencies (k,) [Hz]."""
    s = 2j * np.pi * np.asarray(hertz, float)
    w1, w2, w3, w5, w6 = (2.0 * np.pi * f for f in (_F1, _F2, _F3, _F5, _F6))
    high = s**2 / (s**2 + math.sqrt(2.0) * w1 * s + w1**2)
    low = 1.0 / (1.0 + math.sqrt(2.0) * s / w2 + (s / w2) ** 2)
    transition = (1.0 + s / w3) / (1.0 + s / (_Q4 * w3) + (s / w3) ** 2)
    up = (1.0 + s / (_Q5 * w5) + (s / w5) ** 2) / (1.0 + s / (_Q6 * w6) + (s / w6) ** 2)
    return np.abs(high * low * transition * up * (w5 / w6) ** 2)


def weighted(acceleration: Array, dt: float) -> Array:
    """Acceleration (n,) [m/s2] with its spectrum weighted by W_k."""
    n = acceleration.size
    spectrum = np.fft.rfft(acceleration) * w_k(np.asarray(np.fft.rfftfreq(n, dt)))
    return np.fft.irfft(spectrum, n)


def outside(
    record: dict[str, Array], which: str, damper: StaticDamper, duties: tuple[float, float], tolerance: float
) -> Array:  # fmt: skip
    """At each sample (n,), whether a force lies outside (6.14) of the true faults by more than a tolerance [N].

    which: the force `given`, or the force `wanted` by the law before its projection.

    The motion is the one that the controller meant the force for, since that is where it could know the domain.
    """
    found = np.zeros(record["t"].size, dtype=bool)
    x, v, force = (record[name] for name in ("meant_deflection", "meant_velocity", which))
    for left in np.unique(record["left"], axis=0):
        rows = (record["left"] == left).all(axis=1)
        domain = damper.domain(x[rows], v[rows], duties, Factors(*left.tolist()))
        beyond = np.maximum(domain.low - force[rows], force[rows] - domain.high)
        found[rows] = beyond > tolerance
    return found


def measure(
    record: dict[str, Array], window: tuple[float, float], k_t: float, damper: StaticDamper,
    duties: tuple[float, float], tolerance: float,
) -> Measures:  # fmt: skip
    """Measures of a run within a window [s]."""
    t = record["t"]
    rows = (t >= window[0] - 1e-9) & (t <= window[1] + 1e-9)
    x, felt = record["deflection"][rows], weighted(record["sprung_acceleration"], t[1] - t[0])
    asks = bool(np.isfinite(record["given"]).all())

    def share(which: str) -> float:
        beyond = outside(record, which, damper, duties, tolerance)
        return float(beyond[rows].mean()) if asks else math.nan

    return Measures(
        _rms(x), float(np.abs(x).max()), _rms(felt[rows]), k_t * _rms(record["tyre_deflection"][rows]),
        share("given"), share("wanted"), float(record["safe"][rows].mean()),
    )  # fmt: skip


def _rms(values: Array) -> float:
    """Root of the mean square."""
    return float(np.sqrt(np.mean(values**2)))
