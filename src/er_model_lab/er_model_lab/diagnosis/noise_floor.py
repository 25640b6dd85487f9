"""What no model of these inputs could explain: the noise floor, from several sides.

A gradient-boosted regression on motion, duty, their recent past and slow quantities tries to predict
what a model leaves, judged on stretches it has not seen. What it explains some model could explain.
"""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING

import numpy as np
from er_models.model import Array
from er_models.seed import LARGEST
from numpy.typing import NDArray
from threadpoolctl import threadpool_limits

from er_model_lab.diagnosis.candidates import Candidate
from er_model_lab.diagnosis.leftover_structure import bursts, filtered
from er_model_lab.diagnosis.null import Null
from er_model_lab.filtering import fading
from er_model_lab.fitting.data_reach import within_learnt
from er_model_lab.fitting.fit import mean_square
from er_model_lab.motion.white_noise import white_noise
from er_model_lab.problem.problem import Problem
from er_model_lab.residual.spectral_lines import LEAST, longest, share_of, spectrum, stands_out

if TYPE_CHECKING:
    from sklearn.ensemble import HistGradientBoostingRegressor

MAX_SAMPLES = 5000
ENOUGH = 200
"""Held-out samples from which a floor is learnt."""
FEATURES = (
    "deflection", "velocity", "acceleration", "duty", "duty 20 ms ago", "duty 60 ms ago", "velocity 10 ms ago",
    "velocity 30 ms ago", "model force", "yield force lagged", "time", "dissipated power, slow",
    "deflection at last reversal", "duty change, recent", "deflection 50 ms ago",
)  # fmt: skip


@dataclass(frozen=True)
class Floor:
    """Noise floor [N] and its parts.

    floor: root of the smallest mean square left on unseen stretches; held_out: the same on the samples held
    out, which have motion of their own and so feel errors of its sensors differently, as far as they stay within what
    was learnt from; white: white force
    noise; input_error: from the sensors of the motion; explained: share of the residual that boosted trees
    or linear filters explain; importance: of each feature, by name; line: (frequency [Hz], amplitude [N],
    share) of the strongest spectral line; bursts: share that comes in bursts; parts: floors of the outputs,
    where there are several; measured: noise that a rest or a repeated motion shows, None where neither does; learnt:
    `floor` and `held_out` as trees and filters have it, where measured noise lies lower and counts instead.
    """

    floor: float
    held_out: float
    white: float
    input_error: float
    explained: float
    importance: dict[str, float]
    line: tuple[float, float, float]
    bursts: float = 0.0
    parts: tuple[Floor, ...] = ()
    measured: float | None = None
    learnt: tuple[float, float] | None = None

    @property
    def of_sensors(self) -> float:
        """White noise of the force and what the errors of the motion make of it, together [N]."""
        return float(np.hypot(self.white, self.input_error))

    @property
    def each(self) -> tuple[Floor, ...]:
        """The floor of every output: its parts, or itself where there is one output only."""
        return self.parts or (self,)

    @property
    def first(self) -> Floor:
        """The floor of the first output, the one whose errors are told in newtons."""
        return self.each[0]


def features(problem: Problem, force: Array) -> Array:
    """Inputs (n, features) of the regression, in the order of `FEATURES` and then of the problem's own."""
    m = problem.motion
    dt, u = m.dt, m.u

    def ago(y: Array, seconds: float) -> Array:
        k = max(round(seconds / dt), 1)
        return np.concatenate([np.full(k, y[0]), y[:-k]])

    def slow(y: Array, seconds: float) -> Array:
        c = np.exp(-dt / seconds)
        return fading((1.0 - c) * y, c)

    reversal = np.zeros(m.n)
    turns = np.flatnonzero(np.diff(np.sign(m.v)) != 0)
    if turns.size:
        place = np.searchsorted(turns, np.arange(m.n)) - 1
        reversal = np.where(place >= 0, m.x[turns[np.maximum(place, 0)]], m.x[0])
    gate = slow(u * np.sign(m.v), 0.03)
    columns = [
        m.x, m.v, m.a, u, ago(u, 0.02), ago(u, 0.06), ago(m.v, 0.01), ago(m.v, 0.03), force, gate, m.t,
        slow(np.abs(force * m.v), 15.0), reversal, u - slow(u, 0.05), ago(m.x, 0.05),
    ]  # fmt: skip
    return np.stack([*columns, *(y for _, y in problem.extra)], axis=1)


