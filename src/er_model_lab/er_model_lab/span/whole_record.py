"""Long records as a whole: their motion, fused in pieces, and effects that remember more than a stretch."""

from __future__ import annotations

import inspect
from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import lru_cache

import numpy as np
from er_models.effect import Effect
from er_models.model import Array, Model
from er_models.prediction import Motion, Told, beginnings, join, predict_many
from er_records.dataset import Dataset
from er_records.record import Record
from numpy.typing import NDArray

from er_model_lab.motion.drift import without_drift
from er_model_lab.motion.fuse import WITHOUT_A, Channels, Noise, channels_of, fuse
from er_model_lab.motion.noise_levels import adapt
from er_model_lab.problem.forward import DamperForward, Past
from er_model_lab.problem.held_out import telling
from er_model_lab.problem.motion_error import Sensed
from er_model_lab.problem.prepare import (
    FOR_NOISE,
    began,
    measured_channels,
    reference_temperature,
    resampled,
    warmth,
    without_weight,
)
from er_model_lab.problem.problem import Problem

PIECE = 60.0
"""Length of what is fused at once [s]; its noise model is its own."""
OVERLAP = 2.0
"""Time that two pieces share [s], so that neither shows where it begins."""
AT_ONCE = 4
"""Predictions of a whole motion that are kept at once."""


@dataclass(frozen=True)
class WholeRecords:
    """All records from beginning to end: motion, measured force (N,) [N], and what tells where their states begin.

    wild (N,): samples without weight; rows (n,): where a problem's samples are; data: the records,
    the first `learn` of which may be learnt from.
    """

    motion: Motion
    force: Array
    told: Told
    rows: NDArray[np.intp]
    data: tuple[Record, ...]
    learn: int
    wild: NDArray[np.bool_]


@dataclass(frozen=True)
class LongForward(DamperForward):
    """The force of the damper along stretches; what remembers more than a stretch acts along the whole record."""

    whole: WholeRecords

    def predict_many(self, data: Sensed, model: Model, vectors: Array) -> Array:
        """Forces (m, n) along the stretches."""
        if not remembers(model):
            return super().predict_many(data, model, vectors)
        out = np.empty((vectors.shape[0], self.whole.rows.size))
        for k in range(0, vectors.shape[0], AT_ONCE):
            some = vectors[k : k + AT_ONCE]
            forces = predict_many(
                model, some, self.whole.motion, self.whole.told, longest=self.longest
            )
            out[k : k + AT_ONCE] = forces[:, self.whole.rows]
        return self._complete(out)

    def _looked(self, data: Sensed, model: Model) -> tuple[Array | None, DamperForward]:
        """What is begun on stretches; itself where something acts along whole records."""
        return (None, self) if remembers(model) else super()._looked(data, model)

    def beginnings(self, data: Sensed, model: Model) -> float:
        """Of all states, of the stretches or of whole records."""
        if not remembers(model):
            return super().beginnings(data, model)
        return beginnings(model, self.whole.motion, self.whole.told)

    def past(self, data: Sensed) -> Past | None:
        """The motion of all records, and where the stretches are."""
        del data
        return self.whole.motion, self.whole.rows


def remembers(model: Model) -> bool:
    """Whether an effect of the model depends on how the record began: on time itself, or from rest on."""
    return any(_remembers(model.catalogue[name]) for name in model.effects)


def _remembers(effect: Effect) -> bool:
    """Whether a hook takes the time, or the state begins at zero."""
    timed = any("t" in inspect.signature(hook).parameters for hook in effect.hooks.values())
    return timed or effect.initial == "zero"


def on_whole(problem: Problem, data: Dataset) -> tuple[Problem, WholeRecords]:
    """A problem on stretches with the motion, the past and the time that they have in their records, and these."""
    whole = _whole(problem, data)
    m, rows = whole.motion, whole.rows
    kept = Motion(
        m.dt, m.x[rows], m.v[rows], m.a[rows], m.u[rows], m.theta[rows], problem.motion.starts
    )
    extra = (*problem.extra, ("time in the record", m.t[rows]))
    settled = replace(
        problem, motion=kept, force=whole.force[rows], forward=LongForward(whole), extra=extra
    )
    return settled, whole


