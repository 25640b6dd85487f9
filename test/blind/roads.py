"""Roads and imposed strokes, on the half steps of the integrator, and the duty program."""

from __future__ import annotations

import numpy as np
from scipy.interpolate import CubicSpline

from test.blind.integrate import LEAD_SAMPLES, SAMPLE, SUBSTEPS
from test.blind.jit import Array

_NODES_HZ = 500.0
_TAIL_SAMPLES = 8
_RAMP = 0.5


def n_samples(seconds: float) -> int:
    """Samples simulated: the lead, the record, and a tail for signals that run ahead."""
    return LEAD_SAMPLES + round(seconds / SAMPLE) + _TAIL_SAMPLES


def half_grid(n: int) -> Array:
    """Times of the half steps [s], (2 n SUBSTEPS + 1,), zero at the record's first sample."""
    count = 2 * n * SUBSTEPS + 1
    grid = np.arange(count, dtype=np.float64) * (SAMPLE / (2 * SUBSTEPS))
    return np.asarray(grid - LEAD_SAMPLES * SAMPLE, dtype=np.float64)


def _sines(
    t: Array, frequency: Array, amplitude: Array, phase: Array, derivative: int = 0
) -> Array:
    """Sum of sines, or of their derivatives, at times t."""
    omega = 2.0 * np.pi * frequency
    total = np.zeros_like(t)
    for w, a, p in zip(omega, amplitude, phase, strict=True):
        total += a * w**derivative * np.sin(w * t + p + derivative * np.pi / 2.0)
    return total


def _road_for_stroke(f: Array | float) -> Array:
    """Road over deflection of the linear car with mid damping at f [Hz], at most 14."""
    s = 2j * np.pi * np.asarray(f, dtype=float)
    m_s, m_u, k, k_t = 2.27, 0.25, 1660.0, 12270.0
    spring = k + 110.0 * s
    body = m_s * s * s + spring
    wheel = m_u * s * s + spring + k_t
    return np.minimum(np.abs((body * wheel - spring * spring) / (m_s * s * s * k_t)), 14.0)


def rough(t: Array, rng: np.random.Generator) -> Array:
    """Random road, rolling off like ISO 8608 above 2.5 Hz and shaped below for stroke."""
    edges = np.geomspace(0.8, 12.0, 61)
    f = rng.uniform(edges[:-1], edges[1:])
    size = np.sqrt(np.diff(edges)) / (1.0 + (f / 2.5) ** 2) ** rng.uniform(0.6, 0.9)
    road = _sines(t, f, size * _road_for_stroke(f), rng.uniform(0.0, 2 * np.pi, f.size))
    return np.asarray(road / road.std())


def sweep(t: Array, rng: np.random.Generator) -> Array:
    """Sine sweeps up and down, 1 to 9 Hz, sized for an even velocity of the stroke."""
    low, high = rng.uniform(1.0, 1.5), rng.uniform(6.0, 9.0)
    period = rng.uniform(9.0, 14.0)
    place = np.abs(((t + rng.uniform(0, period)) / period) % 2.0 - 1.0)
    f = low * (high / low) ** place
    phase = 2 * np.pi * np.cumsum(f) * (t[1] - t[0])
    return np.asarray(np.sin(phase) * _road_for_stroke(f) / (1.5 + f))


def bumps(t: Array, rng: np.random.Generator) -> Array:
    """Half-cosine bumps and holes of random length and height on a rough road."""
    road = 0.5 * rough(t, rng)
    at = t[0] + 0.3
    while at < t[-1]:
        length = rng.uniform(0.25, 0.7)
        inside = (t >= at) & (t < at + length)
        height = rng.choice([-1.0, 1.0]) * rng.uniform(0.8, 2.0) * (length / 0.4) ** 2
        road[inside] += height * (1.0 - np.cos(2 * np.pi * (t[inside] - at) / length))
        at += length + rng.uniform(0.1, 0.6)
    return road