def _trees(seed: int) -> HistGradientBoostingRegressor:
    """The regression: small trees, many samples a leaf, so that noise is not learnt."""
    from sklearn.ensemble import (
        HistGradientBoostingRegressor,
    )  # half a second, and many a command fits no trees

    return HistGradientBoostingRegressor(
        max_iter=80,
        learning_rate=0.08,
        max_leaf_nodes=12,
        min_samples_leaf=30,
        l2_regularization=1.0,
        random_state=seed % (LARGEST + 1),
    )


def _rows(mask: NDArray[np.bool_]) -> NDArray[np.intp]:
    """Places of a mask, thinned to what the regression needs."""
    rows = np.flatnonzero(mask)
    return rows[:: max(1, rows.size // MAX_SAMPLES)]


def _fourths(problem: Problem, rows: NDArray[np.intp]) -> NDArray[np.intp]:
    """Which of four groups each row is in: whole seconds in turn; of data too short for that, one after the other."""
    seconds = (rows // max(round(1.0 / problem.motion.dt), 1)) % 4
    return seconds if np.unique(seconds).size == 4 else np.arange(rows.size) * 4 // rows.size


def boosted(problem: Problem, residual: Array, inputs: Array, seed: int) -> float:
    """Share of the training residual that is explained on unseen stretches."""
    rows = _rows(problem.train)
    target = residual[rows]
    groups = _fourths(problem, rows)
    out = np.zeros(rows.size)
    for k in range(4):
        problem.work.check()
        train = groups != k
        trees = _trees(seed).fit(inputs[rows[train]], target[train])
        out[~train] = trees.predict(inputs[rows[~train]])
    return 1.0 - float(np.mean((target - out) ** 2) / max(float(np.mean(target**2)), 1e-300))


def boosted_held_out(
    problem: Problem, scored: NDArray[np.bool_], residual: Array, inputs: Array, seed: int
) -> float:
    """Share of the residual of scored samples (n,) that a regression on the training residual explains."""
    rows, unseen = _rows(problem.train), _rows(scored)
    out = _trees(seed).fit(inputs[rows], residual[rows]).predict(inputs[unseen])
    target = residual[unseen]
    return 1.0 - float(np.mean((target - out) ** 2) / max(float(np.mean(target**2)), 1e-300))


def _scored(problem: Problem) -> NDArray[np.bool_]:
    """Held-out samples (n,) of which trees can know: those within what was learnt from, where they are enough."""
    within = within_learnt(problem)
    return within if within.sum() >= ENOUGH else problem.held_out


def importance(problem: Problem, residual: Array, inputs: Array, seed: int) -> dict[str, float]:
    """Which inputs the unexplained part depends on: loss of explained variance when one is shuffled."""
    rows = _rows(problem.train)
    test = _fourths(problem, rows) == 0
    known, target = inputs[rows[test]], residual[rows[test]]
    trees = _trees(seed).fit(inputs[rows[~test]], residual[rows[~test]])
    rng = np.random.default_rng(seed)
    base = float(np.mean((target - trees.predict(known)) ** 2))
    out = {}
    for i, name in enumerate((*FEATURES, *(name for name, _ in problem.extra))):
        shuffled = known.copy()
        shuffled[:, i] = rng.permutation(shuffled[:, i])
        worse = float(np.mean((target - trees.predict(shuffled)) ** 2))
        out[name] = (worse - base) / max(float(np.mean(target**2)), 1e-300)
    return dict(sorted(out.items(), key=lambda kv: -kv[1]))


def spectral_line(problem: Problem, residual: Array) -> tuple[float, float, float]:
    """Frequency, amplitude and share of variance of the strongest line, if it stands out; else zeros."""
    y = problem.with_weight(residual)[longest(problem)]
    if y.size < LEAST:
        return 0.0, 0.0, 0.0
    power = spectrum(y)
    peak = int(np.argmax(power[2:])) + 2
    if not stands_out(power, power, peak):
        return 0.0, 0.0, 0.0
    share = share_of(power, power, peak)
    frequency = peak / (y.size * problem.motion.dt)
    return float(frequency), float(np.sqrt(2.0 * share * np.var(y))), share


def noise_floor(problem: Problem, best: Candidate, null: Null, seed: int) -> Floor:
    """Floor under the best model found so far; of several outputs, that of their mean square."""
    n = problem.forward.outputs
    floors = tuple(problem.each(_floor_of, range(n), best, null, seed, stage="the noise floor"))
    return floors[0] if n == 1 else _together(floors, best.mse)


def bounded(floor: Floor, tried: list[Candidate], problem: Problem) -> Floor:
    """The floor on held-out data, which is no higher than what one of the models that were tried leaves of them.

    Of several outputs it stays as it is.
    """
    if problem.forward.outputs > 1 or not tried:
        return floor
    scored = _scored(problem)
    if scored.sum() < ENOUGH:
        return floor
    least = min(mean_square(c.fit.residual[scored]) for c in tried)
    return replace(floor, held_out=min(floor.held_out, float(np.sqrt(least))))


def _floor_of(output: int, problem: Problem, best: Candidate, null: Null, seed: int) -> Floor:
    """Floor of one output."""
    n = problem.forward.outputs
    left, in_fit = best.residual[output::n], best.fit.residual[output::n]
    return _floor(problem.parts[output], left, in_fit, null, output, seed)


def _floor(
    problem: Problem, residual: Array, in_fit: Array, null: Null, output: int, seed: int
) -> Floor:
    """Floor of one output, from its residual without each sample's block and from that of the fit.

    The trees are small: on one thread they are as fast as on two, and do not wait for busy cores. Only the threads of
    what is loaded can be limited.
    """
    import sklearn.ensemble  # noqa: F401

    inputs, scored = features(problem, problem.force - in_fit), _scored(problem)
    share, unseen, weights = filtered(problem, residual, in_fit)
    with threadpool_limits(1, "openmp"):
        trees = boosted(problem, residual, inputs, seed)
        if trees > max(share, 0.03):
            weights = importance(problem, residual, inputs, seed)
        unseen = max(boosted_held_out(problem, scored, in_fit, inputs, seed), unseen, 0.0)
    share = max(trees, share, 0.0)
    square = null.input_square[output :: null.outputs]
    loud = bursts(problem, residual, square, null.bursts[output])
    starts = problem.motion.starts
    white = white_noise([in_fit[i:j] for i, j in itertools.pairwise(starts)])
    held = float(np.mean(in_fit[scored] ** 2))
    left = float(np.mean(residual[problem.train] ** 2))
    return Floor(
        floor=float(np.sqrt(left * (1.0 - share) * (1.0 - loud))),
        held_out=float(np.sqrt(held * (1.0 - unseen))),
        white=white,
        input_error=null.input_error,
        explained=share,
        importance=weights if share > 0.03 else {},
        line=spectral_line(problem, residual),
        bursts=loud,
    )


def _together(floors: tuple[Floor, ...], mse: float) -> Floor:
    """One floor of several outputs, each with its share of the mean square error [N2]."""
    low = np.array([f.floor**2 for f in floors])
    error = low / np.maximum(1.0 - np.array([f.explained for f in floors]), 1e-9)
    shares = error / error.sum()
    importance: dict[str, float] = {}
    for share, f in zip(shares, floors, strict=True):
        for name, weight in f.importance.items():
            importance[name] = importance.get(name, 0.0) + float(share) * weight
    frequency, amplitude, _ = max((f.line for f in floors), key=lambda line: line[2])
    line = max(float(s) * f.line[2] for s, f in zip(shares, floors, strict=True))
    return Floor(
        floor=float(np.sqrt(low.mean())),
        held_out=float(np.sqrt(np.mean([f.held_out**2 for f in floors]))),
        white=floors[0].white,
        input_error=floors[0].input_error,
        explained=max(1.0 - float(low.mean()) / mse, 0.0),
        importance=dict(sorted(importance.items(), key=lambda kv: -kv[1])),
        line=(frequency, amplitude, line),
        bursts=float(sum(s * f.bursts for s, f in zip(shares, floors, strict=True))),
        parts=floors,
    )
