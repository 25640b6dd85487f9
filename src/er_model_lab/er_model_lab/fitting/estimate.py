r"""From a fit to estimates: values freed of the bias that noisy motion causes, and standard deviations.

Least squares on measured motion is biased, since the noise of the motion enters the model and its derivatives
alike (errors in variables): a gate 2 mm/s wide looks wider. The bias is simulated: with the fitted model as the
truth along motions x that the sensors may have meant, one Gauss-Newton step says how far the fit along the
fused motion \hat x would move,

.. math:: \delta = (J^T J)^{-1} J^T [f(x) - f(\hat x)]

and the mean of a few draws is taken off (regression calibration: Carroll et al. 2006, ch. 4).
Derivatives are secants over a few hundredths of each value: where a gap closes or a void collapses, the tangent
sees every event by itself and not what many of them do together. There the sum of squares is rough, too: what
two lengths of the secant make of it differs, and that difference is part of the uncertainty. Of a bias beyond what
one step can be trusted with the rest is not taken off: it is part of the uncertainty, too.

Values that switch (a play of the piston) have many narrow valleys, and several of one effect share a long one: a play
that is narrower and less damped is crossed in nearly the same time. They are looked for about the fit, each by itself
and together, while all else follows in a straight line.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np
from er_models.effect import SWITCH
from er_models.model import Array, Model
from er_models.sensitivity import quotients, steps
from numpy.typing import NDArray

from er_model_lab.fitting.deviations import covariance, standard_deviations, widths
from er_model_lab.fitting.fit import NEAR, Box, Fit, about, fit, mean_square, part_of, turned
from er_model_lab.problem.forward import colour_of
from er_model_lab.problem.problem import Problem
from er_model_lab.smallest import SMALLEST

SECANTS = (0.01, 0.03)
"""Steps of a derivative, as shares of the value."""
DRAWS = 6
"""Draws of the motion."""
MOST_BIAS = 4.0
"""Bias that one step can be trusted with, in standard deviations."""
SHARES, CROOKED = (1.0, 0.5, 0.25), 1.5
"""Shares of a bias that are tried, and the mean square, over that which derivatives promise, up to which one is taken.
"""
RISES = 1.5
"""Growth of the error up to which a bias is taken away."""
POLISH = 6
"""Most Gauss-Newton steps along secants."""
ABOUT = (0.75, 0.85, 0.92, 0.96, 0.98, 0.99, 1.01, 1.02, 1.04, 1.08, 1.18, 1.33)
"""Shares of values that switch, looked at about a fit."""
LOOKS, TRIED, LIKELIER = 8, 3, 4.0
"""How often that is done at most, how many are polished, and the gain of twice the logarithm of the likelihood that is
worth a move."""
UNTOLD, PART, REFUSED = 0.1, 0.3, 3.0
"""Standard deviation, as a share of what values may be before any data, from which on a direction is hardly told; part
of that direction from which on a value lies along it; standard deviations by which data refuse a value."""
WITHIN = 3.0
"""Standard deviations within which the likelihood about a fit is looked at."""


@dataclass(frozen=True)
class Estimate:
    """Scaled values (p,), their bias that was taken off (p,), and covariance (p, p) [SI]."""

    theta: Array
    bias: Array
    covariance: Array


def secants(
    box: Box, theta: Array, problem: Problem, share: float = SECANTS[0]
) -> tuple[Array, Array]:
    """Force (n,) and its derivative (n, p) by scaled parameters, over a share of each value."""
    near = problem.begun(box.model_at(theta))

    def forces(points: Array) -> Array:
        return near.predict_many(box.model, box.vectors(points))

    here = forces(theta[None])[0]
    return here, quotients(forces, theta, steps(box.parameters, theta, share), here)


def _step(j: Array, e: Array, inner: NDArray[np.bool_]) -> Array:
    """Gauss-Newton step (p,) of the parameters that are not at a bound."""
    out = np.zeros(inner.size)
    out[inner] = np.linalg.lstsq(j[:, inner], e, rcond=1e-10)[0]
    return out


def polished(fitted: Fit, problem: Problem, share: float, known: Array | None = None) -> Fit:
    """The fit moved along secants while that lowers the error, with those derivatives.

    After a step that did what they promised they are turned, and taken anew where that leads no further. known (n, p):
    derivatives near the start of a mere sketch: they serve at first, and at the end none are taken anew.
    """
    box, train, theta = Box(fitted.model, fitted.free, problem.scales), problem.train, fitted.theta
    if known is None:
        f, j = secants(box, theta, problem, share)
    else:
        f, j = problem.predict(fitted.model), known
    inner, rests = ~fitted.at_bound, known is not None
    for _ in range(POLISH):
        e, slopes = (problem.force - f)[train], j[train]
        cost, step = np.mean(e**2), _step(slopes, e, inner)
        points = np.clip(theta + np.outer((1.0, 0.5, 0.2), step), box.low, box.high)
        forces = problem.predict_many(box.model, box.vectors(points))
        costs = np.mean((problem.force - forces)[:, train] ** 2, axis=1)
        best = int(np.argmin(np.where(np.isfinite(costs), costs, np.inf)))
        if costs[best] < cost * (1.0 - 1e-6):
            way, went = points[best] - theta, forces[best] - f
            theta, f = points[best], forces[best]
            promised = cost - np.mean((e - slopes @ way) ** 2)
            if cost - costs[best] > NEAR * promised:
                j, rests = turned(j, way, went, np.mean(slopes**2, axis=0)), True
                continue
        elif not rests:
            break
        (f, j), rests = secants(box, theta, problem, share), False
    if rests and known is None:
        f, j = secants(box, theta, problem, share)
    edge = (theta <= box.low) | (theta >= box.high)
    return replace(
        fitted, model=box.model_at(theta), theta=theta, residual=problem.force - f, columns=(j,),
        at_bound=fitted.at_bound | edge,
    )  # fmt: skip


def moved(fitted: Fit, problem: Problem, share: float) -> Fit:
    """A polished fit moved to likelier valleys of the values that switch, as long as there is one.

    They are looked for in longer steps of the integrator, of many runs on stretches; where that leads is polished on
    all of them.
    """
    box, train = Box(fitted.model, fitted.free, problem.scales), problem.train
    least = 1.0 - LIKELIER / _independent(fitted, problem)
    for _ in range(LOOKS):
        here, near = _for_less(fitted, problem)
        points, costs = _looked(here, near)
        begun = [
            replace(here, model=box.model_at(x), theta=x)
            for x in points[np.argsort(costs)[:TRIED]]
        ]
        tried = [polished(f, near, share, here.jacobian) for f in begun]
        best = min(tried, key=lambda f: f.mse(near.train), default=here)
        if not best.mse(near.train) < least * here.mse(near.train):
            break
        best = polished(best, problem, share)
        if not best.mse(train) < least * fitted.mse(train):
            break
        fitted = best
    return fitted


def _for_less(fitted: Fit, problem: Problem) -> tuple[Fit, Problem]:
    """A fit, of many runs on stretches, and the problem as one that is predicted for less about it."""
    few = problem.practice
    here, where = (fitted, problem) if few is None else (part_of(fitted, few), few.problem)
    return here, about(here, where)


def breadth(fitted: Fit, problem: Problem) -> Array:
    """Standard deviations (p,) as the likelihood falls off about the values that switch; scaled, zero for others.

    Where valleys are many the curvature in one of them says too little: each point that was looked at is as many
    standard deviations away as the root of what it lacks in twice the logarithm of the likelihood.
    """
    points, costs = _looked(fitted, about(fitted, problem))
    lacks = _independent(fitted, problem) * (costs / max(fitted.mse(problem.train), 1e-300) - 1.0)
    near = lacks < WITHIN**2
    away = np.abs(points - fitted.theta)[near] / np.sqrt(np.maximum(lacks[near], 1.0))[:, None]
    wide = away.max(axis=0, initial=0.0)
    return np.where(_switching(fitted, problem), wide, 0.0)


def _independent(fitted: Fit, problem: Problem) -> float:
    """Samples of noise that tell as much as those that are fitted: what one leaves goes on in the next (AR(1))."""
    e = fitted.residual[problem.train]
    colour = min(max(colour_of(e), 0.0), 0.99)
    return max(e.size * (1.0 - colour) / (1.0 + colour), 1.0)


def _switching(fitted: Fit, problem: Problem) -> NDArray[np.bool_]:
    """Which free values (p,) switch events on and off, and are not at a bound."""
    box = Box(fitted.model, fitted.free, problem.scales)
    return np.array([q.step == SWITCH for q in box.parameters], bool) & ~fitted.at_bound


def _looked(fitted: Fit, problem: Problem) -> tuple[Array, Array]:
    """Points (m, p) about a fit along the values that switch, all else following, and mean squares (m,) there.

    Where the model has no finite force there is no point.
    """
    box, train = Box(fitted.model, fitted.free, problem.scales), problem.train
    switching = _switching(fitted, problem)
    if not switching.any():
        return np.empty((0, fitted.theta.size)), np.empty(0)
    points = fitted.theta * _about(box, switching)
    points = points[((points >= box.low) & (points <= box.high)).all(axis=1)]
    left = (problem.force - problem.predict_many(box.model, box.vectors(points))).T[train]
    finite = np.isfinite(left).all(axis=0)
    points, left = points[finite], left[:, finite]
    others = ~switching & ~fitted.at_bound
    j = fitted.jacobian[train][:, others]
    follow = np.linalg.lstsq(j, left, rcond=1e-10)[0]
    points[:, others] += follow.T
    return np.clip(points, box.low, box.high), np.mean((left - j @ follow) ** 2, axis=0)


def _about(box: Box, switching: NDArray[np.bool_]) -> Array:
    """Factors (m, p) of the values: of each one that switches, of all of an effect, and of them against each other."""
    rows = []
    for effect in dict.fromkeys(e for (e, _), s in zip(box.free, switching, strict=True) if s):
        own = switching & np.array([e == effect for e, _ in box.free])
        places = np.flatnonzero(own)
        ways = [*np.eye(own.size)[places], own.astype(float)]
        if places.size == 2:
            ways += [ways[0] - ways[1]]
        rows += [np.power(about, way) for way in ways for about in ABOUT]
    return np.array(rows)


def settled(fitted: Fit, given: Model, problem: Problem) -> Fit:
    """The fit with the given model's values where the data hardly tell them, all else following.

    Two levels of the duty tell two numbers: yield force, exponent and remanence make up for each other, and each of
    many fits predicts other levels differently. What was known of them before is more than nothing, unless the data
    refuse it by `REFUSED` deviations or by an error that would count.
    """
    least, refused = 1.0 + SMALLEST**2, set[tuple[str, str]]()
    deviations = dict(zip(fitted.free, standard_deviations(fitted, problem), strict=True))
    while place := _untold(fitted, given, problem, refused):
        effect, name = place
        refused.add(place)
        known, found = given.value(effect, name), fitted.model.value(effect, name)
        if abs(known - found) > REFUSED * deviations[place]:
            continue
        values = {**fitted.model.effects[effect], name: known}
        held = dict(zip(fitted.free, fitted.at_bound, strict=True))
        others = tuple(f for f in fitted.free if f != place and not held[f])
        tried = fit(fitted.model.with_effect(effect, values), problem, others)
        if tried.mse(problem.train) <= least * fitted.mse(problem.train):
            fitted = _widened(tried, fitted)
    return fitted


def _untold(
    fitted: Fit, given: Model, problem: Problem, refused: set[tuple[str, str]]
) -> tuple[str, str] | None:
    """The value of the given model that the data tell least of, along all directions that they hardly tell."""
    inner, wide = np.flatnonzero(~fitted.at_bound), widths(fitted)
    if not inner.size:
        return None
    noise = max(fitted.mse(problem.train), 1e-300)
    j = fitted.jacobian[problem.train][:, inner] * wide[inner]
    told, directions = np.linalg.eigh(j.T @ j / noise)
    untold = directions[:, told <= 1.0 / UNTOLD**2]
    if not untold.size:
        return None
    known = [fitted.free[k] not in refused and fitted.free[k][0] in given.effects for k in inner]
    shares = np.linalg.norm(untold, axis=1) * known
    k = int(np.argmax(shares))
    return fitted.free[inner[k]] if shares[k] > PART else None


def _widened(part: Fit, whole: Fit) -> Fit:
    """A fit of some of the values of another as one of all: the others are held, as at a bound."""
    places = [whole.free.index(f) for f in part.free]
    theta = np.array([part.model.effects[e][q] for e, q in whole.free]) / whole.scale
    jacobian, held = np.zeros_like(whole.jacobian), np.ones_like(whole.at_bound)
    jacobian[:, places], held[places] = part.jacobian, part.at_bound
    return replace(
        part, free=whole.free, theta=theta, scale=whole.scale, columns=(jacobian,), at_bound=held
    )


def estimate(fitted: Fit, problem: Problem, seed: int) -> Estimate:
    """Values without bias and their covariance, of a polished fit."""
    box, rng, train = (
        Box(fitted.model, fitted.free, problem.scales),
        np.random.default_rng(seed),
        problem.train,
    )
    inner, (_, j) = ~fitted.at_bound, secants(box, fitted.theta, problem)
    errors = problem.forward.input_errors(problem, fitted.model, rng, DRAWS)
    moves = [_step(j[train], e[train], inner) for e in errors]
    bias, spread = np.mean(moves, axis=0), np.std(moves, axis=0, ddof=1)
    found = covariance(fitted, problem)
    believed = trusted(bias, found / np.outer(fitted.scale, fitted.scale))
    theta = as_far_as_straight(
        [stopped(fitted.theta, -s * believed, j[train], inner, box) for s in SHARES],
        fitted, j, problem, box,
    )  # fmt: skip
    taken = fitted.theta - theta
    doubt = spread**2 / DRAWS + (bias - taken) ** 2
    return Estimate(theta, taken, found + np.diag(doubt * fitted.scale**2))


def as_far_as_straight(
    points: Sequence[Array], fitted: Fit, j: Array, problem: Problem, box: Box
) -> Array:
    """The first of some points (p,) where the error is what derivatives j (n, p) promise; the fit's where none is.

    A bias is a few standard deviations, which the error hardly feels: where it would grow by more than `RISES` the step
    is none. Where values make up for each other a bound may stop one of them, and no other can follow.
    """
    train, left = problem.train, fitted.mse(problem.train)
    forces = problem.predict_many(box.model, box.vectors(np.array(points)))
    for theta, force in zip(points, forces, strict=True):
        straight = mean_square((fitted.residual - j @ (theta - fitted.theta))[train])
        there = mean_square((problem.force - force)[train])
        if there <= min(SMALLEST**2 * left + CROOKED * straight, RISES**2 * left):
            return theta
    return fitted.theta


def trusted(bias: Array, covariance: Array) -> Array:
    """The part of a bias (p,) that one step can be trusted with, along each direction that errs by itself.

    Values that make up for each other are moved together or not at all. covariance (p, p): not finite where nothing is
    known, and nothing is taken there.
    """
    variance = np.diag(covariance)
    known = np.isfinite(variance) & (variance > 0.0)
    sd = np.sqrt(variance[known])
    alike = covariance[np.ix_(known, known)] / np.outer(sd, sd)
    size, along = np.linalg.eigh(alike)
    wide = np.sqrt(np.maximum(size, 1e-12))
    apart = np.clip(along.T @ (bias[known] / sd) / wide, -MOST_BIAS, MOST_BIAS)
    out = np.zeros_like(bias)
    out[known] = sd * (along @ (wide * apart))
    return out


def stopped(theta: Array, step: Array, j: Array, inner: NDArray[np.bool_], box: Box) -> Array:
    """The point a step (p,) away from theta (p,), in the box; where a bound stops a value the others follow.

    They move so that the force goes as far as with the whole step, as nearly as they can. j (n, p): its derivatives;
    inner (p,): values that may move.
    """
    out, free, far = theta + step, inner.copy(), j @ step
    while (over := free & ((out < box.low) | (out > box.high))).any():
        out[over] = np.clip(out, box.low, box.high)[over]
        free &= ~over
        held = np.where(free, 0.0, out - theta)
        out[free] = (theta + _step(j, far - j @ held, free))[free]
    return out


def _unless_astray(found: Fit, fitted: Fit, problem: Problem) -> Fit:
    """A fit that was found in longer steps, as the usual ones see it; the one before where it leaves more in them.

    Values that switch may lead elsewhere in longer steps.
    """
    seen = replace(found, residual=problem.force - problem.predict(found.model))
    return seen if seen.mse(problem.train) < fitted.mse(problem.train) else fitted


def estimated(fitted: Fit, problem: Problem, seed: int, given: Model | None = None) -> Model:
    """The model with its estimates; a deviation is infinite where the data say nothing.

    given: the model before the fit, whose values stay where the data hardly tell them; deviations are as without that.
    Of many runs predictions are those of longer steps of the integrator, exact near by.
    """
    whole, fitted = fitted, fitted if given is None else settled(fitted, given, problem)
    near = about(fitted, problem) if problem.practice else problem
    tried = [moved(polished(fitted, near, share), near, share) for share in SECANTS]
    if near is not problem:
        tried = [_unless_astray(f, fitted, problem) for f in tried]
    tried.sort(key=lambda f: f.mse(problem.train))
    better = tried[0]
    problem = about(better, problem) if problem.practice else problem
    rough = (tried[1].theta - better.theta) * better.scale
    found = estimate(better, problem, seed)
    model = Box(better.model, better.free, problem.scales).model_at(found.theta)
    deviations = {k: dict(v) for k, v in model.deviations.items()}
    wide = breadth(better, problem) * better.scale
    variances = np.maximum(np.diag(found.covariance), wide**2) + rough**2
    for (effect, name), value in zip(better.free, variances, strict=True):
        sd = float(np.sqrt(value)) if value >= 0 else float("inf")
        deviations.setdefault(effect, {})[name] = sd
    if fitted is not whole:
        for (effect, name), sd in zip(
            whole.free, standard_deviations(whole, problem), strict=True
        ):
            own = deviations[effect][name]
            deviations[effect][name] = float(sd) if not np.isfinite(own) else max(own, float(sd))
    return replace(model, deviations=deviations)
