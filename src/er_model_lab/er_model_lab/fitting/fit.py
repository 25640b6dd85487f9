"""Bounded least squares of model parameters on the damper force (Levenberg-Marquardt, all cores).

The way is looked for in longer steps of the integrator, whose error where it begins is taken off. The usual steps say
whether it has led elsewhere; then the fit goes on in them. The Jacobian comes from one batch of predictions.
"""

from __future__ import annotations

from dataclasses import astuple, dataclass, field, replace

import numpy as np
from er_models.effect import CONTACT, SMOOTH
from er_models.model import Array, Model
from er_models.scales import Scales
from er_models.sensitivity import quotients, steps
from numpy.typing import NDArray

from er_model_lab.problem.fit_store import Noted, key
from er_model_lab.problem.forward import COARSE, Free, Limits
from er_model_lab.problem.problem import Practice, Problem
from er_model_lab.problem.subset import MANY

FIRST_ITERATIONS = 10
"""Iterations every candidate gets before the best are fitted to the end."""
DAMPINGS = (0.1, 1.0, 10.0)
"""Multiples of the damping that are tried at once."""
AWAY = 2e-3
"""Share by which the mean square in longer steps may differ from the true one where a fit ends."""
DAMPING = ("passive", "c0")
"""The damping of the damper itself, of which some effects beside it need a little (`Effect.damped`)."""
LOOKS = 3
"""Ways in longer steps, each near where the one before it ended, of a fit that is only to be ranked."""
DAMPED = 1e-3
"""Damping where a straight line is believed whatever it is worth: what hardly moves the force goes nowhere."""
SETTLING = 3
"""Most steps of a fit that settles with the derivatives it has."""
PEAK, RARE, LONGER = 30.0, 1e-3, 10.0
"""A derivative so many times that of all but this share of the rows is looked at over a step so much longer."""
AS_TOLD = 0.9
"""Share of the fall that a straight line promises from which on the least damping is right where equations are smooth.
"""
NEAR, RESTS = 0.5, 4
"""Share of the fall that a straight line promises from which on derivatives are only turned after a step, and how often
one after the other."""


@dataclass(frozen=True)
class Fit:
    """A fitted model.

    residual (n,): measured minus predicted [N]; columns: of the derivatives, in parts (n, p_i), of which fits to the
    same data may share some; scale (p,); at_bound (p,) mask.
    """

    model: Model
    free: Free
    theta: Array
    scale: Array
    residual: Array
    columns: tuple[Array, ...]
    at_bound: NDArray[np.bool_]
    iterations: int

    @property
    def jacobian(self) -> Array:
        """Derivatives (n, p): force per scaled parameter; (0, p) where only deviations are left (`summed_up`)."""
        return self.columns[0] if len(self.columns) == 1 else np.hstack(self.columns)

    def mse(self, mask: NDArray[np.bool_]) -> float:
        """Mean squared residual over a mask [N2]."""
        return mean_square(self.residual[mask])


class Box:
    """Scaled box of the free parameters of a model; limits [SI] of some of them replace the catalogue's."""

    def __init__(
        self, model: Model, free: Free, scales: Scales, limits: Limits | None = None
    ) -> None:
        self.model, self.free = model, free
        c = model.catalogue
        params = self.parameters = [c[e].parameter(p) for e, p in free]
        self.columns = np.array([c.column(e, p) for e, p in free], int)
        self.scale = np.array([scales.of(q.unit) for q in params])
        self.low = np.array([q.low for q in params])
        self.high = np.array([q.high for q in params])
        for k, name in enumerate(free):
            if limits and name in limits:
                self.low[k], self.high[k] = np.array(limits[name]) / self.scale[k]
            if name == DAMPING:
                self.low[k] = max(self.low[k], max(c[e].damped for e in model.effects))
        self.size = np.array([q.size for q in params])
        self.smooth = all(q.step == SMOOTH for q in params)

    def start(self) -> Array:
        """Scaled values of the model, moved into the box."""
        values = np.array([self.model.effects[e][p] for e, p in self.free], float) / self.scale
        return np.clip(np.where(np.isfinite(values), values, self.high), self.low, self.high)

    def vectors(self, thetas: Array) -> Array:
        """Flat parameter vectors (m, n_parameters) of scaled points (m, p)."""
        base = self.model.compiled().p
        out = np.tile(base, (thetas.shape[0], 1))
        out[:, self.columns] = thetas * self.scale
        return out

    def model_at(self, theta: Array) -> Model:
        """The model with these scaled values."""
        effects = {k: dict(v) for k, v in self.model.effects.items()}
        for (e, p), value in zip(self.free, theta * self.scale, strict=True):
            effects[e][p] = float(value)
        return replace(self.model, effects=effects)


