"""What moves the device and drives its field: curves on the fine grid, from rest or from the middle of a motion."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from math import pi

import numpy as np
from scipy.fft import irfft, next_fast_len

from test.rough.device import Array
from test.rough.rig import DRIVEN, TOP, Rig

WITHIN = 0.95
"""Share of what others reach that a drive within them reaches at most."""
LEAD = 2.0
"""Seconds simulated before a record begins."""
Random = np.random.Generator


@dataclass(frozen=True)
class Drive:
    """Inputs on the fine grid, lead included: deflection [m], velocity, acceleration, duty (n,); and their kinds."""

    x: Array
    v: Array
    a: Array
    u: Array
    lead: int
    motion: str
    duty: str
    rest: bool


def rise(s: Array) -> Array:
    """A smooth step from 0 to 1 over 0 to 1 (two derivatives vanish at its ends)."""
    s = np.clip(s, 0.0, 1.0)
    return np.asarray(s**3 * (10.0 - 15.0 * s + 6.0 * s * s))


def shaped(n: int, h: float, rng: Random, shape: Callable[[Array], Array]) -> Array:
    """Noise (n,) whose spectrum of amplitudes over the frequency [Hz] is given."""
    m = next_fast_len(n + round(4.0 / h), real=True)
    f = np.fft.rfftfreq(m, h)
    used = f[: np.searchsorted(f, 60.0) + 1]
    half = np.zeros(f.size, dtype=complex)
    draws = rng.standard_normal((2, used.size))
    half[: used.size] = shape(used) * (draws[0] + 1j * draws[1])
    return np.asarray(irfft(half, m)[:n])


def band(f: Array, low: float, high: float) -> Array:
    """A band with soft edges [1]."""
    with np.errstate(divide="ignore", over="ignore"):
        return np.asarray(1.0 / (1.0 + (low / np.maximum(f, 1e-9)) ** 6) / (1.0 + (f / high) ** 8))


def noise(t: Array, f0: float, rng: Random) -> Array:
    """Band-limited random stroke."""
    h = t[1] - t[0]
    return shaped(t.size, h, rng, lambda f: band(f, 0.25 * f0, 0.55 * TOP * f0) / (f + 0.3 * f0))


def handling(t: Array, f0: float, rng: Random) -> Array:
    """A rough road through a body that resonates at f0, and the roll of some bends."""
    h = t[1] - t[0]
    y = shaped(
        t.size,
        h,
        rng,
        lambda f: (
            band(f, 0.2 * f0, 0.5 * TOP * f0)
            / (f + 0.1)
            / np.hypot(1.0 - (f / f0) ** 2, 0.6 * f / f0)
        ),
    )
    y /= np.abs(y).max()
    for at in rng.uniform(t[0], t[-1], 4):
        y += rng.uniform(-0.7, 0.7) * (
            rise((t - at) * f0) - rise((t - at) * f0 - rng.uniform(2.0, 5.0))
        )
    return y


def earthquake(t: Array, f0: float, rng: Random) -> Array:
    """Two or three strong motions (Kanai-Tajimi ground), each with its envelope, and nearly nothing between them."""
    h, ground, loss = t[1] - t[0], f0, 0.5

    def kanai(f: Array) -> Array:
        r = f / ground
        return (
            band(f, 0.4 * f0, 0.5 * TOP * f0)
            * np.sqrt((1.0 + (2 * loss * r) ** 2) / ((1.0 - r * r) ** 2 + (2 * loss * r) ** 2))
            / (f + 0.2 * f0)
        )

    y, out = shaped(t.size, h, rng, kanai), np.zeros(t.size)
    span = t[-1] - max(t[0], 0.0)
    count = int(rng.integers(2, 4))
    for k in range(count):
        s = (t - span * (k + 0.1) / count) / (0.75 * span / count)
        out += rng.uniform(0.6, 1.0) * y * rise(5.0 * s) * (1.0 - rise(2.0 * s - 1.0))
    return out


def sweep(t: Array, f0: float, rng: Random) -> Array:
    """Rising or falling tone: constant stroke below f0, constant velocity above."""
    low, high, span = 0.25 * f0, 0.8 * TOP * f0, t[-1] - t[0]
    s = (t - t[0]) / span if rng.random() < 0.7 else (t[-1] - t) / span
    f = low * (high / low) ** s
    phase = 2.0 * pi * np.cumsum(f) * (t[1] - t[0])
    return np.asarray(np.sin(phase) / np.sqrt(1.0 + (f / f0) ** 2))


def sines(t: Array, f0: float, rng: Random) -> Array:
    """What a test machine runs: one frequency after another, each with its own stroke."""
    count = 5
    f = f0 * rng.permutation(np.geomspace(0.3, 0.7 * TOP, count))
    size = rng.uniform(0.4, 1.0, count) / np.sqrt(1.0 + (f / f0) ** 2)
    s = (t - t[0]) / (t[-1] - t[0]) * count
    f_t, a_t = np.full(t.size, f[0]), np.full(t.size, size[0])
    for k in range(1, count):
        step = rise((s - k) * 4.0 + 0.5)
        f_t, a_t = f_t + (f[k] - f[k - 1]) * step, a_t + (size[k] - size[k - 1]) * step
    return np.asarray(a_t * np.sin(2.0 * pi * np.cumsum(f_t) * (t[1] - t[0])))


def moves(t: Array, f0: float, rng: Random) -> Array:
    """A positioning drive: from point to point, with halts between."""
    y, at, here = np.zeros(t.size), t[0] + 0.1, 0.0
    while at < t[-1]:
        there, time = rng.uniform(-1.0, 1.0), rng.uniform(0.25, 1.0) / f0
        y += (there - here) * rise((t - at) / time)
        at, here = at + time + rng.choice([0.05, 0.4]) * rng.uniform(0.5, 1.5) / f0, there
    return y


def tone(t: Array, f0: float, rng: Random) -> Array:
    """One sine."""
    return np.asarray(np.sin(2.0 * pi * f0 * rng.uniform(0.7, 1.2) * t))


def cycles(t: Array, f0: float, rng: Random) -> Array:
    """One closed curve, again and again."""
    w = 2.0 * pi * 0.7 * f0
    return np.asarray(
        np.sin(w * t) + rng.uniform(0.1, 0.3) * np.sin(2.0 * w * t + rng.uniform(0.0, 6.0))
    )


MOTIONS = {f.__name__: f for f in (noise, handling, earthquake, sweep, sines, moves)}
POOR = {f.__name__: f for f in (tone, cycles)}


def steps(
    t: Array, rng: Random, lowest: float, longest: float, levels: tuple[float, ...]
) -> Array:
    """Levels held for a drawn time each, of the largest duty."""
    u, at = np.zeros(t.size), t[0]
    while at < t[-1]:
        level = (
            float(rng.choice(levels))
            if levels
            else float(rng.uniform(0.0, 1.0)) * (rng.random() > 0.2)
        )
        u[t >= at] = level
        at += rng.uniform(lowest, longest)
    return u


def duty_of(kind: str, t: Array, rng: Random) -> Array:
    """Share of the largest duty (n,): steps, a random switch, a slow wander, or one level."""
    if kind == "steps":
        return steps(t, rng, 0.3, 2.0, ())
    if kind == "switched":
        return steps(t, rng, 0.08, 0.6, (0.0, 1.0))
    if kind == "wander":
        y = shaped(t.size, t[1] - t[0], rng, lambda f: band(f, 0.05, 0.8))
        return np.asarray(0.5 + 0.5 * y / np.abs(y).max())
    return np.full(t.size, rng.uniform(0.4, 0.9))


def sampled_first(u: Array, every: int, lead: int) -> Array:
    """The duty as it is recorded: what stands in a row holds until the next row."""
    index = np.arange(u.size)
    rows = lead + (index - lead) // every * every
    return np.asarray(u[np.maximum(rows, 0)])


def reach(name: str, drives: Sequence[Drive]) -> tuple[float, float]:
    """Smallest and largest value of a signal in the records of drives."""
    parts = [getattr(d, name)[d.lead :] for d in drives]
    return min(float(y.min()) for y in parts), max(float(y.max()) for y in parts)


def draw_drive(
    rig: Rig, rng: Random, motion: str, duty: str, *, rest: bool, within: Sequence[Drive] = ()
) -> Drive:
    """A drive of a kind, scaled to meet the rig's stroke or velocity, or to stay within other drives."""
    h, lead = 1.0 / rig.fine, round(LEAD * rig.rate) * rig.every
    t = (np.arange(lead + rig.n * rig.every) - lead) * h
    y = (MOTIONS | POOR)[motion](t, rig.frequency, rng)
    if rest:
        begins = rng.uniform(0.8, 1.6)
        gate = rise((t - begins) * max(rig.frequency, 1.0))
        y = (y - np.interp(begins, t, y)) * gate
    v = np.gradient(y, h)
    middle, scale = 0.0, min(rig.stroke / np.abs(y).max(), rig.velocity / np.abs(v).max())
    if within:
        (low, high), (back, forth) = (reach(name, within) for name in ("x", "v"))
        middle, y = 0.5 * (low + high), y - 0.5 * (y[lead:].min() + y[lead:].max())
        fits = (0.5 * (high - low) / y[lead:].max(), forth / v[lead:].max(), back / v[lead:].min())
        scale = min(scale, WITHIN * min(fits))
    u = np.zeros(t.size)
    if rig.device in DRIVEN:
        u = rig.duty * sampled_first(duty_of(duty, t, rng), rig.every, lead)
        u = np.round(u, 4)
    return Drive(
        middle + scale * y, scale * v, scale * np.gradient(v, h), u, lead, motion, duty, rest
    )
