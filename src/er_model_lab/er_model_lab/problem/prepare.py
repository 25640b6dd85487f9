"""From records to a fitting problem: fused motion, measured force, and who may see which sample.

Held-out samples are never used for fitting or for choosing an effect; they only score the result.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace
from functools import lru_cache
from itertools import pairwise

import numpy as np
from er_models.errors import InputError, MissingChannel
from er_models.model import Array
from er_models.prediction import Motion, join
from er_records.dataset import Dataset
from er_records.missing_channels import ACCELEROMETERS, losses
from er_records.record import HELD, Record
from er_records.sampling import ROUNDED, at
from numpy.typing import NDArray

from er_model_lab.motion.drift import without_drift
from er_model_lab.motion.fuse import WITHOUT_A, Channels, Fused, Noise, channels_of, fuse
from er_model_lab.motion.noise_levels import adapt, estimate_lag, estimate_noise
from er_model_lab.motion.white_noise import white_noise
from er_model_lab.problem.held_out import split
from er_model_lab.problem.problem import Problem
from er_model_lab.work import HERE, Work

FOR_NOISE = 2500
"""Samples from which the noise levels of the motion sensors and the intensity of a motion are estimated."""
MOTION = ("deflection", "deflection_velocity", *ACCELEROMETERS)
"""Channels of the motion."""
LONGEST_PAUSE = 3600.0
"""Pause between two records [s] after which the second is not taken as going on from the first."""
BESIDE = 2
"""Samples to either side of wild motion whose force says nothing, either."""
CONTRADICTION = 0.03
"""Difference of two estimates of a lag, in samples, above which accelerometers contradict the other channels."""
CONTRADICTION_SD = 4.0
"""Standard deviations of such an estimate that the difference must exceed as well: less is its noise."""


def prepare(
    data: Dataset,
    *,
    velocity_lag: float | None = None,
    learn: Sequence[int] | None = None,
    work: Work = HERE,
) -> Problem:
    """Fuse and split records; needs damper_force, and deflection or its velocity.

    Records that score are held out whole; without them `split` chooses what is.

    velocity_lag: known lag of the velocity channel [s]; None estimates it and keeps it as evidence only.
    learn: records that noise levels and the lag may be read off; None: those that are not held out whole.
    work: how the jobs of this problem are done. What was prepared last is kept: every verb asks for it.

    Raises:
        MissingChannel: Without force, or without both deflection and velocity.
        InputError: When there is not enough data to split.
    """
    decides = (data.learn, data.score, data.originals, data.whole is None)
    chosen = None if learn is None else tuple(learn)
    return replace(_prepared(decides, velocity_lag, chosen, _Asked(data, work)), work=work)


@dataclass(frozen=True)
class _Asked:
    """Data and how jobs are done: what decides of them stands beside."""

    data: Dataset = field(compare=False)
    work: Work = field(compare=False)


@lru_cache(maxsize=2)
def _prepared(
    decides: tuple[object, ...], velocity_lag: float | None, learn: tuple[int, ...] | None, asked: _Asked
) -> Problem:  # fmt: skip
    """As `prepare`; decides: all of the data that does."""
    del decides
    data, work = asked.data, asked.work
    records = data.records
    if not records:
        raise InputError("data", "", "at least one record", "none")
    dt = max(r.dt for r in records)
    measured = tuple(measured_channels(r, dt) for r in records)
    able = range(len(data.learn)) if learn is None else learn
    longest = _most(measured, able)
    part = measured[longest].telling(FOR_NOISE)
    telling = _most(measured, [r for r in able if measured[r].shows_lag] or able)
    lag, lag_sd = (
        (velocity_lag, 0.0)
        if velocity_lag is not None
        else _lag_evidence(part if telling == longest else measured[telling].telling(FOR_NOISE))
    )
    raw, noise, unresolved = _usable(measured, part, lag, velocity_lag or 0.0, measured[longest])
    noise = _completed(noise, part, raw)
    jobs = [(c, r == longest) for r, c in enumerate(raw)]
    fused = tuple(work.map(_fused, jobs, noise, stage="fusing the sensors"))
    force = [resampled(r, "damper_force", dt) for r in records]
    reference = reference_temperature(data.originals, dt)
    motion = join(
        [_motion(r, f, c, dt, reference) for r, f, c in zip(records, fused, raw, strict=True)]
    )
    motion = replace(motion, began=None if data.whole else began(records))
    fold, held_out = split(motion, len(data.score))
    wild = np.concatenate([without_weight(r, dt) for r in records])
    fold[wild], held_out[wild] = -1, False
    learnt = [r for r, (i, j) in enumerate(pairwise(motion.starts)) if np.any(fold[i:j] >= 0)]
    if learn is None and not {longest, telling} <= set(learnt):
        return prepare(data, velocity_lag=velocity_lag, learn=learnt, work=work)
    y = np.concatenate(force)
    return Problem(
        motion=motion, force=y, fold=fold, held_out=held_out, raw=raw, fused=fused, noise=noise,
        names=tuple(r.name for r in records),
        notes=tuple(dict.fromkeys(n for r in records for n in r.notes)) + unresolved + losses(records),
        complete=all(r.complete for r in records), sd_force=white_noise(force), velocity_lag=(lag, lag_sd),
        work=work, wild=wild,
    )  # fmt: skip


def _fused(job: tuple[Channels, bool], noise: Noise) -> Fused:
    """Motion of a record from its channels; noise: whether its motion is that which the noise levels are read off."""
    channels, known = job
    own = noise if known else adapt(channels.telling(FOR_NOISE), noise)
    return _centred(fuse(channels, own), channels)


def _most(measured: Sequence[Channels], able: Sequence[int]) -> int:
    """The longest of the records with most channels."""
    return max(able, key=lambda r: (int(measured[r].has.sum()), measured[r].z.shape[0]))


def measured_channels(record: Record, dt: float) -> Channels:
    """The motion channels a record has, on the common grid."""
    both = record.has("sprung_acceleration") and record.has("unsprung_acceleration")
    a = None
    if both:
        a = resampled(record, "sprung_acceleration", dt) - resampled(
            record, "unsprung_acceleration", dt
        )
    if not (record.has("deflection") or record.has("deflection_velocity")):
        path = record.source or record.name
        why, present = _without_motion(a, dt), tuple(record.channels)
        raise MissingChannel(path, "deflection", why, present, record.cure)
    v = None
    if record.has("deflection_velocity") and "deflection_velocity" not in record.derived:
        v = resampled(record, "deflection_velocity", dt)
    x = resampled(record, "deflection", dt) if record.has("deflection") else None
    gone = [_wild(record, c, dt) for c in MOTION]
    lost = np.stack([gone[0], gone[1], gone[2] | gone[3]], axis=1)
    return channels_of(dt, x, v, a, lost)


def _wild(record: Record, channel: str, dt: float) -> NDArray[np.bool_]:
    """Samples of a channel on the common grid in which a wild one takes part."""
    found = (record.wild or {}).get(channel)
    ratio, mask = dt / record.dt, np.zeros(len(record)) if found is None else found
    if abs(ratio - 1.0) <= ROUNDED:
        return mask > 0.0
    wide = np.convolve(mask, np.ones(2 * max(round(ratio), 1) + 1), "same")
    return at(record.t, wide, np.arange(record.t[0], record.t[-1], dt), channel) > 0.0


def without_weight(record: Record, dt: float) -> NDArray[np.bool_]:
    """Samples (n,) on the common grid at which the force, or the motion that it is predicted from, is wild."""
    moved = np.logical_or.reduce([_wild(record, c, dt) for c in MOTION if c not in record.derived])
    beside = np.convolve(moved, np.ones(2 * BESIDE + 1), "same") > 0.5
    return np.asarray(beside | _wild(record, "damper_force", dt))


def _without_motion(a: Array | None, dt: float) -> str:
    """Why the accelerations (n,) [m/s2] do not stand in for the motion: their noise, integrated over the record."""
    if a is None:
        return "(or deflection_velocity) to know the motion"
    drift = 1e3 * white_noise([a]) * np.sqrt(dt * a.size * dt)
    return (
        "(or deflection_velocity) to know the motion, since the velocity that the accelerations give may drift by "
        f"{float(f'{drift:.2g}'):g} mm/s in {a.size * dt:.3g} s"
    )


def resampled(record: Record, channel: str, dt: float) -> Array:
    """A channel on the common grid; averaged over the longer step when the grid is coarser."""
    record.need(channel, "to compare the damper force")
    y = record.bridged(channel)
    ratio = dt / record.dt
    if abs(ratio - 1.0) <= ROUNDED:
        return np.asarray(y)
    grid = np.arange(record.t[0], record.t[-1], dt)
    smooth = y if channel in HELD else _averaged(y, max(round(ratio), 1))
    return at(record.t, smooth, grid, channel)


def _averaged(y: Array, width: int) -> Array:
    """Mean of as many samples (n,) about each; of an even number, the outermost two count half.

    Beyond its ends a channel goes on point-symmetrically, so that neither a rest nor a steady motion is shifted there.
    """
    half = width // 2
    window = np.ones(2 * half + 1) / width
    window[[0, -1]] *= 1.0 if width % 2 else 0.5
    padded = np.pad(y, half, mode="reflect", reflect_type="odd")
    return np.asarray(np.convolve(padded, window, "valid"))


def reference_temperature(records: Sequence[Record], dt: float) -> float:
    """First temperature [K] of whole records, which `theta` of all of them, and of stretches of them, counts from."""
    measured = (r for r in records if r.has("temperature"))
    first = next(measured, None)
    return 0.0 if first is None else float(resampled(first, "temperature", dt)[0])


def began(records: Sequence[Record]) -> Array | None:
    """When each record began on one clock (m,) [s]; None where their stamps do not say that they follow one another.

    Clocks that begin anew with each file overlap. After a long pause nothing is known of the heat.
    """
    first, last = (np.array([r.t[k] for r in records]) for k in (0, -1))
    turn = np.argsort(first, kind="stable")
    pauses = first[turn[1:]] - last[turn[:-1]]
    follow = pauses.size and np.all(pauses > 0.0) and np.all(pauses <= LONGEST_PAUSE)
    return first - first[turn[0]] if follow else None


def warmth(record: Record, dt: float, n: int, reference: float) -> Array:
    """Measured temperature above the reference (n,) [K]; zeros where none was measured."""
    if not record.has("temperature"):
        return np.zeros(n)
    return np.asarray(resampled(record, "temperature", dt) - reference)


def _motion(
    record: Record, fused: Fused, channels: Channels, dt: float, reference: float
) -> Motion:
    """Inputs of the damper model of one record; reference: temperature at which theta is 0 [K]."""
    n = fused.x.shape[0]
    u = resampled(record, "duty", dt) if record.has("duty") else np.zeros(n)
    theta = warmth(record, dt, n, reference)
    a = fused.a if channels.has[2] or not channels.measured_a else channels.z[:, 2].copy()
    return Motion(dt, fused.x, fused.v, a, np.ascontiguousarray(u), theta, np.array([0, n]))


def _lag_evidence(channels: Channels) -> tuple[float, float]:
    """Lag of the velocity channel with its standard deviation [s].

    The deflection decides where there is one: what an accelerometer does between two samples is a guess,
    and a wrong guess looks like a lag. Without it, a lag below a fifth of a sample is not believed.
    """
    channels = channels.inside()
    if channels.has[0] and channels.has[1]:
        without = channels.only(WITHOUT_A)
        found = estimate_lag(without, estimate_noise(without))
        return found.lag, found.lag_sd
    if channels.has[1] and channels.has[2]:
        found = estimate_lag(channels, estimate_noise(channels))
        return found.lag, max(found.lag_sd, 0.025 * channels.dt)
    return 0.0, float("inf")


def _usable(
    measured: tuple[Channels, ...], part: Channels, lag: float, undone: float, whole: Channels
) -> tuple[tuple[Channels, ...], Noise, tuple[str, ...]]:
    """Channels to fuse, their noise levels, and what was left out.

    Accelerations that change faster than the sampling resolves contradict the other channels: fused
    with them, the velocity seems to lag where deflection and velocity alone say that it does not. They are
    then kept as accelerations, but the velocity is not made from them. How noisy deflection and velocity are is still
    read off all three: without them rough motion and noise of the velocity look alike, and the velocity is believed
    three times too much. undone: lag of the velocity channel that fusion takes out, in the noise returned; whole: the
    record of which the part is one.
    """
    noise = estimate_noise(part, undone, whole)
    if not (part.has[0] and part.has[1] and part.has[2]):
        return measured, noise, ()
    seen = estimate_lag(part, noise)
    if abs(seen.lag - lag) < max(CONTRADICTION * part.dt, CONTRADICTION_SD * seen.lag_sd):
        return measured, noise, ()
    note = (
        "the accelerations change faster than the sampling resolves: "
        "the velocity is fused from deflection and velocity only"
    )
    levels = adapt(part.only(WITHOUT_A), replace(seen, lag=undone))
    return tuple(c.only(WITHOUT_A) for c in measured), levels, (note,)


def _completed(noise: Noise, part: Channels, raw: tuple[Channels, ...]) -> Noise:
    """Noise levels with those of channels that the record they are read off lacks, and another one has."""
    for k, name in enumerate(("x", "v", "a")):
        having = [c for c in raw if c.has[k]]
        if part.has[k] or not having:
            continue
        longest = max(having, key=lambda c: c.z.shape[0])
        own = estimate_noise(longest.telling(FOR_NOISE), noise.lag, longest)
        noise = replace(noise, **{name: getattr(own, name)})
    return noise


def _centred(fused: Fused, channels: Channels) -> Fused:
    """The motion about its middle where no deflection was measured: an offset of the velocity would carry it away."""
    if channels.has[0]:
        return fused
    x, v = without_drift(fused.x, fused.v, channels.dt)
    return replace(fused, x=x, v=v)