def fit(
    model: Model,
    problem: Problem,
    free: Free | None = None,
    *,
    known: Array | None = None,
    target: float = np.inf,
    max_iter: int = 20,
    tol: float = 1e-4,
    sketch: bool = False,
    looks: int = 1,
) -> Fit:
    """Fit the free parameters (all by default) to the training samples, from the model's values.

    known (n, k): derivatives by the first k free parameters near the start, from the model before it
    grew; they serve the first step, and the last too where an effect turns out to change nothing. target: mean
    square [N2] that this first step must reach, or no more is done. What the problem has noted is not fitted again.
    sketch: nobody asks for the derivatives at the end, which cost as much as the way there. looks: ways in longer
    steps before one in the usual ones; where the second or a later one leads to the end, that counts as a fit whose
    iterations were used up.
    """
    forward, rules = problem.forward, _Rules(target, max_iter, tol, sketch, looks)
    box = Box(
        model, free if free is not None else forward.free(model), problem.scales, forward.limits
    )
    start = box.start()
    f = problem.predict(box.model_at(start))
    if problem.noted is None:
        return _fitted(box, start, f, problem, known, rules)[0]
    begun = key(
        (start, box.scale, box.low, box.high, f, problem.force, problem.fold, known),
        (box.free, *astuple(rules)),
    )
    if begun in problem.noted:
        return _again(problem.noted[begun], box, start, f, problem, known, sketch)
    found, problem.noted[begun] = _fitted(box, start, f, problem, known, rules)
    return found


@dataclass(frozen=True)
class _Rules:
    """When a fit ends, as `fit` takes it."""

    target: float
    max_iter: int
    tol: float
    sketch: bool
    looks: int


@dataclass(frozen=True)
class _Leg:
    """A way that fits go: where it ends (p,), what is predicted there (n,), derivatives, mean square [N2].

    at (p,): where the derivatives were taken; exact: all of them there; about (p,): near which model, in longer steps;
    (0,): in the usual ones; rounds: iterations.
    """

    theta: Array
    f: Array
    jacobian: Array
    cost: float
    at: Array
    exact: bool
    rounds: int
    about: Array = field(default_factory=lambda: np.empty(0))


def _fitted(
    box: Box, theta: Array, f: Array, problem: Problem, known: Array | None, rules: _Rules
) -> tuple[Fit, Noted]:
    """A fit from scaled values theta (p,), where the prediction is f (n,), and what makes it again."""
    near = problem.near(box.model_at(theta), f)
    leg = _leg(box, theta, f, near, known, rules)
    if near.forward is not problem.forward:
        leg = _ended(leg, box, theta, f, problem, known, rules)
    note = Noted(leg.theta.tolist(), leg.at.tolist(), leg.exact, leg.rounds, leg.about.tolist())
    none = _none(leg.theta) if rules.sketch else None
    columns = none or _columns(leg.jacobian, None if leg.exact else known)
    return _made(box, leg.theta, leg.f, columns, leg.rounds, problem), note


