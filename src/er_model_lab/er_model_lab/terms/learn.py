"""Learns a measured term beside a fitted model, and takes it only where data left out gain by it beyond doubt."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from er_models.measured import LAGGED, MeasuredTerm
from er_models.model import Array, Model
from numpy.typing import NDArray

from er_model_lab.diagnosis.candidates import Candidate, effect_size
from er_model_lab.diagnosis.passing import NEARLY_ALL, harmless, paired_t
from er_model_lab.diagnosis.ties import DOUBT
from er_model_lab.fitting.cross_validation import SHARES
from er_model_lab.fitting.fit import Box, Fit, fit
from er_model_lab.problem.problem import Problem
from er_model_lab.residual.errors import errors
from er_model_lab.terms.regression import Normal
from er_model_lab.terms.search import Choice, Samples, conditioned, searched
from er_model_lab.terms.seen import distinct, seen

MOST, MOST_AT_END = 8_000, 24_000
"""Samples that a search looks at, and that the coefficients are learnt from."""
LAGS = (0.02, 0.06, 0.18)
"""Time constants of a lag, over the time in which the motion turns."""
LAG_HELPS = 0.15
"""Share of the mean square left that a lag must take off."""
MOST_TERMS = 2
"""Terms that a model may hold; the first of them alone may be lagged."""
TURNS, WORTH = 3, 0.01
"""How often coefficients and parameters are fitted in turn, and the share of the mean square that a turn must take."""
MADE = ("force", "yield_force", "formed_duty")
"""Quantities that follow from the model's parameters."""
AT_ONCE = 0.1
"""Difference of what a term adds and what its splines say, over the former, from which the model itself is asked."""


@dataclass(frozen=True)
class Learnt:
    """A term beside a model, both fitted together.

    choice: its shape; candidate: the model with it, judged as an effect is; values (n,): its quantities along all
    samples; design (n, k): of its coefficients; before: the model without it.
    """

    term: MeasuredTerm
    choice: Choice
    candidate: Candidate
    before: Candidate
    values: Mapping[str, Array]
    design: Array

    @property
    def force(self) -> Array:
        """What it adds along the samples (n,) [N]."""
        return np.asarray(self.design @ np.array(self.term.coefficients))

    @property
    def model(self) -> Model:
        """The model with it, with deviations."""
        return self.candidate.fit.model


def learn(before: Candidate, problem: Problem, limit: float) -> Learnt | str:
    """What a model leaves as one smooth term, or why there is none; limit: size that an effect must exceed [N]."""
    known = before.fit.model.terms
    if len(known) >= MOST_TERMS:
        return f"the model holds {known[0].name} and {known[1].name} already: no further term is learnt"
    values = distinct(seen(before.fit.model, problem), problem)
    few = _samples(before.fit, values, problem, MOST)
    base = _base(few)
    choice = searched(few, base, [(t.quantities, t.times) for t in known])
    if not known:
        choice, values = _lagged(choice, values, before.fit, problem)
    choice = conditioned(choice, _samples(before.fit, values, problem, MOST), base)
    problem.work.check()
    found = _together(choice, values, before, problem)
    refused = _refused(before, found.candidate, problem, limit)
    return f"{found.term.name} not added: {refused}" if refused else found


