"""The rate that a record's content needs: what was sampled far faster is brought there before anything is fitted."""

from __future__ import annotations

from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from er_models.model import Array
from er_records.missing_channels import ACCELEROMETERS
from er_records.record import HELD, Record

from er_model_lab.filtering import kaiser, low_pass, welch

SPOKEN = ("damper_force", *ACCELEROMETERS)
"""Channels that a model must describe: their content decides."""
ABOVE, CLEAN = 1e-4, 1e-8
"""Share of a channel's variance, noise aside, that may lie above the frequency that counts as its highest, where it has
more white noise than that below; that of a channel without noise."""
TIMES = 5.0
"""Samples for each period of that frequency."""
LEAST, MOST, SHARP = 200.0, 500.0, 1000.0
"""A rate [Hz] that is always kept; one that is enough, for a jump of the force has no highest frequency; and one for
jumps that stand so far above the noise that the filter would lose more of them than there is noise, and for a fast
force whose duty jumps between the samples of the slower rate: held at its mean there, it acts later than it did."""
JUMP = 0.01
"""Change of the duty from one sample to the next that is a jump."""
PASS, STOP, DOWN = 0.25, 0.75, 45.0
"""Ends of what the filter lets pass and of what it stops, as shares of the new rate; how far it stops that [dB]."""
WINDOW = 2.0
"""Length of the pieces that a spectrum is averaged over [s]."""


@dataclass(frozen=True)
class Spectrum:
    """Frequencies (m,) [Hz] of a channel, its power there, white noise aside (m,), and the power of the noise."""

    f: Array
    signal: Array
    noise: float


def spectrum(y: Array, rate: float) -> Spectrum:
    """Of a channel (n,) at a rate [Hz]."""
    f, power = welch(y, rate, min(y.size, round(WINDOW * rate)), linear=True)
    noise = float(np.median(power[f > 0.8 * f[-1]]))
    return Spectrum(f, np.maximum(power - 2.0 * noise, 0.0), noise)


def highest(of: Spectrum) -> float:
    """Frequency [Hz] above which a channel has less content than white noise below, and no more than `ABOVE`."""
    f, signal = of.f, of.signal
    tail = np.cumsum(signal[::-1])[::-1]
    most = np.clip(of.noise * np.arange(f.size), CLEAN * tail[0], ABOVE * tail[0])
    return float(f[np.argmax(tail <= most)]) if tail[0] > 0.0 else 0.0


def loses(of: Spectrum, slower: float) -> bool:
    """Whether a channel at a slower rate [Hz] would lack more of its content than it has white noise there."""
    gone = of.f > 0.5 * slower
    return bool(of.signal[gone].sum() > of.noise * np.count_nonzero(~gone))


def _between(record: Record, slower: float) -> bool:
    """Whether the duty jumps between two samples of a slower rate [Hz]."""
    if not record.has("duty"):
        return False
    jumps = np.flatnonzero(np.abs(np.diff(record.bridged("duty"))) > JUMP) + 1
    return bool(np.any(jumps % int(1.0 / record.dt / slower + 1e-6)))


@lru_cache(maxsize=4)
def at_needed_rate(record: Record) -> Record:
    """The record at the fraction of its rate that its content needs, with a note; as it is where it needs all."""
    spoken = [record.bridged(c) for c in SPOKEN if record.has(c)]
    rate = 1.0 / record.dt
    if not spoken or rate < 2.0 * LEAST or len(record) < WINDOW * rate:
        return record
    seen = [spectrum(y, rate) for y in spoken]
    top = max(map(highest, seen))
    fast = TIMES * top > MOST
    sharp = fast and (
        any(loses(of, MOST) for of in seen) or (rate >= 2.0 * SHARP and _between(record, MOST))
    )
    most = SHARP if sharp else MOST
    every = int(rate / min(max(TIMES * top, LEAST), most) + 1e-6)
    if every < 2:
        return record
    channels = {name: _slower(record, name, every) for name in record.channels}
    wild = record.wild and {name: _any(mask, every) for name, mask in record.wild.items()}
    told = f"its content ends at {top:.3g} Hz" if TIMES * top <= most else "that is enough"
    note = f"{rate:.4g} Hz are filtered to {rate / every:.4g} Hz: {told}"
    return replace(record, t=record.t[::every], channels=channels, wild=wild).noted(note)


def _slower(record: Record, name: str, every: int) -> Array:
    """Every so manieth sample of a channel, what lies between them filtered in; of the duty, its mean until the next.

    Beyond its ends a channel goes on point-symmetrically, so that the filter bends neither a rest nor a steady motion.
    """
    y = record.bridged(name)
    if name in HELD:
        begins = np.arange(0, y.size, every)
        return np.add.reduceat(y, begins) / np.diff(begins, append=y.size)
    if not np.isfinite(y).all():
        return y[::every]
    taps, beta = kaiser(DOWN, (STOP - PASS) * 2.0 / every)
    half = min(taps // 2, y.size - 1)
    kernel = low_pass(2 * half + 1, (PASS + STOP) / every, beta)
    padded = np.pad(y, half, mode="reflect", reflect_type="odd")
    return np.asarray(np.convolve(padded, kernel, "valid")[::every])


def _any(mask: np.ndarray, every: int) -> np.ndarray:
    """Which of every so many samples stand for a marked one on either side."""
    near = np.convolve(mask, np.ones(2 * every + 1), "same") > 0.5
    return np.asarray(near[::every])