def _ended(
    coarse: _Leg, box: Box, theta: Array, f: Array, problem: Problem, known: Array | None, rules: _Rules
) -> _Leg:  # fmt: skip
    """A way from theta (p,) in longer steps, on to its end in the usual ones where these see another mean square."""
    for look in range(rules.looks):
        begun, found = theta, problem.predict(box.model_at(coarse.theta))
        true, better = _cost(found, problem), _cost(found, problem) < _cost(f, problem)
        if better:
            theta, f, known = coarse.theta, found, coarse.jacobian
        taken = replace(coarse, theta=theta, f=f, about=begun)
        used_up = better and coarse.rounds >= rules.max_iter
        early = used_up or (coarse.cost > rules.target and not coarse.exact)
        if early or abs(true - coarse.cost) <= AWAY * coarse.cost:
            return replace(taken, rounds=max(taken.rounds, rules.max_iter)) if look else taken
        if not better or look + 1 == rules.looks:
            break
        near = problem.near(box.model_at(theta), f)
        coarse = _leg(box, theta, f, near, known, rules)
    last = _leg(box, theta, f, problem, known, rules)
    if last.exact:
        return last
    return replace(taken, theta=last.theta, f=last.f, rounds=last.rounds)


def _cost(f: Array, problem: Problem) -> float:
    """Mean square [N2] that a prediction (n,) leaves of the training samples."""
    return mean_square((problem.force - f)[problem.train])


def mean_square(left: Array) -> float:
    """Mean square of what is left (n,); infinite where that is beyond all measure, or no number."""
    with np.errstate(over="ignore"):
        size = float(np.mean(left**2))
    return size if np.isfinite(size) else np.inf


def _leg(
    box: Box, theta: Array, f: Array, problem: Problem, known: Array | None, rules: _Rules
) -> _Leg:
    """The way from scaled values theta (p,), where the prediction is f (n,), to the least mean square.

    Where known derivatives make no step, or one that is worth little, it ends. Of long data, or where the way is but
    sketched, derivatives are turned after a step that did what they promised, and taken anew at the end. Beside those
    that were known a sketch takes only the others anew, until a step fails.
    """
    train, y = problem.train, problem.force
    cost = _cost(f, problem)
    damping, exact, at = 1e-3, known is None, theta
    jacobian = _jacobian(box, theta, f, problem, known)
    rounds, rests = 0, 0
    turns = rules.sketch or (problem.motion.n * problem.motion.dt > MANY)
    while rounds < rules.max_iter and np.isfinite(cost):
        problem.work.check()
        rounds += rules.sketch or not rests
        j, r = jacobian[train], (y - f)[train]
        h, g = j.T @ j / r.size, j.T @ r / r.size
        trials = _trials(h, g, theta, box, damping)
        falls = [float(s @ (2.0 * g - h @ s)) for s in trials - theta]
        enough = cost - AS_TOLD * falls[0] if box.smooth else -np.inf
        best, found, tried, there = _best_of(trials, enough, box, problem)
        if not tried < cost * (1.0 - 1e-9):
            if exact and not rests and damping > 1e3:
                break
            if exact and not rests:
                damping *= 30.0
            elif not rests and cost > rules.target:
                break
            else:
                jacobian, exact, at = _jacobian(box, theta, f, problem, None), True, theta
                rests = 0
            continue
        gain, near = 1.0 - tried / cost, cost - tried > NEAR * falls[best]
        step, moved = trials[best] - theta, found - f
        theta, f, cost = trials[best], found, tried
        damping = max(damping * DAMPINGS[best], 1e-7)
        if not rests and (gain < rules.tol or (cost > rules.target and not exact)):
            break
        if near and gain > rules.tol and rests < RESTS and turns:
            jacobian, rests = turned(jacobian, step, moved, np.diag(h)), rests + 1
        elif rules.sketch and known is not None:
            old = turned(jacobian, step, moved, np.diag(h))[:, : known.shape[1]]
            jacobian, exact, rests = _jacobian(box, theta, f, there, old), False, 0
        else:
            jacobian, exact, at, rests = _jacobian(box, theta, f, there, None), True, theta, 0
    if rests and not rules.sketch:
        jacobian, exact, at = _jacobian(box, theta, f, problem, None), True, theta
    return _Leg(theta, f, jacobian, cost, at, exact, rounds)


