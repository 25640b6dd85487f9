"""How noisy the sensors of the motion are: noise levels, intensity and lag by maximum likelihood, from the data alone.

The search is that of Nelder and Mead, under each model that the motion may have; models that are far behind after the
first steps of it are given up.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from er_models.model import Array
from er_models.parallel import over_cores
from scipy.optimize import minimize, minimize_scalar

from er_model_lab.motion.fuse import Channels, Noise, likelihood
from er_model_lab.motion.white_noise import white_noise

FILTER = 1000
"""Steps of the integrator that take as long as one sample in the first steps of a search."""
FIRST, BEHIND = 25, 0.5
"""Steps of a search after which a model of the motion is given up that is so far behind another one, in the logarithm
of the likelihood of a sample. In 156 searches on 24 benches the likeliest in the end was never behind by then, and by
0.12 where accelerations wander far beyond the sampling; what a model gained afterwards was below 0.07 in 99 of 100."""


def _cost(ch: Channels, noise: Noise) -> float:
    """What a search for noise levels lowers: finite for whatever is tried."""
    value = likelihood(ch, noise)
    return -value if np.isfinite(value) else 1e30


def _start(ch: Channels, order: int) -> Noise:
    """Starting noise levels: the white noise of each channel by itself."""
    x, v, a = (max(white_noise([y]), 1e-9) for y in ch.z.T)
    level = 2 if ch.has[2] else (1 if ch.has[1] else 0)
    times = order - level
    drive = float(np.mean(np.diff(ch.z[:, level], times) ** 2) / ch.dt ** (2 * times - 1))
    return Noise(x, v, a, max(drive, 1e-9), order=order)


def _kinds(ch: Channels) -> list[tuple[int, bool]]:
    """Orders of the chain, each with whether its intensity follows the data, that the motion may have."""
    if ch.has[2]:
        return [(4, True), (3, False), (4, False), (3, True)]
    return [(4, False), (3, False)]


FEW_STEPS, MOVING, WHOLE, ALL_BUT_A_FEW = 20, 0.95, 0.02, 0.99
"""Steps from which counts are looked for, the most of all samples that may move, how near to whole counts steps must be
[1], and how many of them."""


class _Search:
    """Search for the likeliest noise levels, and lag where it is free, under the motion model of its start.

    value: least of minus the logarithm of the likelihood so far.
    """

    def __init__(self, ch: Channels, start: Noise, *, free_lag: bool = False) -> None:
        self._ch, self._start = ch, start
        self._names = [n for n, h in zip(("x", "v", "a"), ch.has, strict=True) if h] + ["drive"]
        self._with_lag = free_lag and ch.shows_lag
        point = np.log([getattr(start, n) for n in self._names])
        if self._with_lag:
            point = np.append(point, start.lag / ch.dt)
        self._simplex = np.vstack([point, point + 0.7 * np.eye(point.size)])
        self._left = 40 * point.size
        self._ended = False
        self.value = float("inf")

    def go_on(self, steps: int | None = None) -> None:
        """So many steps of the search, or all that are left of it: as if it had never paused."""
        if self._ended:
            return
        limit = {} if steps is None else {"maxiter": steps}
        found = minimize(self._cost, self._simplex[0], method="Nelder-Mead", options={
            "initial_simplex": self._simplex, "maxfev": self._left, "xatol": 0.02, "fatol": 0.5, **limit,
        })  # fmt: skip
        self._simplex, self.value = found.final_simplex[0], float(found.fun)
        self._ended = bool(found.success) or steps is None
        self._left += len(self._simplex) - found.nfev  # its corners are asked again

    @property
    def noise(self) -> Noise:
        """The likeliest so far, with the standard deviation of a free lag."""
        best = self._noise_at(self._simplex[0])
        return replace(best, lag_sd=self._lag_sd()) if self._with_lag else best

    def _noise_at(self, theta: Array) -> Noise:
        values = np.exp(np.clip(theta[: len(self._names)], -40, 40)).tolist()
        named = dict(zip(self._names, values, strict=True))
        if self._with_lag:
            named["lag"] = float(np.clip(theta[-1], -20, 20)) * self._ch.dt
        return replace(self._start, **named)

    def _cost(self, theta: Array) -> float:
        return _cost(self._ch, self._noise_at(theta))

    def _lag_sd(self) -> float:
        """Standard deviation of the lag [s], from the curvature of the likelihood."""
        theta, cost, step = self._simplex[0], self._cost, np.zeros(self._simplex.shape[1])
        step[-1] = 0.05
        curvature = (cost(theta + step) - 2.0 * cost(theta) + cost(theta - step)) / 0.05**2
        return float(self._ch.dt / np.sqrt(curvature)) if curvature > 0 else float("inf")


def estimate_noise(ch: Channels, lag: float = 0.0, whole: Channels | None = None) -> Noise:
    """Maximum likelihood noise levels under the likeliest of the four motion models, at a known lag [s].

    whole: the record of which these samples are a part: counts of an encoder may show in another one.
    """
    searches = [
        _Search(ch, replace(_start(ch, order), local=local, lag=lag))
        for order, local in _kinds(ch)
    ]
    _go_on(searches, ch.z.shape[0], FIRST)
    limit = min(search.value for search in searches) + BEHIND * ch.z.shape[0]
    near = [search for search in searches if search.value <= limit]
    _go_on(near, ch.z.shape[0])
    found = min(near, key=lambda search: search.value).noise
    least = count((whole or ch).z[:, 0]) / np.sqrt(12.0) if ch.has[0] else 0.0
    return found if found.x >= least else adapt(ch, replace(found, x=least))


def count(y: Array) -> float:
    """Step of an encoder or converter whose counts a channel (n,) shows, in its unit; 0 where it shows none.

    At a halt the counts stand still and look like no noise at all; what they hide is as large as ever.
    """
    steps = np.abs(np.diff(y))
    moves = steps[steps > 1e-9 * max(float(np.ptp(y)), 1e-300)]
    if moves.size < FEW_STEPS or moves.size > MOVING * steps.size:
        return 0.0
    least = float(moves.min())
    whole = np.abs(moves / least - np.round(moves / least)) < WHOLE
    return least if np.mean(whole) > ALL_BUT_A_FEW else 0.0


def _go_on(searches: list[_Search], rows: int, steps: int | None = None) -> None:
    """So many steps of every search on so many samples, each on a core."""

    def run(i: int, j: int) -> None:
        for search in searches[i:j]:
            search.go_on(steps)

    over_cores(run, len(searches), len(searches) * rows * FILTER)


def estimate_lag(ch: Channels, noise: Noise) -> Noise:
    """Noise levels with the lag of the velocity channel free, under the motion model of `noise`."""
    search = _Search(ch, noise, free_lag=True)
    search.go_on()
    return search.noise


def adapt(ch: Channels, noise: Noise) -> Noise:
    """The same sensors on another record: its own motion model, with its intensity by maximum likelihood.

    Sensors keep their noise from record to record; a fast sine is driven a hundred times harder than a slow one.
    """
    found = [
        _intensity(ch, replace(noise, order=order, local=local)) for order, local in _kinds(ch)
    ]
    return max(found, key=lambda noise: likelihood(ch, noise))


def _intensity(ch: Channels, noise: Noise) -> Noise:
    """Likeliest intensity of the noise that drives the chain, the sensors' noise being known."""
    start = float(np.log(_start(ch, noise.order).drive))

    def cost(log_drive: float) -> float:
        return _cost(ch, replace(noise, drive=float(np.exp(log_drive))))

    found = minimize_scalar(
        cost, bounds=(start - 25.0, start + 10.0), method="bounded", options={"xatol": 0.1}
    )
    return replace(noise, drive=float(np.exp(found.x)))
