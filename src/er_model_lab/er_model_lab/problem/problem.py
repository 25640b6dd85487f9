"""A data set ready for prediction and fitting, and what is asked of it."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from functools import cached_property
from itertools import pairwise
from typing import Any, TypeVar

import numpy as np
from er_models.model import Array, Model
from er_models.parallel import cores
from er_models.prediction import Motion, Told
from er_models.scales import Scales, peak
from numpy.typing import NDArray

from er_model_lab.motion.fuse import Channels, Fused, Noise
from er_model_lab.motion.repetition import Cycle, cycles
from er_model_lab.problem.fit_store import Notes
from er_model_lab.problem.forward import COARSE, DAMPER, DamperForward, Forward, PartForward
from er_model_lab.problem.held_out import WARM_UP, telling
from er_model_lab.problem.subset import stretches_to_practise_on
from er_model_lab.work import HERE, Leader, Work

Result = TypeVar("Result")

LEAST_NOISE = 1e-12
"""White noise [N] in place of none."""
AT_ONCE = 100_000
"""Samples that are predicted at once, a good part of a second, where the work may be cancelled."""


@dataclass(frozen=True)
class Practice:
    """Stretches of the training runs as a problem of their own, and which rows of the whole they are."""

    problem: Problem
    rows: NDArray[np.intp]


@dataclass(frozen=True)
class Problem:
    """A data set ready for prediction and fitting; all arrays (n,), records laid end to end.

    force: measured [N]; where `forward`, which predicts it, has several outputs, those of each sample in turn,
    weighted to newtons, and motion and extra (what else moves, by name) have fewer rows; fold: block of each
    training sample, -1 elsewhere; held_out: mask of samples that only score; raw: measured channels before
    fusion; fused: per record, each with the noise model of its own motion; noise: that of the longest record
    with most channels; sd_force: white noise of the force; noted: fits that were made before, to which new ones are
    added; wild: samples without weight, `beside` of them found by what a model leaves; work: how its jobs are done, in
    another process one after the other.
    """

    motion: Motion
    force: Array
    fold: NDArray[np.int64]
    held_out: NDArray[np.bool_]
    raw: tuple[Channels, ...]
    fused: tuple[Fused, ...]
    noise: Noise
    names: tuple[str, ...]
    notes: tuple[str, ...]
    complete: bool
    sd_force: float
    velocity_lag: tuple[float, float]
    forward: Forward = DAMPER
    extra: tuple[tuple[str, Array], ...] = ()
    noted: Notes | None = None
    work: Work = HERE
    wild: NDArray[np.bool_] | None = None
    beside: int = 0

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "work": HERE}

    def each(
        self,
        function: Callable[..., Result],
        jobs: Sequence[Any],
        *shared: Any,
        stage: str = "",
        best: Callable[[list[Result]], Sequence[Leader]] | None = None,
    ) -> list[Result]:
        """Results of function(job, self, *shared) as `Work.map` gives them; fits that were made elsewhere are noted."""

        def told(done: list[tuple[Result, Notes]]) -> Sequence[Leader] | None:
            if self.noted is not None:
                self.noted.update(done[-1][1])
            return best([result for result, _ in done]) if best else None

        found = self.work.map(_with_notes, jobs, function, self, *shared, stage=stage, best=told)
        return [result for result, _ in found]

    def predict(self, model: Model) -> Array:
        """What a model predicts (n,) [N]."""
        return self.forward.predict(self, model)

    def predict_many(self, model: Model, vectors: Array) -> Array:
        """What a model predicts (m, n) [N] for m flat parameter vectors (m, n_parameters)."""
        if self.work.cancel is None:
            return self.forward.predict_many(self, model, vectors)
        rows, parts = max(cores(), AT_ONCE // self.motion.n), []
        for k in range(0, max(len(vectors), 1), rows):
            self.work.check()
            parts.append(self.forward.predict_many(self, model, vectors[k : k + rows]))
        return np.concatenate(parts)

    def near(self, model: Model, predicted: Array, longest: float = COARSE) -> Problem:
        """The problem near a model that predicts this (n,) [N]: predictions cost less, and are exact at the model.

        longest: step of the integrator [s].
        """
        return replace(self, forward=self.forward.near(self, model, predicted, longest))

    def begun(self, model: Model) -> Problem:
        """The problem where states begin about where they do with a model: predictions near it cost less.

        They are exact at the model.
        """
        forward = self.forward.begun(self, model)
        return self if forward is self.forward else replace(self, forward=forward)

    def predicted(self, model: Model) -> tuple[Array, Problem]:
        """What a model predicts (n,) [N], and the problem as `begun` there."""
        self.work.check()
        rows, forward = self.forward.predicted(self, model)
        return rows, self if forward is self.forward else replace(self, forward=forward)

    @property
    def parts(self) -> tuple[Problem, ...]:
        """One problem for each output, rows `c::outputs` of this one."""
        n = self.forward.outputs
        if n == 1:
            return (self,)
        return tuple(
            replace(
                self, force=self.force[c::n], fold=self.fold[c::n], held_out=self.held_out[c::n], forward=DAMPER,
                wild=self.wild_at(slice(c, None, n)),
            )
            for c in range(n)
        )  # fmt: skip

    @property
    def second(self) -> int:
        """Rows of a second."""
        return max(round(1.0 / self.motion.dt), 1) * self.forward.outputs

    @cached_property
    def told(self) -> Told:
        """What tells where the states of each record begin."""
        tells = telling(self.motion, self.train, self.held_out)
        weight = self.weight_of(tells if self.wild is None else tells & ~self.wild)
        return Told(self.force, weight, round(WARM_UP / self.motion.dt))

    def with_weight(self, residual: Array) -> Array:
        """What is left (n,) [N], and nothing at samples without weight: a spectrum takes no gaps."""
        return residual if self.wild is None else np.where(self.wild, 0.0, residual)

    def weight_of(self, mask: NDArray[np.bool_]) -> Array:
        """Weight (n,) [1/N2] of the samples of a mask, by the white noise of the force."""
        return mask / max(self.sd_force, LEAST_NOISE) ** 2

    @cached_property
    def learnt(self) -> tuple[tuple[int, int], ...]:
        """Rows (from, to) of the motion of each record that is learnt from, be it in part."""
        train = self.train[:: self.forward.outputs]
        return tuple((i, j) for i, j in pairwise(self.motion.starts.tolist()) if train[i:j].any())

    @cached_property
    def cycles(self) -> tuple[Cycle, ...]:
        """The cycle that each record learnt from repeats, of a damper; empty where one of them repeats none."""
        m = self.motion
        return cycles(m.v, m.dt, self.learnt) if self.forward.outputs == 1 else ()

    @property
    def rounded(self) -> bool:
        """Whether a record's motion was made without accelerations, which alone show where it bends."""
        return any(not c.has[2] for c in self.raw)

    @cached_property
    def practice(self) -> Practice | None:
        """Stretches on which fits begin where there are many runs, else None."""
        if type(self.forward) is not DamperForward:
            return None
        places = stretches_to_practise_on(self.motion, self.learnt)
        return None if places is None else Practice(self._along(places), np.concatenate(places))

    def _along(self, places: list[NDArray[np.intp]]) -> Problem:
        """The problem of stretches, rows (k,) each, laid end to end; the first samples of each are left out of the fit.

        In them unknown states fade.
        """
        m, rows = self.motion, np.concatenate(places)
        starts = np.concatenate([[0], np.cumsum([p.size for p in places])])
        signals = {name: getattr(m, name)[rows] for name in ("x", "v", "a", "u", "theta")}
        fold, folds = self.fold[rows], int(self.fold.max()) + 1
        for i in starts[:-1]:
            fold[i : i + round(WARM_UP / m.dt)] = -1
        inside = np.flatnonzero(fold >= 0)
        fold[inside] = np.arange(inside.size) * folds // inside.size
        return replace(
            self, motion=replace(m, starts=starts, **signals), force=self.force[rows], fold=fold,
            held_out=self.held_out[rows], raw=(), fused=(), forward=PartForward(self.scales),
            extra=tuple((name, y[rows]) for name, y in self.extra), wild=self.wild_at(rows),
        )  # fmt: skip

    @property
    def train(self) -> NDArray[np.bool_]:
        """Mask of the training samples."""
        return self.fold >= 0

    def wild_at(self, rows: slice | NDArray[np.int64]) -> NDArray[np.bool_] | None:
        """Mask of the samples without weight, of some rows; None where nobody looked for them."""
        return None if self.wild is None else self.wild[rows]

    def without(self, wild: NDArray[np.bool_] | None) -> Problem:
        """The problem with no weight on further samples (n,)."""
        if wild is None or not wild.any():
            return self
        all_wild = wild if self.wild is None else wild | self.wild
        fold, held_out = np.where(wild, -1, self.fold), self.held_out & ~wild
        return replace(self, fold=fold, held_out=held_out, wild=all_wild)

    @property
    def measures_velocity(self) -> bool:
        """Whether the velocity was measured in some record."""
        return any(c.has[1] for c in self.raw)

    @property
    def kinematic_lag(self) -> bool:
        """Whether deflection and accelerometers can show a lag of the velocity channel by themselves."""
        return any(c.shows_lag for c in self.raw)

    @property
    def used(self) -> NDArray[np.bool_]:
        """Mask of all scored samples."""
        return self.train | self.held_out

    @cached_property
    def scales(self) -> Scales:
        """Envelope of the data: robust peaks of force, deflection, velocity and duty."""
        m, known = self.motion, self.forward.scales()
        if known is not None:
            return known
        return Scales(peak(self.force), peak(m.x), peak(m.v), float(max(m.u.max(), 1e-3)))


def _with_notes(
    job: Any, function: Callable[..., Result], problem: Problem, *shared: Any
) -> tuple[Result, Notes]:
    """What a job gives, and the fits that were noted meanwhile."""
    before = set(problem.noted or ())
    result = function(job, problem, *shared)
    return result, {k: v for k, v in (problem.noted or {}).items() if k not in before}
