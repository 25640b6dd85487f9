"""Every effect of the catalogue, refitted together with the model, and what it gains on data left out.

Screening only chooses where the refit starts. It never ranks: the direction most correlated with the
residual is often an impostor.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from er_models.effect import Effect, arguments
from er_models.model import Array, Model
from er_models.prediction import motion, predict

from er_model_lab.diagnosis.restarts import awakened, handed_over, restarts, terms
from er_model_lab.diagnosis.size_scan import profiled, scanned
from er_model_lab.diagnosis.starts import (
    amplitudes,
    gaps,
    is_gap,
    is_limit,
    of_each_form,
    scaled,
    starts,
)
from er_model_lab.fitting.cross_validation import cross_validated
from er_model_lab.fitting.fit import (
    FIRST_ITERATIONS,
    LOOKS,
    Fit,
    about,
    fit,
    mean_square,
    part_of,
    practised,
    settled,
)
from er_model_lab.problem.forward import COARSE, ROUGH
from er_model_lab.problem.problem import Practice, Problem

Values = Mapping[str, float]
"""Values of an effect by name [SI]."""
FOREIGN = 0.25
"""Share of the force left unexplained above which a model's own values are taken to be another damper's."""
A_LOOK = 4
"""Iterations that every candidate gets, of many runs on stretches of them; those that may win go on."""
STARTS, UNSCALED = 3, 2
"""From how many starts an effect is fitted that may win, and every one to stretches: what promises most in a straight
line may lead astray. And from how many at least where no amplitude switches it on, so that a line promises little."""
GLANCE, GO_ON, LOST = 1, 3, 2.0
"""Iterations that each model gets in which another effect hands its play over, how many of them go on, and the multiple
of the error before from which on none does."""
BEYOND = 1e6
"""Change of a prediction, over the largest force, from which on it has lost all measure."""
HOPE = 1.2
"""Mean square, over a target, up to which a sketch, or a fit to stretches, may still reach it in the end."""
NOTHING = 1e-6
"""Mean square that a straight line gains, over what is left, below which an effect changes nothing."""


@dataclass(frozen=True)
class Candidate:
    """One effect added to the model and refitted.

    residual (n,): predicted without each sample's block; losses (folds,): mean square per block; mse: of
    all blocks; seen: mean square of the fit itself;
    kept: share of the effect's direction that the model cannot absorb; reach: size of the change
    it makes at its start value over the white noise; ranked: whether it was fitted to stretches of many runs, in
    longer steps of the integrator, to be ranked only.
    """

    effects: tuple[str, ...]
    fit: Fit
    residual: Array
    losses: Array
    mse: float
    seen: float
    kept: float
    reach: float
    ranked: bool = False

    @property
    def left(self) -> float:
        """Mean square that it leaves [N2]: no less than the fit itself does.

        Less is what a straight line makes of leaving a block out, and of a fit that ended in a valley of its own.
        """
        return max(self.mse, self.seen)

    @property
    def name(self) -> str:
        """The effect added last."""
        return self.effects[-1]


def baseline(model: Model, problem: Problem) -> Candidate:
    """The model as it is, refitted; from several starts when its own values are far from the data."""
    few = problem.practice
    where = few.problem if few else problem
    fitted = fit(model, where, sketch=bool(few))
    size = float(np.std(where.force[where.train]))
    if np.sqrt(fitted.mse(where.train)) > FOREIGN * size:
        others = where.each(fit, restarts(model, problem, terms(model)), stage="other starts")
        fitted = min([fitted, *others], key=lambda f: f.mse(where.train))
    return cross_judged((), fit(fitted.model, problem, looks=LOOKS) if few else fitted, problem)


def missing(model: Model, problem: Problem) -> tuple[Effect, ...]:
    """Effects that could be added: all candidates of the catalogue the model does not hold.

    Where the motion sensors themselves show a lag of the velocity channel, the force must not be asked:
    a lag of the fused velocity would only imitate its noise. Where no velocity was measured none can lag. What follows
    a measured temperature is tried where one was measured.
    """
    core = () if model.has_response else (model.catalogue["response"],)
    from_force = (problem.measures_velocity or not problem.raw) and not problem.kinematic_lag
    held = set(model.effects) if from_force else {*model.effects, "velocity_lag"}
    warmed = bool(np.ptp(problem.motion.theta))
    tried = core + problem.forward.candidates(model)
    return tuple(e for e in tried if e.name not in held and (warmed or not _follows_warmth(e)))


def _follows_warmth(effect: Effect) -> bool:
    """Whether an effect reads the measured temperature."""
    return any("theta" in arguments(hook) for hook in effect.hooks.values())


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
    predicted, problem = problem.force - base.fit.residual, about(base.fit, problem)
    most = BEYOND * float(np.abs(problem.force).max())
    added = np.nan_to_num(problem.predict_many(grown, vectors) - predicted)
    return np.asarray(np.clip(added, -most, most).T)


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
    switched = bool(amplitudes(effect)) and not is_gap(effect)
    directions = additions(base, effect, points, problem)[train]
    j, r = base.fit.jacobian[train], base.fit.residual[train]
    absorbed = j @ np.linalg.lstsq(j, directions, rcond=1e-10)[0]
    outside = directions - absorbed
    power = np.sum(outside**2, axis=0)
    size = np.sum(directions**2, axis=0)
    along = outside.T @ r
    seen = power > 1e-12 * np.maximum(size, 1e-300)
    factors = np.where(seen, along / np.maximum(power, 1e-300), 0.0)
    if not switched:
        factors = np.where(seen, 1.0, 0.0)
    gains = 2.0 * factors * along - factors**2 * power
    kept = float(np.sqrt(np.max(power / np.maximum(size, 1e-300))))
    reach = float(np.sqrt(np.max(power) / train.sum()) / max(problem.sd_force, 1e-12))
    ranked = [
        scaled(points[k], effect, float(factors[k]), problem) if switched else points[k]
        for k in np.argsort(-gains, kind="stable")
    ]
    gain = float(np.sqrt(max(float(gains.max()), 0.0) / train.sum()))
    return Screen(ranked, kept, reach, gain)


def refit(
    base: Candidate, effect: Effect, problem: Problem, *, max_iter: int = FIRST_ITERATIONS, target: float = np.inf
) -> Candidate:  # fmt: skip
    """Add one effect to a fitted model, refit everything, and cross-validate; of many runs on stretches first.

    target: mean square [N2] that a sketch of the fit must promise; else it is judged where that has led.
    """
    few = problem.practice
    part, here, longest = (
        (on_part(base, few), few.problem, ROUGH) if few else (base, problem, COARSE)
    )
    near = about(part.fit, here.begun(part.fit.model), longest)
    begun, seen = sketched(part, effect, near, max_iter, STARTS if few else 1)
    hopeless = base.seen * begun.mse(here.train) > HOPE * target * part.fit.mse(here.train)
    if few:
        fitted = on_all(base, begun, about(base.fit, problem, ROUGH), 0 if hopeless else max_iter)
        fitted = fitted if hopeless else settled(fitted, problem)
    else:
        idle = hopeless or not begun.iterations
        fitted = gone_on_here(base, begun, seen, problem, 0 if idle else max_iter)
    names, ranked = (*base.effects, effect.name), hopeless or few is not None
    found = cross_judged(names, fitted, problem, seen.kept, seen.reach, straight=hopeless)
    return replace(found, ranked=ranked)


def on_part(whole: Candidate, few: Practice) -> Candidate:
    """A fitted model on the stretches to practise on."""
    return replace(whole, fit=part_of(whole.fit, few))


def on_all(base: Candidate, begun: Fit, problem: Problem, max_iter: int) -> Fit:
    """A fit to stretches, fitted further to all runs; base: the model on all runs before it grew.

    It begins as the stretches have it, or with their values of the effect alone beside the base, where that leaves less
    of all runs: what else the stretches moved may fit them only.
    """
    beside = base.fit.model
    for name in begun.model.effects.keys() - beside.effects.keys():
        beside = beside.with_effect(name, begun.model.effects[name])
    left = [
        mean_square((problem.force - problem.predict(m))[problem.train])
        for m in (begun.model, beside)
    ]
    start = beside if left[1] < left[0] else begun.model
    return fit(start, problem, known=base.fit.jacobian, max_iter=max_iter)


def gone_on_here(
    base: Candidate, begun: Fit, seen: Screen, problem: Problem, max_iter: int
) -> Fit:
    """A sketch of a fit, fitted further; without iterations with the derivatives that the base has.

    A gap has a valley at each size: it is fitted from its start without a sketch as well.
    """
    if not max_iter:
        return fit(begun.model, problem, known=base.fit.jacobian, max_iter=0)
    before, known = base.fit.model, base.fit.jacobian
    fits = [fit(begun.model, problem, max_iter=max_iter, looks=LOOKS)]
    for name in begun.model.effects.keys() - before.effects.keys():
        if is_gap(begun.model.catalogue[name]):
            grown = before.with_effect(name, seen.points[0])
            fits.append(fit(grown, problem, known=known, max_iter=max_iter, looks=LOOKS))
    return min(fits, key=lambda f: f.mse(problem.train))


def sketched(
    base: Candidate, effect: Effect, problem: Problem, max_iter: int, usual: int, also: Sequence[Values] = ()
) -> tuple[Fit, Screen]:  # fmt: skip
    """A sketch of a fitted model with one effect more, everything refitted, and what a straight line said of it.

    What changes nothing (a law of the duty where there is none) is not fitted. usual: how many starts that the line
    says are tried, only one where there are others: also.
    """
    seen = screen(base, effect, problem)
    left = base.fit.mse(problem.train)
    target = left * problem.forward.worth
    if seen.gain**2 < NOTHING * left and amplitudes(effect) and not is_gap(effect):
        max_iter = 0

    def begun(grown: Model, known: Array | None = base.fit.jacobian, most: int = max_iter) -> Fit:
        return fit(
            grown, problem, known=known, target=target, max_iter=most, sketch=True, looks=LOOKS
        )

    def grown(values: Values) -> Model:
        return base.fit.model.with_effect(effect.name, values)

    usual = usual if amplitudes(effect) else max(usual, UNSCALED)
    first = seen.points[: 1 if also else usual]
    others = [p for p in of_each_form(effect, seen.points) if p not in first]
    fits = [begun(grown(values)) for values in (*also, *first, *others)]
    # beside what was there when the effect was tried before, no play is handed over again
    models = handed_over(base.fit.model, effect, problem, base.effects[-1:] if also else None)
    looks = [begun(m, None, GLANCE) for m in models]
    near = [f for f in looks if f.mse(problem.train) < LOST**2 * left]
    hopeful = sorted(near, key=lambda f: f.mse(problem.train))[:GO_ON]
    fits += [begun(f.model, None) for f in hopeful]
    fits = [f for f in fits if np.isfinite(f.mse(problem.train))]
    fits = fits or [begun(grown(starts(effect, problem)[0]))]
    fitted = min(fits, key=lambda f: f.mse(problem.train))
    return (scanned(fitted, effect, problem) if is_limit(effect) else fitted), seen


def finished(candidate: Candidate, problem: Problem, max_iter: int = 30) -> Candidate:
    """A candidate fitted on where its iterations were used up, and with its gaps looked for more closely.

    So is one that was only ranked.
    """
    fitted = candidate.fit
    if candidate.ranked or fitted.iterations >= FIRST_ITERATIONS:
        fitted = fit(fitted.model, problem, max_iter=max_iter, looks=LOOKS)
    fitted = _looked_closer(fitted, candidate, problem, max_iter)
    better = fitted.mse(problem.train) < candidate.fit.mse(problem.train)
    if not (better or candidate.ranked):
        return candidate
    return cross_judged(candidate.effects, fitted, problem, candidate.kept, candidate.reach)


def _looked_closer(fitted: Fit, candidate: Candidate, problem: Problem, max_iter: int = 30) -> Fit:
    """A fit of a candidate, or a better one with what sleeps begun anew, and with its gaps looked for more closely."""
    fitted = awakened(fitted, problem, A_LOOK, max_iter)
    for name in candidate.effects:
        if is_gap(fitted.model.catalogue[name]):
            fitted = profiled(fitted, name, problem)
    return fitted


def chosen_among(candidate: Candidate, problem: Problem) -> Candidate:
    """A candidate fitted as far as a choice among several needs.

    One that was only ranked is seen in the usual steps of the integrator, and stays one to be fitted on.
    """
    if not candidate.ranked:
        return finished(candidate, problem)
    begun = settled(candidate.fit, problem)
    fitted = _looked_closer(begun, candidate, problem)
    found = cross_judged(candidate.effects, fitted, problem, candidate.kept, candidate.reach)
    return replace(found, ranked=fitted is begun)


def cross_judged(
    effects: tuple[str, ...],
    fitted: Fit,
    problem: Problem,
    kept: float = 1.0,
    reach: float = np.inf,
    *,
    straight: bool = False,
) -> Candidate:
    """A fitted model with its cross-validation, where `straight` in a straight line whatever that is worth."""
    residual, losses = cross_validated(fitted, problem, straight=straight)
    mse = mean_square(residual[problem.train])
    seen = fitted.mse(problem.train)
    return Candidate(effects, fitted, residual, losses, mse, seen, kept, reach)


def predicted(found: list[Candidate]) -> list[Candidate]:
    """Those whose prediction is a number: a free joint before a negative damping runs away, whatever its values."""
    return [c for c in found if np.isfinite(c.mse)] or found


def to_the_end(which: int, problem: Problem, candidates: list[Candidate]) -> Candidate:
    """One of some candidates, `finished`."""
    return finished(candidates[which], problem)


def for_a_choice(which: int, problem: Problem, candidates: list[Candidate]) -> Candidate:
    """One of some candidates, fitted as far as `chosen_among` them."""
    return chosen_among(candidates[which], problem)


def made_ready(model: Model) -> None:
    """Have in this process what fits of a model need: the compiled kernel takes a second to load."""
    still = np.zeros(2)
    predict(model, motion(1e-3, still, still, still))


def effect_size(base: Candidate, candidate: Candidate) -> float:
    """Root of the fall of the mean squared error on left-out data [N]; negative where it rises.

    No more than the fit itself gains: what goes beyond is what a straight line makes of leaving a block out.
    """
    fall = min(base.mse - candidate.mse, base.seen - candidate.seen)
    return float(np.sign(fall) * np.sqrt(abs(fall)))


def without(name: str, problem: Problem, candidate: Candidate) -> Candidate:
    """A fitted model with one of its added effects taken out again and refitted."""
    fitted = fit(practised(candidate.fit.model.without_effect(name), problem), problem)
    return cross_judged(_less(candidate, name), fitted, problem)


def roughly_without(name: str, problem: Problem, candidate: Candidate) -> Candidate:
    """The same, of many runs fitted in longer steps only: as far as a choice needs."""
    if problem.practice is None:
        return without(name, problem, candidate)
    less = practised(candidate.fit.model.without_effect(name), problem)
    near = problem.near(less, problem.predict(less), ROUGH)
    fitted = settled(fit(less, near), problem)
    return replace(cross_judged(_less(candidate, name), fitted, problem), ranked=True)


def _less(candidate: Candidate, name: str) -> tuple[str, ...]:
    """The added effects of a candidate without one of them."""
    return tuple(e for e in candidate.effects if e != name)


def left_without(name: str, problem: Problem, candidate: Candidate) -> float:
    """Mean square [N2] that a fitted model leaves with one of its added effects taken out again and refitted."""
    less = candidate.fit.model.without_effect(name)
    return fit(less, problem, sketch=True).mse(problem.train)