def _rows(problem: Problem, most: int) -> NDArray[np.intp]:
    """Rows that are learnt from, thinned."""
    rows = np.flatnonzero(problem.train)
    return rows[:: max(1, -(-rows.size // most))]


def _samples(fitted: Fit, values: Mapping[str, Array], problem: Problem, most: int) -> Samples:
    """What a term is learnt from; each fold of the problem is a block."""
    rows = _rows(problem, most)
    block = np.unique(problem.fold[rows], return_inverse=True)[1]
    jacobian = _lines(fitted, problem)[0][rows]
    return Samples({k: v[rows] for k, v in values.items()}, jacobian, fitted.residual[rows], block)


def _lines(fitted: Fit, problem: Problem) -> tuple[Array, Array]:
    """Derivatives (n, p) of unit size by the parameters that are not at a bound, and what they were divided by (p,)."""
    inner = fitted.jacobian[:, ~fitted.at_bound]
    size = np.sqrt(np.mean(inner[problem.train] ** 2, axis=0))
    size = np.where(size > 0.0, size, 1.0)
    return inner / size, size


def _base(samples: Samples) -> float:
    """Mean square that the model leaves of blocks left out [N2], judged as a term is."""
    alone = samples.normal(np.empty((samples.left.size, 0)))
    return alone.mean(alone.judged(alone.penalty(np.empty((0, 0)), 0.0)))


def _lagged(
    choice: Choice, values: dict[str, Array], fitted: Fit, problem: Problem
) -> tuple[Choice, dict[str, Array]]:
    """The choice with one of its quantities lagged, where that helps clearly."""
    motion = problem.motion
    turn = float(np.std(motion.x) / max(float(np.std(motion.v)), 1e-300))
    best, kept = choice, values
    for quantity in choice.quantities:
        for lag in (share * turn for share in LAGS):
            name = quantity + LAGGED
            known = values | seen(fitted.model, problem, [(name, lag)])
            if name not in known:
                continue
            axes = tuple(
                replace(a, quantity=name) if a.quantity == quantity else a for a in choice.axes
            )
            tried = replace(choice, axes=axes)
            samples = _samples(fitted, known, problem, MOST)
            own = samples.normal(tried.design(samples.values)).through(tried.map)
            losses = own.judged(tried.penalty(own))
            mse = own.mean(losses)
            clear = mse < (1.0 - LAG_HELPS) * choice.mse
            if clear and mse < best.mse and paired_t(choice.losses - losses) > DOUBT:
                best, kept = replace(tried, losses=losses, mse=mse, lag=lag), known
    return best, kept


def _together(
    choice: Choice, values: Mapping[str, Array], before: Candidate, problem: Problem
) -> Learnt:
    """The coefficients and the parameters of the model, fitted in turn as long as that helps."""
    fitted, c, felt = before.fit, np.zeros(len(choice.map)), None
    best: tuple[Fit, Array, Array] | None = None
    for turn in range(TURNS):
        design = choice.design(_again(values, choice, fitted, problem) if turn else values)
        own = design @ c
        if felt is not None:
            design = felt
        found = _tried(choice, fitted, design, own, problem)
        if turn == 0:
            felt = _as_felt(design, found[0][0], fitted, choice, problem)
            design = design if felt is None else felt
            found = found if felt is None else _tried(choice, fitted, felt, own, problem)
        begun, c = _begun(found, choice, fitted, problem)
        now = fit(begun, problem, max_iter=0)
        if best is not None and not now.mse(problem.train) < (1.0 - WORTH) * best[0].mse(
            problem.train
        ):
            break
        best = (now, c, design)
        fitted = fit(begun, problem, known=now.jacobian, max_iter=3)
    assert best is not None
    return _judged(choice, values, best[2], best[:2], before, problem)


def _again(
    values: Mapping[str, Array], choice: Choice, fitted: Fit, problem: Problem
) -> dict[str, Array]:
    """The values with those of the term's quantities that follow from the model's parameters, as they are now."""
    names = [n for n in (*choice.quantities, choice.times) if n.removesuffix(LAGGED) in MADE]
    return dict(values) | (
        seen(fitted.model, problem, [(n, choice.lag) for n in names]) if names else {}
    )


def _tried(
    choice: Choice, fitted: Fit, design: Array, own: Array, problem: Problem
) -> list[tuple[Array, Array]]:
    """Coefficients (k,) with the step (p,) of the parameters that goes with them, and those beside no step."""
    solved, equations, penalty = _solved(choice, fitted, design, own, problem)
    n = equations.params
    alone = equations.alone().solved(penalty[n:, n:])
    return [(choice.map @ solved[n:], solved[:n]), (choice.map @ alone, np.zeros(n))]


def _begun(
    found: list[tuple[Array, Array]], choice: Choice, fitted: Fit, problem: Problem
) -> tuple[Model, Array]:
    """The model with the coefficients that do best, and as much of the step that goes with them; and these (k,)."""
    best, least = None, np.inf
    for c, step in found:
        model = _with(fitted.model, _term(choice, c, np.zeros(c.size)))
        box = Box(model, fitted.free, problem.scales, problem.forward.limits)
        whole = np.zeros(fitted.theta.size)
        whole[~fitted.at_bound] = step / _lines(fitted, problem)[1]
        shares = SHARES if step.any() else SHARES[:1]
        points = np.clip(fitted.theta + np.multiply.outer(shares, whole), box.low, box.high)
        left = problem.force - problem.predict_many(model, box.vectors(points))
        costs = np.nan_to_num(np.mean(left[:, problem.train] ** 2, axis=1), nan=np.inf)
        if best is None or costs.min() < least:
            best, least = (box.model_at(points[int(np.argmin(costs))]), c), float(costs.min())
    assert best is not None
    return best


def _solved(
    choice: Choice, fitted: Fit, design: Array, own: Array, problem: Problem
) -> tuple[Array, Normal, Array]:
    """Parameters and free coefficients; own (n,): what the term of the fit adds [N]. With equations and penalty."""
    rows = _rows(problem, MOST_AT_END)
    block = np.unique(problem.fold[rows], return_inverse=True)[1]
    jacobian, left = _lines(fitted, problem)[0][rows], (fitted.residual + own)[rows]
    equations = Samples({}, jacobian, left, block).normal(design[rows]).through(choice.map)
    penalty = choice.penalty(equations)
    return equations.solved(penalty), equations, penalty


def _term(choice: Choice, c: Array, sd: Array) -> MeasuredTerm:
    """The term with these coefficients and deviations."""
    knots = tuple(tuple(a.knots) for a in choice.axes)
    return MeasuredTerm(
        choice.quantities, knots, tuple(c), tuple(sd), choice.times, choice.lag, choice.shape
    )


def _with(model: Model, term: MeasuredTerm) -> Model:
    """The model with the term, in place of the same one with other coefficients; one learnt before stays first."""
    return replace(model, terms=(*(t for t in model.terms if t.name != term.name), term))


def _as_felt(
    design: Array, c: Array, fitted: Fit, choice: Choice, problem: Problem
) -> Array | None:
    """The design as the model passes it on, where a sensor that lags or a mount in series changes what a term adds."""
    bare, model = (
        _with(fitted.model, _term(choice, each, np.zeros(c.size))) for each in (0.0 * c, c)
    )
    p, q = model.compiled().p, bare.compiled().p
    added = np.subtract(*problem.predict_many(model, np.stack([p, q])))
    train = problem.train
    off = float(np.sqrt(np.mean((added - design @ c)[train] ** 2)))
    if not off > AT_ONCE * float(np.sqrt(np.mean(added[train] ** 2))):
        return None
    unit = max(float(np.abs(c).max()), 1e-12)
    vectors = np.tile(q, (c.size + 1, 1))
    vectors[1:, -c.size :] += unit * np.eye(c.size)
    rows = problem.predict_many(model, vectors)
    return np.asarray((rows[1:] - rows[0]).T / unit)


def _judged(
    choice: Choice, values: Mapping[str, Array], design: Array, best: tuple[Fit, Array], before: Candidate,
    problem: Problem,
) -> Learnt:  # fmt: skip
    """The term of a fit with its deviations, judged by blocks left out with parameters and coefficients alike."""
    fitted, c = best
    _, equations, penalty = _solved(choice, fitted, design, design @ c, problem)
    inner, train = ~fitted.at_bound, problem.train
    lines, size = _lines(fitted, problem)
    residual = _left_out(choice, fitted, equations, penalty, problem)
    told, n = problem.forward.beginnings(problem, fitted.model), int(train.sum())
    residual[train] *= np.sqrt((n + told) / max(n - told, 1.0))
    losses = [
        float(np.mean(residual[problem.fold == b] ** 2))
        for b in range(int(problem.fold.max()) + 1)
    ]
    both = np.hstack([lines, design @ choice.map])
    spread = _spread(both, fitted, equations, penalty, problem)
    sd = np.sqrt(np.maximum(np.einsum("kr,rs,ks->k", choice.map, spread[equations.params :, equations.params :],
                                      choice.map, optimize=True), 0.0))  # fmt: skip
    term = _term(choice, c, sd)
    deviations = {k: dict(v) for k, v in fitted.model.deviations.items()}
    of_params = np.full(inner.size, np.inf)
    of_params[inner] = (
        np.sqrt(np.maximum(np.diag(spread)[: equations.params], 0.0)) / size * fitted.scale[inner]
    )
    for (effect, name), value in zip(fitted.free, of_params, strict=True):
        deviations.setdefault(effect, {})[name] = float(value)
    model = replace(_with(fitted.model, term), deviations=deviations)
    candidate = Candidate(
        (*before.effects, term.name), replace(fitted, model=model), residual, np.array(losses),
        float(np.mean(residual[train] ** 2)), fitted.mse(train), 1.0, np.inf,
    )  # fmt: skip
    return Learnt(term, choice, candidate, before, values, design)


def _left_out(
    choice: Choice, fitted: Fit, equations: Normal, penalty: Array, problem: Problem
) -> Array:
    """Residual (n,), of each block what the model itself leaves with the coefficients that the others tell.

    Its parameters move with them where that lowers the error of the others: their straight line may lead astray.
    """
    n, count = equations.params, len(choice.map)
    box = Box(fitted.model, fitted.free, problem.scales, problem.forward.limits)
    both = equations.left_out(penalty)
    alone = equations.alone().left_out(penalty[n:, n:])
    theta = np.tile(fitted.theta, (2 * len(both), 1))
    theta[: len(both), ~fitted.at_bound] += both[:, :n] / _lines(fitted, problem)[1]
    vectors = box.vectors(np.clip(theta, box.low, box.high))
    vectors[:, -count:] = np.vstack([both[:, n:], alone]) @ choice.map.T
    left = problem.force - problem.predict_many(fitted.model, vectors)
    residual = fitted.residual.copy()
    blocks = np.unique(problem.fold[problem.train])
    for b, *tried in zip(blocks, *np.split(left, 2), strict=True):
        rows, others = problem.fold == b, problem.train & (problem.fold != b)
        residual[rows] = min(tried, key=lambda r: float(np.mean(r[others] ** 2)))[rows]
    return residual


def _spread(
    both: Array, fitted: Fit, equations: Normal, penalty: Array, problem: Problem
) -> Array:
    """Covariance of parameters and free coefficients, robust to errors that last: sandwich over one-second blocks."""
    rows = _rows(problem, MOST_AT_END)
    scores = both[rows] * fitted.residual[rows][:, None]
    seconds = rows // problem.second
    edges = np.concatenate([[0], np.flatnonzero(np.diff(seconds)) + 1])
    sums = np.add.reduceat(scores, edges, axis=0)
    bread = np.linalg.inv(equations.h.sum(axis=0) + penalty)
    return np.asarray(bread @ (sums.T @ sums) @ bread)


def _refused(before: Candidate, after: Candidate, problem: Problem, limit: float) -> str:
    """Why a term is not taken; empty where it is.

    It must gain as an effect must, on blocks left out steadily, and never raise the error of what is held out. Records
    of different kind gain unevenly: where nearly all blocks gain and the others lose next to nothing, that is steady.
    """
    size = effect_size(before, after)
    if not size > limit:
        return f"it would lower the error of blocks left out by {size:.3g} N, chance reaches {limit:.3g} N"
    gains = before.losses - after.losses
    even = float(np.mean(gains > 0.0)) >= NEARLY_ALL and harmless(gains)
    if not (even or paired_t(gains) > DOUBT):
        return "what it gains varies too much from one stretch of time to the next"
    was, now = (errors(problem, c.fit.residual, problem.held_out).rmse for c in (before, after))
    if not now < was:
        return f"the error on held-out data would rise from {was:.3g} N to {now:.3g} N"
    return ""
