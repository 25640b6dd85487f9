"""Every effect of the catalogue, refitted together with the model, and what it gains on data left out.

Screening only chooses where the refit starts. It never ranks: the direction most correlated with the
residual is often an impostor.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Iterable, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from er_models.effect import SMOOTH, Effect
from er_models.model import Array, Model

from er_model_lab.fit import Fit, cross_validated, fit
from er_model_lab.forward import free_parameters
from er_model_lab.prepare import Problem

FOREIGN = 0.25
"""Share of the force left unexplained above which a model's own values are taken to be another damper's."""
MOST_RESTARTS = 16
FIRST_ITERATIONS, FINALISTS = 10, 4
"""Iterations every candidate gets, and how many of the best are then fitted to the end."""


SCANNED, SCANS, WORTHWHILE = 25, 3, 0.01
"""Values of a limit of the car that are looked at, how often, and the gain that is worth another look."""
ABOUT = np.geomspace(0.6, 1.6, 7)
"""Sizes about a fitted gap, as shares of it, that are looked at."""
GAPS, NARROWEST, WIDEST = 9, 0.1, 3.0
"""Gaps that are looked at, and the first and the last of them as shares of the least and the largest start."""


@dataclass(frozen=True)
class Candidate:
    """One effect added to the model and refitted.

    residual (n,): predicted without each sample's block; losses (folds,): mean square per block; mse: of
    all blocks; seen: mean square of the fit itself;
    kept: share of the effect's direction that the model cannot absorb; reach: size of the change
    it makes at its start value over the white noise.
    """

    effects: tuple[str, ...]
    fit: Fit
    residual: Array
    losses: Array
    mse: float
    seen: float
    kept: float
    reach: float

    @property
    def name(self) -> str:
        """The effect added last."""
        return self.effects[-1]


def baseline(model: Model, problem: Problem) -> Candidate:
    """The model as it is, refitted; from several starts when its own values are far from the data."""
    fitted = fit(model, problem)
    size = float(np.std(problem.force[problem.train]))
    if np.sqrt(fitted.mse(problem.train)) > FOREIGN * size:
        others = [fit(other, problem) for other in restarts(model, problem)]
        fitted = min([fitted, *others], key=lambda f: f.mse(problem.train))
    return cross_judged((), fitted, problem)


def restarts(model: Model, problem: Problem) -> list[Model]:
    """The model with the starting values of its terms, scaled to the data: for a damper of another size."""
    grids = {
        name: starts(model.catalogue[name], problem)
        for name in dict.fromkeys(effect for effect, _ in free_parameters(model))
    }
    combinations = itertools.islice(itertools.product(*grids.values()), MOST_RESTARTS)
    return [
        replace(model, effects={**model.effects, **dict(zip(grids, values, strict=True))})
        for values in combinations
    ]


def missing(model: Model, problem: Problem) -> tuple[Effect, ...]:
    """Effects that could be added: all candidates of the catalogue the model does not hold.

    Where the motion sensors themselves show a lag of the velocity channel, the force must not be asked:
    a lag of the fused velocity would only imitate its noise.
    """
    core = () if model.has_response else (model.catalogue["response"],)
    held = {*model.effects, "velocity_lag"} if problem.kinematic_lag else set(model.effects)
    return tuple(e for e in core + problem.forward.candidates(model) if e.name not in held)


def starts(effect: Effect, problem: Problem) -> list[dict[str, float]]:
    """Combinations of starting values of an effect [SI], at most eight."""
    scales = problem.scales
    grids = [[s * scales.of(q.unit) for s in q.starts] for q in effect.parameters]
    points = list(itertools.islice(itertools.product(*grids), 8))
    return [dict(zip(effect.names, point, strict=True)) for point in points]


def _amplitudes(effect: Effect) -> list[int]:
    """Places of the parameters that switch the effect on: those with a finite neutral value."""
    return [
        i
        for i, q in enumerate(effect.parameters)
        if q.neutral is not None and np.isfinite(q.neutral)
    ]


def additions(
    base: Candidate, effect: Effect, points: list[dict[str, float]], problem: Problem
) -> Array:
    """What an effect adds to the prediction of a fitted model (n, k) with each of these values."""
    model = base.fit.model
    grown = model.with_effect(effect.name, points[0])
    offset = model.catalogue.offsets[effect.name]
    vectors = np.tile(grown.compiled().p, (len(points), 1))
    for row, point in zip(vectors, points, strict=True):
        row[offset : offset + len(effect.names)] = [point[n] for n in effect.names]
    predicted = problem.force - base.fit.residual
    return np.asarray(np.nan_to_num(problem.predict_many(grown, vectors) - predicted).T)


@dataclass(frozen=True)
class Screen:
    """What a straight line says of an effect: starting values, most promising first; kept and reach as in `Candidate`.

    gain: root of the fall of the mean square from the best start [N].
    """

    points: list[dict[str, float]]
    kept: float
    reach: float
    gain: float


def screen(base: Candidate, effect: Effect, problem: Problem) -> Screen:
    """An effect beside a fitted model, in a straight line.

    Where amplitudes switch the effect on, a start promises what it gains once they are scaled; where none
    does (a limit whose neutral value is infinite), what it gains as it is.
    """
    train, points = problem.train, gaps(effect, problem) or starts(effect, problem)
    switched = bool(_amplitudes(effect)) and not is_gap(effect)
    directions = additions(base, effect, points, problem)[train]
    j, r = base.fit.jacobian[train], base.fit.residual[train]
    absorbed = j @ np.linalg.lstsq(j, directions, rcond=1e-10)[0]
    outside = directions - absorbed
    power = np.sum(outside**2, axis=0)
    size = np.sum(directions**2, axis=0)
    along = outside.T @ r
    seen = power > 1e-12 * np.maximum(size, 1e-300)
    amplitudes = np.where(seen, along / np.maximum(power, 1e-300), 0.0)
    if not switched:
        amplitudes = np.where(seen, 1.0, 0.0)
    gains = 2.0 * amplitudes * along - amplitudes**2 * power
    kept = float(np.sqrt(np.max(power / np.maximum(size, 1e-300))))
    reach = float(np.sqrt(np.max(power) / train.sum()) / max(problem.sd_force, 1e-12))
    ranked = [
        _scaled(points[k], effect, float(amplitudes[k]), problem) if switched else points[k]
        for k in np.argsort(-gains, kind="stable")
    ]
    gain = float(np.sqrt(max(float(gains.max()), 0.0) / train.sum()))
    return Screen(ranked, kept, reach, gain)


def is_limit(effect: Effect) -> bool:
    """Whether one value of the car says from where on something is cut off."""
    return effect.stage == "vehicle" and len(effect.parameters) == 1 and not _amplitudes(effect)


def is_gap(effect: Effect) -> bool:
    """Whether the first parameter is a gap: below it nothing is felt, and each one has a valley of its own."""
    q = effect.parameters[0]
    return effect.stage != "vehicle" and q.unit == "m" and q.neutral == 0.0 and q.step > SMOOTH


def gaps(effect: Effect, problem: Problem) -> list[dict[str, float]]:
    """Starting values of an effect over many sizes of its gap; empty where it has none.

    What a gap does grows neither in a straight line with it nor smoothly, so that a start far off stays there.
    """
    if not is_gap(effect):
        return []
    q, *_ = effect.parameters
    sizes = np.geomspace(NARROWEST * min(q.starts), WIDEST * max(q.starts), GAPS)
    others = {tuple((k, v) for k, v in p.items() if k != q.name) for p in starts(effect, problem)}
    scale = problem.scales.of(q.unit)
    return [{q.name: float(s * scale), **dict(rest)} for s in sizes for rest in sorted(others)]


def profiled(fitted: Fit, name: str, problem: Problem) -> Fit:
    """A model fitted with a gap, from the best of sizes about it while all else follows in a straight line.

    Ever closer to it: derivatives by the gap say little beyond the nearest contact.
    """
    q, train, best = fitted.model.catalogue[name].parameters[0].name, problem.train, fitted
    place = fitted.free.index((name, q))
    for closer in range(SCANS):
        values = best.model.effects[name]
        sizes = values[q] * ABOUT ** (2.0**-closer)
        grown, left = _left_over(
            best.model, name, [{**values, q: float(s)} for s in sizes], problem
        )
        left = left.T
        j = np.delete(best.jacobian[train], place, axis=1)
        left = np.nan_to_num(left) - j @ np.linalg.lstsq(j, np.nan_to_num(left), rcond=1e-10)[0]
        costs = np.mean(left**2, axis=0)
        if costs.min() < (1.0 - WORTHWHILE) * best.mse(train):
            tried = fit(grown[int(np.argmin(costs))], problem, max_iter=FIRST_ITERATIONS)
            best = tried if tried.mse(train) < best.mse(train) else best
    return best


def scanned(fitted: Fit, effect: Effect, problem: Problem) -> Fit:
    """A model fitted with a limit, each time from the best of many values of it, as long as that helps.

    A limit has one narrow valley, for what it cuts off at one peak decides where the next ones are; and where the
    valley lies depends on what was fitted without it.
    """
    (q,) = effect.parameters
    values = problem.scales.of(q.unit) * np.geomspace(min(q.starts), max(q.starts), SCANNED)
    model, best = fitted.model, fitted
    for _ in range(SCANS):
        grown, left = _left_over(model, effect.name, [{q.name: float(v)} for v in values], problem)
        cost = np.nan_to_num(np.mean(left**2, axis=1), nan=np.inf)
        tried = fit(grown[int(np.argmin(cost))], problem, max_iter=FIRST_ITERATIONS)
        if not tried.mse(problem.train) < (1.0 - WORTHWHILE) * best.mse(problem.train):
            break
        model, best = tried.model, tried
    return best


def _left_over(
    model: Model, name: str, values: Sequence[Mapping[str, float]], problem: Problem
) -> tuple[list[Model], Array]:
    """The model with each of the values (k) of an effect, and what it leaves of the force where it is fitted (k, m)."""
    grown = [model.with_effect(name, each) for each in values]
    vectors = np.stack([m.compiled().p for m in grown])
    return grown, (problem.force - problem.predict_many(grown[0], vectors))[:, problem.train]


def _scaled(
    point: dict[str, float], effect: Effect, amplitude: float, problem: Problem
) -> dict[str, float]:
    """Start with its amplitudes moved towards the size that fits the residual in a straight line."""
    out = dict(point)
    factor = float(np.clip(amplitude, -3.0, 3.0))
    for i in _amplitudes(effect):
        q = effect.parameters[i]
        scale, neutral = problem.scales.of(q.unit), q.neutral or 0.0
        value = neutral * scale + factor * (point[q.name] - neutral * scale)
        low, high = q.low * scale, q.high * scale
        inside = min(max(value, low), high)
        out[q.name] = point[q.name] if inside in (low, high) else inside
    return out


def refit(
    base: Candidate, effect: Effect, problem: Problem, *, max_iter: int = FIRST_ITERATIONS
) -> Candidate:
    """Add one effect to a fitted model, refit everything, and cross-validate.

    Where no amplitude switches the effect on, a straight line promises little: the two best starts are tried.
    """
    seen = screen(base, effect, problem)
    target = base.fit.mse(problem.train) * problem.forward.worth

    def begun(values: dict[str, float]) -> Fit:
        grown = base.fit.model.with_effect(effect.name, values)
        return fit(grown, problem, known=base.fit.jacobian, target=target, max_iter=max_iter)

    fits = [begun(values) for values in seen.points[: 1 if _amplitudes(effect) else 2]]
    fits = [f for f in fits if np.isfinite(f.mse(problem.train))]
    fits = fits or [begun(starts(effect, problem)[0])]
    fitted = min(fits, key=lambda f: f.mse(problem.train))
    if is_limit(effect):
        fitted = scanned(fitted, effect, problem)
    return cross_judged((*base.effects, effect.name), fitted, problem, seen.kept, seen.reach)


def finished(candidate: Candidate, problem: Problem, max_iter: int = 30) -> Candidate:
    """A candidate fitted on where its iterations were used up, and with its gaps looked for more closely."""
    fitted = candidate.fit
    if fitted.iterations >= FIRST_ITERATIONS:
        fitted = fit(fitted.model, problem, max_iter=max_iter)
    for name in candidate.effects:
        if is_gap(fitted.model.catalogue[name]):
            fitted = profiled(fitted, name, problem)
    if not fitted.mse(problem.train) < candidate.fit.mse(problem.train):
        return candidate
    return cross_judged(candidate.effects, fitted, problem, candidate.kept, candidate.reach)


def cross_judged(
    effects: tuple[str, ...],
    fitted: Fit,
    problem: Problem,
    kept: float = 1.0,
    reach: float = np.inf,
) -> Candidate:
    """A fitted model with its cross-validation."""
    residual, losses = cross_validated(fitted, problem)
    mse = float(np.mean(residual[problem.train] ** 2))
    seen = fitted.mse(problem.train)
    return Candidate(effects, fitted, residual, losses, mse, seen, kept, reach)


def refit_all(
    base: Candidate,
    problem: Problem,
    effects: Iterable[Effect] | None = None,
    tick: Callable[[str], None] | None = None,
) -> list[Candidate]:
    """Every missing effect refitted, best held-out error first; the best few are fitted to the end."""
    found = []
    for effect in effects if effects is not None else missing(base.fit.model, problem):
        found.append(refit(base, effect, problem))
        if tick:
            tick(effect.name)
    found.sort(key=lambda c: c.mse)
    ahead = [finished(c, problem) for c in found[:FINALISTS]]
    return sorted([*ahead, *found[FINALISTS:]], key=lambda c: c.mse)


def effect_size(base: Candidate, candidate: Candidate) -> float:
    """Root of the fall of the mean squared error on left-out data [N]; negative where it rises.

    No more than the fit itself gains: what goes beyond is what a straight line makes of leaving a block out.
    """
    fall = min(base.mse - candidate.mse, base.seen - candidate.seen)
    return float(np.sign(fall) * np.sqrt(abs(fall)))


def without(candidate: Candidate, name: str, problem: Problem) -> Candidate:
    """A fitted model with one of its added effects taken out again and refitted."""
    fitted = fit(candidate.fit.model.without_effect(name), problem)
    kept = tuple(e for e in candidate.effects if e != name)
    return cross_judged(kept, fitted, problem)
