r"""Kinematic fusion: deflection, velocity and both accelerometers into one consistent motion.

The state [x, v, a, j, b] (j: jerk, b: bias of the relative accelerometer) is driven by white snap (or,
without j, by white jerk: on rough roads the likelier model),

.. math:: x' = v, \quad v' = a, \quad a' = j, \quad j' = \text{white}(q_k), \quad b' = 0

and is measured by whatever channels there are: x, v and a + b. A velocity channel that lags by T_v > 0 is
one more state u, T_v u' + u = v; one that leads is v - T_v a. Between kinks the acceleration is smooth and
can be integrated far better than by a straight line; at a kink (a gate that closes, a friction that
reverses) the intensity q_k rises with the third difference of the data, so that nothing is smoothed away.
Noise levels, intensity and lag are those of `levels`; a Rauch-Tung-Striebel smoother gives motion and covariance.

Why: the gate of an electrorheological damper is 2 mm/s wide. Velocity noise of 1 mm/s makes wrong
effects look true; fused motion is five times cleaner.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
from er_models.model import Array
from numpy.typing import NDArray

from er_model_lab.filtering import fading
from er_model_lab.motion.chain import LAGGING, STATES, filtered, ramps, smoothed
from er_model_lab.motion.white_noise import white_noise

SHORTEST_LAG = 0.1
"""Lag of the velocity channel that deserves a state of its own, in samples; a straight line serves below."""
EDGE, LONG = 10, 20
"""Samples of an end of a record, and how many times as long it is at least for them to be left out."""
STANDSTILL = 0.02
"""Power of the velocity, as a share of its most, below which a part of a record tells nothing of its motion."""
MORE = 1.2
"""Power over that of the noise from which it is motion: the noise of a record is known to a few per cent."""

WITHOUT_A = np.array([1, 1, 0], np.uint8)
"""Channels in use where the accelerations are left out."""


@dataclass(frozen=True)
class Noise:
    """Noise levels of the motion sensors, and the model of the motion.

    Standard deviations of the channels (x [m], v [m/s], a [m/s2]), intensity of the noise that drives the
    chain, velocity lag [s], order of the chain: 4 (white snap, smooth roads) or 3 (white jerk, rough
    roads), and whether its intensity follows the local activity of the data.
    """

    x: float
    v: float
    a: float
    drive: float
    lag: float = 0.0
    lag_sd: float = float("inf")
    order: int = 4
    local: bool = True


@dataclass(frozen=True)
class Fused:
    """Motion (n,) with standard deviations, noise levels, accelerometer bias [m/s2] and channels used."""

    x: Array
    v: Array
    a: Array
    sd_x: float
    sd_v: float
    sd_a: float
    noise: Noise
    bias: float
    bias_sd: float
    channels: tuple[str, ...]


@dataclass(frozen=True)
class Channels:
    """Measurements (n, 3) with the channels there are, on a uniform grid; lost (n, 3): those that were none."""

    dt: float
    z: Array
    has: NDArray[np.uint8]
    activity: Array
    measured_a: bool
    lost: NDArray[np.bool_]

    @cached_property
    def spread(self) -> Array:
        """Variance (4,) of the unknown state at the first sample: the size of what was measured."""
        size = np.mean(self.z**2, axis=0) + 1e-12
        v2 = size[1] if self.has[1] else np.mean(np.diff(self.z[:, 0]) ** 2) / self.dt**2
        a2 = size[2] if self.has[2] else v2 / (10.0 * self.dt) ** 2
        x2 = size[0] if self.has[0] else v2
        return np.asarray(100.0 * np.array([x2, v2, a2, a2 / (5.0 * self.dt) ** 2]))

    @property
    def shows_lag(self) -> bool:
        """Whether deflection or accelerometers can show a lag of the velocity channel by themselves."""
        return bool(self.has[1] and (self.has[0] or self.has[2]))

    def only(self, has: NDArray[np.uint8]) -> Channels:
        """The same measurements with only some channels in use."""
        return replace(self, has=(self.has & has).astype(np.uint8))

    def telling(self, n: int) -> Channels:
        """The first n samples; where they hold hardly any of the motion, the n that hold most.

        What noise moves from sample to sample, at a high rate more than the motion does, is no motion; nor is a
        sample that is none.
        """
        if self.has[1]:
            y, gone, noise = self.z[:, 1], self.lost[:, 1], white_noise([self.z[:, 1]])
        else:
            x, lost = self.z[:, 0], self.lost[:, 0]
            y, gone = np.diff(x, append=x[-1:]), lost | np.append(lost[1:], lost[-1:])
            noise = np.sqrt(2.0) * white_noise([x])
        y = np.where(gone, np.median(y[~gone]) if not gone.all() else 0.0, y)
        begins = range(0, max(y.size - n, 0) + 1, max(n // 2, 1))
        power = np.array([np.var(y[i : i + n]) for i in begins])
        power = np.where(power < MORE * noise**2, 0.0, power - noise**2)
        i = 0 if power[0] >= STANDSTILL * power.max() else begins[int(np.argmax(power))]
        return self._between(i, i + n)

    def inside(self) -> Channels:
        """The same without its ends, where a filter may have bent all channels: what shows in one only is no lag."""
        few = EDGE if len(self.z) > LONG * EDGE else 0
        return self._between(few, len(self.z) - few)

    def _between(self, i: int, j: int) -> Channels:
        """Samples i to j."""
        rows = slice(i, j)
        return replace(self, z=self.z[rows], activity=self.activity[rows], lost=self.lost[rows])


def _run(
    ch: Channels, noise: Noise, spread: Array | None = None, *, keep: bool = True
) -> tuple[float, Array, Array, Array, Array]:
    """Filter pass: log likelihood and the arrays the smoother needs, which hold nothing unless they are kept."""
    n, m = ch.z.shape[0], LAGGING if noise.lag > SHORTEST_LAG * ch.dt else STATES
    rows = np.zeros((3, m))
    rows[0, 0] = rows[2, 2] = rows[2, 4] = 1.0
    if m == LAGGING:
        rows[1, 5] = 1.0
    else:
        rows[1, 1], rows[1, 2] = 1.0, -noise.lag
    kept, seen = n if keep else 0, (ch.has * ~ch.lost).astype(np.uint8)
    xs, xp = np.empty((kept, m)), np.empty((kept, m))
    ps, pp = np.empty((kept, m, m)), np.empty((kept, m, m))
    chain = ch.spread if spread is None else spread
    first = np.zeros(m)
    first[: noise.order] = chain[: noise.order]
    first[4] = (10.0 * noise.a) ** 2 if ch.has[2] else 1e-18
    first[5:] = chain[1]
    value = filtered(
        ch.dt, noise.order, noise.lag, ch.z, seen, rows, np.array([noise.x, noise.v, noise.a]) ** 2,
        noise.drive, ch.activity if noise.local else np.ones(n), tuple(first.tolist()), xs, ps, xp, pp,
    )  # fmt: skip
    return float(value), xs, ps, xp, pp


def likelihood(ch: Channels, noise: Noise) -> float:
    """Logarithm of the likelihood of the measurements."""
    return _run(ch, noise, keep=False)[0]


def channels_of(
    dt: float, x: Array | None, v: Array | None, a: Array | None, lost: NDArray[np.bool_] | None = None
) -> Channels:  # fmt: skip
    """Pack the channels there are; at least deflection or velocity is needed. lost (n, 3): samples that were none."""
    n = next(c.shape[0] for c in (x, v, a) if c is not None)
    z = np.zeros((n, 3))
    has = np.zeros(3, np.uint8)
    gone = np.zeros((n, 3), bool) if lost is None else lost
    for c, channel in enumerate((x, v, a)):
        if channel is not None:
            z[:, c] = channel
            has[c] = 1
    return Channels(dt, z, has, _activity(a) if a is not None else np.ones(n), a is not None, gone)


def _activity(a: Array) -> Array:
    """Relative local snap intensity (n,), from the third difference of the acceleration less its noise."""
    third = np.diff(a, 3) ** 2
    noise = float(np.quantile(third, 0.25)) / 0.1015
    local = np.zeros(a.shape[0])
    local[2 : 2 + third.size] = np.convolve(third, np.ones(4) / 4.0, "same")
    local = np.maximum(local - noise, 0.005 * max(float(local.mean()), 1e-30))
    return np.asarray(local / local.mean())


def fuse(ch: Channels, noise: Noise, spread: Array | None = None) -> Fused:
    """Smoothed motion of one record; spread: variance (4,) of the state at the first sample, else from the data."""
    _, xs, ps, xp, pp = _run(ch, noise, spread)
    smoothed(ch.dt, noise.order, noise.lag, tuple(xs[0].tolist()), xs, ps, xp, pp)
    names = tuple(
        n
        for n, h in zip(("deflection", "deflection_velocity", "acceleration"), ch.has, strict=True)
        if h
    )
    sd = np.sqrt(np.maximum(ps.diagonal(axis1=1, axis2=2), 0.0).mean(axis=0))
    return Fused(
        x=np.ascontiguousarray(xs[:, 0]), v=np.ascontiguousarray(xs[:, 1]), a=np.ascontiguousarray(xs[:, 2]),
        sd_x=float(sd[0]), sd_v=float(sd[1]), sd_a=float(sd[2]), noise=noise,
        bias=float(xs[-1, 4]), bias_sd=float(np.sqrt(max(ps[-1, 4, 4], 0.0))), channels=names,
    )  # fmt: skip


def as_measured(fused: Fused, dt: float) -> Array:
    """What the channels would show of a fused motion without noise: x, lagging v, a, (n, 3)."""
    lag = fused.noise.lag
    if lag <= SHORTEST_LAG * dt:
        return np.stack([fused.x, fused.v - lag * fused.a, fused.a], axis=1)
    to = np.zeros(3)
    left = ramps(dt, lag, to)
    jerk = np.diff(fused.a) / dt
    steps = to[0] * fused.v[:-1] + to[1] * fused.a[:-1] + to[2] * jerk
    start = fused.v[0] - lag * fused.a[0]
    behind = fading(np.concatenate([[start], steps]), left)
    return np.stack([fused.x, behind, fused.a], axis=1)