def turned(jacobian: Array, step: Array, moved: Array, weight: Array) -> Array:
    """Derivatives (n, p) that tell what a step (p,) has moved (n,), else as they were (Broyden 1965).

    weight (p,): how much each parameter counts in what a step is.
    """
    along = weight * step
    return np.asarray(jacobian + np.outer(moved - jacobian @ step, along / (along @ step)))


def _best_of(
    trials: Array, enough: float, box: Box, problem: Problem
) -> tuple[int, Array, float, Problem]:
    """Which of the trials (3, p) is best, the first where that is enough.

    With what it predicts (n,), its mean square, and the problem as it begins there.
    """
    first, there = problem.predicted(box.model_at(trials[0]))
    cost = _cost(first, problem)
    if cost <= enough:
        return 0, first, cost, there
    others = problem.predict_many(box.model, box.vectors(trials[1:]))
    costs = np.array([cost, *(_cost(f, problem) for f in others)])
    best = int(np.argmin(np.where(np.isfinite(costs), costs, np.inf)))
    if best:
        return best, others[best - 1], float(costs[best]), problem
    return best, first, cost, there


def _again(
    note: Noted, box: Box, start: Array, f: Array, problem: Problem, known: Array | None, sketch: bool
) -> Fit:  # fmt: skip
    """A fit that was made before from scaled values start (p,), where the prediction is f (n,)."""

    def predicted(theta: Array, near: Problem = problem) -> Array:
        if np.array_equal(theta, start):
            return f
        return np.asarray(near.predict_many(box.model, box.vectors(theta[None]))[0])

    theta, at, about = np.array(note.theta), np.array(note.at), np.array(note.about)
    if sketch:
        return _made(box, theta, predicted(theta), _none(theta), note.iterations, problem)
    here = predicted(about) if about.size else f
    near = problem.near(box.model_at(about), here) if about.size else problem
    here = here if np.array_equal(at, about) else predicted(at, near)
    known = None if note.exact else known
    columns = _columns(_jacobian(box, at, here, near, known), known)
    return _made(box, theta, predicted(theta), columns, note.iterations, problem)


def _none(theta: Array) -> tuple[Array, ...]:
    """No derivatives by values (p,)."""
    return (np.empty((0, theta.size)),)


def _columns(jacobian: Array, known: Array | None) -> tuple[Array, ...]:
    """Derivatives in parts: those that were known, as the very array that others have, and the rest."""
    if known is None or not known.shape[1]:
        return (jacobian,)
    return known, jacobian[:, known.shape[1] :].copy()


def _made(
    box: Box, theta: Array, f: Array, columns: tuple[Array, ...], rounds: int, problem: Problem
) -> Fit:
    """The fit that ended at theta (p,) with the prediction f (n,)."""
    edge = (theta <= box.low + 1e-9 * box.size) | (theta >= box.high - 1e-9 * np.abs(box.high))
    residual = problem.force - f
    return Fit(box.model_at(theta), box.free, theta, box.scale, residual, columns, edge, rounds)


def settled(fitted: Fit, problem: Problem, tol: float = 1e-4) -> Fit:
    """A fit that was made in longer steps, moved to where the usual ones see the least, with the derivatives it has.

    These are not taken anew: they lead to nearly the same place, and cost more than all else.
    """
    box = Box(fitted.model, fitted.free, problem.scales, problem.forward.limits)
    train, jacobian, theta = problem.train, fitted.jacobian, fitted.theta
    begun = problem.predict(fitted.model)
    near, f, cost = problem.near(fitted.model, begun), begun, _cost(begun, problem)
    j, damping = jacobian[train], DAMPED
    h = j.T @ j / j.shape[0]
    for _ in range(SETTLING):
        problem.work.check()
        g = j.T @ (problem.force - f)[train] / j.shape[0]
        trials = _trials(h, g, theta, box, damping)
        best, found, tried, _ = _best_of(trials, -np.inf, box, near)
        if not tried < cost * (1.0 - tol):
            break
        theta, f, cost = trials[best], found, tried
        damping *= DAMPINGS[best]
    found = begun if theta is fitted.theta else problem.predict(box.model_at(theta))
    if not _cost(found, problem) < _cost(begun, problem):
        theta, found = fitted.theta, begun
    return _made(box, theta, found, fitted.columns, fitted.iterations, problem)