def _whole(problem: Problem, data: Dataset) -> WholeRecords:
    """Motion and force of all records that stretches come from, and where the stretches are."""
    assert data.whole is not None
    dt, sources = problem.motion.dt, data.originals
    smooth = not any(c.measured_a and not c.has[2] for c in problem.raw)
    reference = reference_temperature(sources, dt)
    fused = [_fused(record, dt, problem.noise, smooth, reference) for record in sources]
    motion, force = join([m for m, _ in fused]), np.concatenate([f for _, f in fused])
    motion = replace(motion, began=began(sources))
    rows = []
    for place, n in zip(data.places, np.diff(problem.motion.starts), strict=True):
        begin = first_row(motion, sources, place.record, place.i)
        rows.append(np.minimum(begin + np.arange(n), motion.n - 1))
    found = np.concatenate(rows)
    wild = np.concatenate([without_weight(record, dt) for record in sources])
    told = replace(problem.told, force=force, weight=_weight(problem, motion, found, wild))
    return WholeRecords(motion, force, told, found, sources, len(data.whole.learn), wild)


def _weight(
    problem: Problem, motion: Motion, rows: NDArray[np.intp], wild: NDArray[np.bool_]
) -> Array:
    """How much each sample of whole records tells of their beginnings: all do that are not held out of a stretch."""
    free = np.ones(motion.n, bool)
    free[rows[problem.held_out]] = False
    return problem.weight_of(telling(motion, free, ~free) & ~wild)


def first_row(motion: Motion, data: Sequence[Record], record: int, row: int) -> int:
    """Row of the joined motion at which a row of a record lies."""
    t = data[record].t
    return int(motion.starts[record]) + round(float(t[row] - t[0]) / motion.dt)


@lru_cache(maxsize=256)
def _fused(
    record: Record, dt: float, noise: Noise, smooth: bool, reference: float
) -> tuple[Motion, Array]:
    """Motion and force of a whole record, fused piece by piece with the sensors' known noise.

    smooth: whether the velocity is made from the accelerations, too; reference: temperature at which theta is 0 [K].
    """
    channels = measured_channels(record, dt)
    if not smooth:
        channels = channels.only(WITHOUT_A)
    x, v, a = _pieces(channels, noise)
    n = x.size
    if not channels.has[0]:
        x, v = without_drift(x, v, dt)
    if channels.measured_a and not channels.has[2]:
        a = channels.z[:, 2].copy()
    u = resampled(record, "duty", dt) if record.has("duty") else np.zeros(n)
    theta = warmth(record, dt, n, reference)
    motion = Motion(dt, x, v, a, np.ascontiguousarray(u), theta, np.array([0, n]))
    return motion, resampled(record, "damper_force", dt)


def _pieces(channels: Channels, noise: Noise) -> Array:
    """Deflection, velocity and acceleration (3, n) of a record, fused a minute at a time.

    Where no deflection says where a piece lies, it goes on from the one before.
    """
    dt, n = channels.dt, channels.z.shape[0]
    piece, overlap = round(PIECE / dt), round(OVERLAP / dt)
    state, ahead = np.empty((3, n)), np.empty(0)
    for i in range(0, n, piece):
        j = min(i + piece, n)
        low, high = max(i - overlap, 0), min(j + overlap, n)
        part = rows_of(channels, low, high)
        found = fuse(part, adapt(part.telling(FOR_NOISE // 2), noise))
        x = found.x
        if ahead.size and not channels.has[0]:
            shared = min(ahead.size, x.size - (i - low))
            x = x + float(np.mean(ahead[:shared] - x[i - low :][:shared]))
        state[:, i:j] = np.stack([x, found.v, found.a])[:, i - low : j - low]
        ahead = x[j - low :]
    return state


def rows_of(channels: Channels, i: int, j: int) -> Channels:
    """Rows i to j of the channels, with their own local activity."""
    x, v, a = (channels.z[i:j, c].copy() for c in range(3))
    part = channels_of(channels.dt, x, v, a if channels.measured_a else None, channels.lost[i:j])
    return replace(part, has=channels.has)