def tones(t: Array, rng: np.random.Generator) -> Array:
    """Stretches of single sines, 1.3 to 5 Hz, faded into one another, of random stroke."""
    road = np.zeros_like(t)
    at = float(t[0]) - 1.0
    while at < t[-1]:
        length, f = rng.uniform(2.0, 4.0), rng.uniform(1.3, 5.0)
        weight = np.sin(np.pi * np.clip((t - at) / length, 0.0, 1.0)) ** 2
        stroke = rng.uniform(0.6, 1.0) / (1.0 + f)
        road += stroke * _road_for_stroke(f) * weight * np.sin(2 * np.pi * f * (t - at))
        at += 0.5 * length
    return road


KINDS = (rough, sweep, bumps, tones)


def road(n: int, kind: int, rng: np.random.Generator) -> Array:
    """One road of unit size at the half steps, (2 n SUBSTEPS + 1,), starting from rest."""
    t_end = n * SAMPLE - LEAD_SAMPLES * SAMPLE
    nodes = np.arange(-LEAD_SAMPLES * SAMPLE, t_end + 2.0 / _NODES_HZ, 1.0 / _NODES_HZ)
    shape = KINDS[kind % len(KINDS)](nodes, rng)
    ramp = np.clip((nodes - nodes[0]) / _RAMP, 0.0, 1.0)
    shape = (shape - shape.mean()) * 0.5 * (1.0 - np.cos(np.pi * ramp))
    return np.asarray(CubicSpline(nodes, shape)(half_grid(n)))


def one_sine(n: int, rng: np.random.Generator) -> Array:
    """A single sine of unit size with two derivatives, (2 n SUBSTEPS + 1, 3)."""
    f = np.array([rng.uniform(1.5, 4.0)])
    one, zero = np.ones(1), np.zeros(1)
    return np.stack([_sines(half_grid(n), f, one, zero, k) for k in range(3)], axis=1)


def imposed(n: int, kind: int, rng: np.random.Generator) -> Array:
    """Imposed stroke of unit size, its velocity and acceleration, (2 n SUBSTEPS + 1, 3)."""
    t = half_grid(n)
    if kind % 2 == 0:
        edges = np.geomspace(0.3, 8.0, 31)
        f = rng.uniform(edges[:-1], edges[1:])
        size, phase = np.sqrt(np.diff(edges)) / f**1.2, rng.uniform(0, 2 * np.pi, f.size)
        return np.stack([_sines(t, f, size, phase, k) for k in range(3)], axis=1)
    low, high, start = rng.uniform(0.3, 0.6), rng.uniform(4.0, 7.0), rng.uniform(0, 2 * np.pi)
    span = t[-1] - t[0]
    k = np.log(high / low) / span
    omega = 2 * np.pi * low * np.exp(k * (t - t[0]))
    phase = (omega - omega[0]) / k + start
    # Size falls as the inverse root of frequency: size' = -k size / 2, and omega' = k omega.
    size = np.sqrt(omega[0] / omega)
    x = size * np.sin(phase)
    v = size * (omega * np.cos(phase) - 0.5 * k * np.sin(phase))
    a = size * ((0.25 * k * k - omega * omega) * np.sin(phase))
    return np.stack([x, v, a], axis=1)


def duty(n: int, rng: np.random.Generator) -> Array:
    """Duty per sample, (n,): steps in 0..0.3 held 0.3 to 2 s, about a quarter of them at zero."""
    out = np.zeros(n)
    at = 0
    while at < n:
        hold = round(rng.uniform(0.3, 2.0) / SAMPLE)
        out[at : at + hold] = 0.0 if rng.random() < 0.25 else round(rng.uniform(0.01, 0.3), 3)
        at += hold
    return out


def bursts(n: int, rate: float, rng: np.random.Generator) -> Array:
    """Rare events per sample, (n,): one for 40 to 200 ms at a time, zero else."""
    out = np.zeros(n)
    at = rng.exponential(1.0 / rate)
    while at < n * SAMPLE:
        length = rng.uniform(0.04, 0.2)
        out[round(at / SAMPLE) : round((at + length) / SAMPLE) + 1] = 1.0
        at += length + rng.exponential(1.0 / rate)
    return out