def practised(model: Model, problem: Problem) -> Model:
    """The model with values from a few runs, where there are many: a start near the end for a fit to all."""
    few = problem.practice
    return model if few is None else fit(model, few.problem, sketch=True).model


def part_of(whole: Fit, few: Practice) -> Fit:
    """A fit on the stretches to practise on."""
    return replace(whole, residual=whole.residual[few.rows], columns=(whole.jacobian[few.rows],))


def about(fitted: Fit, problem: Problem, longest: float = COARSE) -> Problem:
    """The problem near a fit: predictions cost less, and are exact there; longest: step of the integrator [s]."""
    return problem.near(fitted.model, problem.force - fitted.residual, longest)


def _jacobian(box: Box, theta: Array, f: Array, problem: Problem, known: Array | None) -> Array:
    """Derivative of the force (n, p) by scaled parameters, one batch of predictions.

    Columns that are known already are taken over.
    """
    near, step = problem.begun(box.model_at(theta)), steps(box.parameters, theta)
    columns = np.arange(0 if known is None else known.shape[1], theta.size)

    def rows(points: Array) -> Array:
        return near.predict_many(box.model, box.vectors(points))

    new = quotients(rows, theta, step, f, columns)
    peaked = [k for k in _peaked(new) if box.parameters[columns[k]].step <= CONTACT]
    if peaked:
        further = quotients(rows, theta, LONGER * step, f, columns[peaked])
        new[:, peaked] = np.where(_jumps(new[:, peaked], further), 0.0, new[:, peaked])
    return new if known is None else np.hstack([known, new])


def _peaked(columns: Array) -> NDArray[np.intp]:
    """Which columns (n, p) a few rows make nearly all of."""
    size = np.sqrt(np.mean(columns**2, axis=0))
    return np.flatnonzero(np.abs(columns).max(axis=0, initial=0.0) > PEAK * size)


def _jumps(found: Array, further: Array) -> NDArray[np.bool_]:
    """Where derivatives (n, p) are those of a row that jumps: much larger than others, and less over a longer step.

    What stands in series is solved on one of several branches, and at a sample in ten thousand another one is as good.
    The jump over a tiny step would pass for a derivative larger than all others together.
    """
    usual = np.quantile(np.abs(found), 1.0 - RARE, axis=0)
    return np.asarray((np.abs(found) > PEAK * usual) & (np.abs(further) < 0.5 * np.abs(found)))


def _trials(h: Array, g: Array, theta: Array, box: Box, damping: float) -> Array:
    """Three damped Gauss-Newton points inside the box; parameters pushed against a bound are held.

    h (p, p), g (p,): products of derivatives, and of derivatives and residual, as means over the samples.
    """
    held = ((theta <= box.low) & (g < 0)) | ((theta >= box.high) & (g > 0))
    points = []
    for factor in DAMPINGS:
        a = h + np.diag(damping * factor * np.diag(h) + 1e-14 * np.trace(h) / max(len(g), 1))
        rhs = np.where(held, 0.0, g)
        a = np.where(held[:, None] | held[None, :], np.diag(np.diag(a) + 1e-300), a)
        step = np.linalg.lstsq(a, rhs, rcond=1e-13)[0]
        limit = 5.0 * np.maximum(np.abs(theta), box.size)
        points.append(np.clip(theta + np.clip(step, -limit, limit), box.low, box.high))
    return np.array(points)


def summed_up(fitted: Fit, model: Model) -> Fit:
    """A fit without its derivatives, which are most of its memory; model: with the deviations that they tell."""
    return replace(fitted, model=model, columns=_none(fitted.theta))
