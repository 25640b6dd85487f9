"""Prediction of the damper force from measured motion and duty."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from er_models.errors import InputError
from er_models.kernel.layout import CAUGHT
from er_models.kernel.load import kernel, plain
from er_models.model import Array, Model
from er_models.parallel import over_cores

SUBSTEP = 0.625e-3
"""Longest step of the integrator [s]; the error at 200 Hz is shown by test_integrator_damper."""


@dataclass(frozen=True)
class Motion:
    """Inputs of a damper, one or more records laid end to end.

    x, v, a: deflection [m], velocity [m/s], acceleration [m/s2]; u: duty held from each sample on;
    theta: temperature difference [K]; all (n,). starts (m+1,): first rows of the records and the end. began (m,): when
    each record began on one clock [s], where they follow one another: heat and ageing go on from one to the next. None:
    each begins anew.
    """

    dt: float
    x: Array
    v: Array
    a: Array
    u: Array
    theta: Array
    starts: np.ndarray
    began: Array | None = None

    @property
    def n(self) -> int:
        """Number of samples."""
        return int(self.x.shape[0])

    @property
    def t(self) -> Array:
        """Time since the start of each sample's record, or of the first of those that follow one another [s]."""
        out = np.empty(self.n)
        *_, clocks = self.course.T
        for i, j, clock in zip(self.starts[:-1], self.starts[1:], clocks, strict=True):
            out[i:j] = clock + np.arange(j - i) * self.dt
        return out

    @property
    def course(self) -> Array:
        """How records follow one another (m, 4), as the kernel takes it (`kernel.imposed`)."""
        m = self.starts.size - 1
        turn, before, pause, clock = np.arange(m), np.full(m, -1.0), np.zeros(m), np.zeros(m)
        if self.began is not None:
            turn = np.argsort(self.began, kind="stable")
            first, later = turn[:-1], turn[1:]
            ends = self.began + np.diff(self.starts) * self.dt
            before[later] = first
            pause[later] = np.maximum(self.began[later] - ends[first], 0.0)
            clock = self.began - self.began[turn[0]]
        return np.column_stack([turn, before, pause, clock])


@dataclass(frozen=True)
class Told:
    """What tells where the states of each record begin.

    force (n,): measured [N]; weight (n,): how much each sample tells [1/N2], zero where it tells nothing; unscored:
    first samples of a record, which nothing is judged by; caught (records, n_states): about where states that a contact
    may catch were found to begin (`caught`); they are looked for everywhere where it is NaN, or None.
    """

    force: Array
    weight: Array
    unscored: int
    caught: Array | None = None


def motion(
    dt: float, x: Array, v: Array, u: Array, a: Array | None = None, theta: Array | None = None
) -> Motion:
    """One record as a `Motion`.

    dt: time between samples [s]; x: deflection [m]; v: its velocity [m/s]; u: duty [1], held from each sample on;
    a: acceleration [m/s2], the derivative of v where it is absent; theta: temperature above the reference [K], zero
    where it is absent; (n,) each.

    Raises:
        InputError: A signal that is not (n,), or a dt that is not above zero.
    """
    given = {"x": x, "v": v, "u": u, "a": a, "theta": theta}
    y = {k: np.ascontiguousarray(s, float) for k, s in given.items() if s is not None}
    n = y["x"].size
    for name, signal in y.items():
        if signal.shape != (n,):
            raise InputError("motion", name, f"{n} samples, as x", f"shape {signal.shape}")
    if not dt > 0.0:
        raise InputError("motion", "dt", "a time above 0 s", f"{dt:g} s")
    y.setdefault("a", np.gradient(y["v"], dt) if n > 1 else np.zeros(n))
    y.setdefault("theta", np.zeros(n))
    return Motion(dt=dt, **y, starts=np.array([0, n]))


def join(parts: list[Motion]) -> Motion:
    """Several motions of equal sampling as one; each begins anew, as a record of its own.

    parts: of (n_i,) samples each; the time between samples [s] is that of the first.
    """
    rows = np.concatenate([[0], np.cumsum([m.n for m in parts])])

    def joined(name: str) -> Array:
        return np.concatenate([getattr(m, name) for m in parts])

    return Motion(
        parts[0].dt,
        joined("x"),
        joined("v"),
        joined("a"),
        joined("u"),
        joined("theta"),
        starts=rows,
    )


def substeps(dt: float, longest: float = SUBSTEP) -> int:
    """Integrator steps per sample, none longer than that [s]."""
    return max(1, int(np.ceil(dt / longest - 1e-9)))


