"""From the fine grid to the columns of a file: sensor laws, sampling, noise, encoder, and what goes wrong."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from scipy.signal import butter, lfilter, sosfiltfilt

from test.rough.device import FORCE_LATE, FORCE_SLOW, ZERO, Array
from test.rough.drives import Drive
from test.rough.rig import CHANNELS, DRIVEN, TOP, Rig

Columns = dict[str, Array]
Random = np.random.Generator
FORCE, X, V, A = range(4)
CLIPPED = 0.4
"""Time in all that a load cell is at the end of its range [s]."""
BITS = 16
"""Of the converter of the force, over twice its peak."""


@dataclass(frozen=True)
class Wrong:
    """What goes wrong in a record: ends bent by a decimation filter; wild samples of a kind (empty: none).

    wild: ``outliers`` (share of the force's samples), ``spike`` (of the motion), ``clip`` (the end of the load cell).
    """

    bent: bool = False
    wild: str = ""
    share: float = 0.003


def channel_force(force: Array, laws: Array, h: float) -> Array:
    """Force [N] as its channel shows it on the fine grid: two poles, then late."""
    slow, late = laws[FORCE_SLOW, 0], laws[FORCE_LATE, 0]
    out = force.astype(np.float64)
    for pole in (slow, 0.25 * slow):
        if pole > 0.0:
            out = _lagged(out, h / pole)
    if late > 0.0:
        t = np.arange(out.size) * h
        out = np.interp(t - late, t, out)
    return np.asarray(out)


def _lagged(y: Array, step: float) -> Array:
    """First-order lag, exact for straight lines between samples; step: the sample time over the time constant."""
    d = np.exp(-step)
    slope = (1.0 - d) / step
    b, a = [1.0 - slope, slope - d], [1.0, -d]
    return np.asarray(lfilter(b, a, y, zi=[y[0] * (slope - d) + d * y[0]])[0])


def sampled(rig: Rig, drive: Drive, fine: Array) -> Array:
    """The samples of a record (n,) of a signal on the fine grid."""
    return np.asarray(fine[drive.lead :: rig.every][: rig.n])


def clean(rig: Rig, drive: Drive, force: Array, laws: Array) -> Columns:
    """All columns without noise; accelerations of both ends of the device, whose upper one stands still."""
    x, v, a, u = (sampled(rig, drive, y) for y in (drive.x, drive.v, drive.a, drive.u))
    out = {
        "t": np.arange(rig.n) / rig.rate, "deflection": x + laws[ZERO, 0], "deflection_velocity": v,
        "damper_force": sampled(rig, drive, channel_force(force, laws, 1.0 / rig.fine)),
        "sprung_acceleration": 0.0 * a, "unsprung_acceleration": -a,
    }  # fmt: skip
    return out | ({"duty": u} if rig.device in DRIVEN else {})


def measured(rig: Rig, columns: Columns, wrong: Wrong, rng: Random) -> Columns:
    """The columns that this rig has, as its instruments record them."""
    n = rig.n
    sd = {
        "damper_force": rig.noise[FORCE], "deflection": rig.noise[X], "deflection_velocity": rig.noise[V],
        "sprung_acceleration": rig.noise[A], "unsprung_acceleration": rig.noise[A],
    }  # fmt: skip
    noisy = {name: columns[name] + s * rng.standard_normal(n) for name, s in sd.items()}
    if rig.count > 0.0:
        noisy["deflection"] = rig.count * np.floor(
            columns["deflection"] / rig.count + rng.random()
        )
    step = 4.0 * rig.force / 2**BITS
    noisy["damper_force"] = step * np.round(noisy["damper_force"] / step)
    spoil(rig, noisy, wrong, rng)
    kept = {"t": columns["t"]} | {
        name: noisy[name] for name in (*CHANNELS[rig.sensors], "damper_force")
    }
    return kept | ({"duty": columns["duty"]} if "duty" in columns else {})


def spoil(rig: Rig, columns: Columns, wrong: Wrong, rng: Random) -> None:
    """Put into the columns what goes wrong."""
    force = columns["damper_force"]
    if wrong.wild == "outliers":
        rows = rng.choice(
            np.arange(5, rig.n - 5), max(round(wrong.share * rig.n), 2), replace=False
        )
        force[rows] += (
            rng.choice([-1.0, 1.0], rows.size) * rng.uniform(1.0, 4.0, rows.size) * rig.force
        )
    elif wrong.wild == "spike":
        name = "unsprung_acceleration" if rig.sensors == "full" else "deflection"
        peak = np.abs(columns[name]).max()
        columns[name][rng.integers(rig.n // 4, 3 * rig.n // 4)] += 6.0 * peak
    elif wrong.wild == "clip":
        level = float(np.quantile(np.abs(force), 1.0 - min(CLIPPED * rig.rate / rig.n, 0.04)))
        np.clip(force, -level, level, out=force)
    if wrong.bent:
        ends = np.array([0.5, 0.86, 0.97])
        for name in {*CHANNELS[rig.sensors], "damper_force"}:
            columns[name][:3] *= ends
            columns[name][-3:] *= ends[::-1]


def filtered(rig: Rig, columns: Columns) -> Array:
    """Deflection, velocity, acceleration (n, 3) that a careful user makes of the channels: a filter without phase.

    The derivative of the filtered deflection and the measured velocity are weighed by their noise.
    """
    cut = min(2.2 * TOP * rig.frequency, 0.4 * rig.rate)
    sos = butter(4, cut, fs=rig.rate, output="sos")
    pad = min(columns["t"].size - 1, round(3.0 * rig.rate / cut))
    x = sosfiltfilt(sos, columns["deflection"], padlen=pad)
    v = np.gradient(x, 1.0 / rig.rate)
    if "deflection_velocity" in columns:
        own = (
            2.0 * np.pi * cut / np.sqrt(3.0) * max(float(rig.noise[X]), rig.count / np.sqrt(12.0))
        )
        share = own**2 / (own**2 + float(rig.noise[V]) ** 2)
        v = (1.0 - share) * v + share * sosfiltfilt(
            sos, columns["deflection_velocity"], padlen=pad
        )
    return np.stack([x, v, np.gradient(v, 1.0 / rig.rate)], axis=1)
