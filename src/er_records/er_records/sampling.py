"""Times of a record's samples: how even they are, equal steps, and the slope of the deflection.

Pure functions Record -> Record; each writes a note on what it changed.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from er_records.record import HELD, Array, Record
from er_records.timing import rounded

JITTER = 0.10
"""Largest deviation of a sample time from the median, as a share of it, that is left as it is."""
ROUNDED = 1e-3
"""Difference of median and mean sample time, as a share, up to which either will do."""


def jitter(record: Record) -> float:
    """Largest deviation of a sample time from the median, as a share of it."""
    steps = np.diff(record.t)
    return float(np.max(np.abs(steps - record.dt)) / record.dt)


def even(record: Record, limit: float = JITTER) -> Record:
    """Resample onto equal steps of the median sample time when the jitter exceeds `limit`.

    Linear between samples; duty is that of the nearest one. A row says what was in force when it was taken: by its
    stamp, half of the steps would come a sample late. Steps that jitter less are left as they are, unless times that
    are rounded (512 Hz in tenths of a millisecond), or a rate that changes, make the median step another than the mean.
    """
    measured, dt = jitter(record), record.dt
    mean = float(record.t[-1] - record.t[0]) / (len(record) - 1)
    if measured <= limit and abs(dt - mean) <= ROUNDED * mean:
        return record
    line = rounded(record.t)
    if line is not None:
        note = f"times are rounded: equal steps of {1e3 * line[1]:.5g} ms instead of {1e3 * dt:.5g} ms as a rule"
        t: Array = np.asarray(line[0] + line[1] * np.arange(len(record)), dtype=np.float64)
        return replace(record, t=t).noted(note)
    if measured > limit:
        why = f"sampling is uneven (jitter {100 * measured:.0f} % of {1e3 * dt:.4g} ms)"
        return _resampled(record, dt, why)
    return _resampled(
        record, mean, f"the sample time changes ({1e3 * dt:.4g} ms as a rule, {1e3 * mean:.4g} ms on average)"
    )  # fmt: skip


def _resampled(record: Record, dt: float, why: str) -> Record:
    """A record at equal steps [s], with a note that says why."""
    grid = record.t[0] + dt * np.arange(
        int(np.floor((record.t[-1] - record.t[0]) / dt + 1e-6)) + 1
    )
    channels = {
        name: at(record.t, samples, grid, name, 0.5 * dt)
        for name, samples in record.channels.items()
    }
    note = f"{why}: {len(record)} samples resampled to {grid.size} at equal steps"
    return replace(record, t=grid, channels=channels).noted(note)


def at(t: Array, samples: Array, grid: Array, name: str, early: float = 0.0) -> Array:
    """Samples of a channel at other times (M,): the value in force for duty, linear otherwise.

    early: time [s] before its stamp from which on a value of the duty is in force.
    """
    if name in HELD:
        # a hair of tolerance, so that a grid point on a sample takes that sample
        hair = 1e-6 * float(np.median(np.diff(t))) if t.size > 1 else 0.0
        k = np.searchsorted(t, grid + max(early, hair), side="right") - 1
        return np.asarray(samples[np.clip(k, 0, None)])
    return np.asarray(np.interp(grid, t, samples))


def with_deflection(record: Record) -> Record:
    """Add the deflection that heights of body and wheel show when none was measured."""
    heights = ("sprung_displacement", "unsprung_displacement")
    if record.has("deflection") or not all(map(record.has, heights)):
        return record
    body, wheel = (record.channels[name] for name in heights)
    derived = (*record.derived, "deflection")
    note = "deflection derived: sprung_displacement less unsprung_displacement"
    return replace(
        record, channels={**record.channels, "deflection": body - wheel}, derived=derived
    ).noted(note)


def _slopes() -> Array:
    """Slopes (7, 7) per sample at each of seven samples, of the cubic fitted to them."""
    at = np.vander(np.arange(-3.0, 4.0), 4, increasing=True)
    return np.asarray((at[:, :3] * (1.0, 2.0, 3.0)) @ np.linalg.pinv(at)[1:])


def with_velocity(record: Record) -> Record:
    """Add the deflection's derivative when no velocity was measured.

    Slope of a cubic fitted to 7 samples (Savitzky and Golay 1964): within 1 % up to 15 Hz for 200
    Hz sampling, where a central difference is 4 % low, and with 28 % less noise.
    """
    if record.has("deflection_velocity") or not record.has("deflection") or len(record) < 7:
        return record
    x, (first, slope, last) = record.channels["deflection"], np.split(_slopes(), (3, 4))
    inner = np.convolve(x, slope[0, ::-1], "valid")
    velocity = np.concatenate([first @ x[:7], inner, last @ x[-7:]]) / record.dt
    channels = {**record.channels, "deflection_velocity": velocity}
    derived = (*record.derived, "deflection_velocity")
    note = "deflection_velocity derived from the deflection (cubic through 7 samples)"
    return replace(record, channels=channels, derived=derived).noted(note)