def predict(
    model: Model, inputs: Motion, told: Told | None = None, *, longest: float = SUBSTEP
) -> Array:
    """Damper force that the load cell shows along a motion (n,) [N].

    model: a damper, or a car, of which the damper is taken; inputs: one or more records, each of which begins in
    equilibrium with its first sample but for states that begin at rest; or, where a measured force is told, where that
    says. The integrator takes equal steps, at most `longest` [s]. Not finite where the motion is not, or where
    parameters lie far outside their bounds.

    Source: thesis (1.12) for the core, that of each effect for the rest (`effects()[name].source`).
    """
    return np.asarray(_predicted(model, model.compiled().p[None], inputs, told, longest).forces[0])


def predict_many(
    model: Model, vectors: Array, inputs: Motion, told: Told | None = None, *, longest: float = SUBSTEP
) -> Array:  # fmt: skip
    """Forces (m, n) [N] of one model with m sets of parameters, as `predict` gives each, over all cores.

    vectors (m, n_parameters): of the whole catalogue, as `model.compiled().p` [SI]; `model.catalogue.column` says where
    a parameter stands.
    """
    return _predicted(model, vectors, inputs, told, longest).forces


def beginnings(model: Model, inputs: Motion, told: Told, *, longest: float = SUBSTEP) -> float:
    """How many numbers the measured force has told of where the states of all records begin.

    One of which it tells nothing, or that is forgotten before anything is judged, does not count. longest: as in
    `predict`.
    """
    return float(_predicted(model, model.compiled().p[None], inputs, told, longest).spent[0])


def caught(
    model: Model, inputs: Motion, told: Told, *, longest: float = SUBSTEP
) -> tuple[Array, Array] | None:
    """Force (n,) [N], and about where states begin that a contact may catch anywhere, as shares of their ways.

    These (records, n_states) are NaN for all other states; None where the model has none that is not known yet. As
    `Told.caught` they spare models nearby the look for them, which takes ten runs from the beginning of each record.
    longest: as in `predict`.
    """
    c = model.compiled()
    states = c.slots[c.at_rest[c.slots] == CAUGHT]
    if not states.size or (
        told.caught is not None and np.isfinite(told.caught[:, states]).any(axis=0).all()
    ):
        return None
    found = _predicted(model, c.p[None], inputs, told, longest)
    return found.forces[0], found.caught[0]


class _Predicted(NamedTuple):
    """Forces (m, n) [N], the beginnings that were told (m,), and about where what may be caught began.

    The last (m, records, n_states) is NaN for all other states.
    """

    forces: Array
    spent: Array
    caught: Array


def _predicted(
    model: Model, vectors: Array, inputs: Motion, told: Told | None, longest: float = SUBSTEP
) -> _Predicted:
    """What a model predicts with each of some vectors (m, n_parameters), over all cores."""
    m, records = vectors.shape[0], inputs.starts.size - 1
    none = np.full((m, records, model.catalogue.n_states), np.nan)
    out = _Predicted(np.empty((m, inputs.n)), np.zeros(m), none)
    n_sub = substeps(inputs.dt, longest)
    rows = _rows(model, vectors, inputs, told, n_sub)
    over_cores(
        lambda i, j: rows(_Predicted(*(part[i:j] for part in out)), i, j),
        m,
        out.forces.size * n_sub,
    )
    return out


def _rows(
    model: Model, vectors: Array, inputs: Motion, told: Told | None, n_sub: int
) -> Callable[[_Predicted, int, int], None]:
    """What predicts rows i to j of the vectors into arrays of as many; it holds no lock of Python."""
    c, made = model.compiled(), kernel(model.catalogue)
    x, v, a, u, theta = map(plain, (inputs.x, inputs.v, inputs.a, inputs.u, inputs.theta))
    vectors, starts = plain(vectors), inputs.starts
    shared = (c.on, c.slots, c.links, c.at_rest)
    along = (inputs.dt, starts, plain(inputs.course), x, v, a, u, theta, n_sub)
    if told is None or not c.slots.size:
        return lambda out, i, j: made.predict_rows(*shared, vectors[i:j], *along, out.forces)
    force, weight = plain(told.force), plain(told.weight)
    unknown = np.full((starts.size - 1, model.catalogue.n_states), np.nan)
    hints = unknown if told.caught is None else plain(told.caught)

    def rows(out: _Predicted, i: int, j: int) -> None:
        made.begun_rows(*shared, vectors[i:j], *along, force, weight, told.unscored, hints, *out)

    return rows
