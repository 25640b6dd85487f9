"""The stages before the joint refinement: passive terms, yield force, response time (thesis 1.5.1 to 1.5.3)."""

from __future__ import annotations

import itertools
from dataclasses import dataclass, replace

import numpy as np
from er_models.model import Model

from er_model_lab.diagnosis.starts import starts
from er_model_lab.fitting.deviations import with_deviations
from er_model_lab.fitting.fit import Box, Fit, fit
from er_model_lab.identification.law import follow_table
from er_model_lab.identification.levels import Table, response_times
from er_model_lab.identification.part import among, only
from er_model_lab.identification.roles import static
from er_model_lab.identification.stretches import Level
from er_model_lab.problem.forward import Free
from er_model_lab.problem.problem import Problem

MOST_STARTS = 16
"""Starting points of the yield force that are looked at."""
FOLLOWED = 3
"""How many of them are usually followed, beside the model's own values."""
MOST_ITERATIONS, TOLERANCE = 30, 1e-7
FIRST = 6
"""Iterations from each of them, before the best is followed to its end."""


@dataclass(frozen=True)
class Stage:
    """One stage: what it estimated, from how many samples, with which error [N]; or why it was left out.

    needed: whether the model has parameters for it, so that leaving it out is a loss.
    """

    name: str
    free: Free
    model: Model
    samples: int = 0
    rmse: float = float("nan")
    left_out: str = ""
    needed: bool = True

    @property
    def done(self) -> bool:
        """Whether the stage was carried out."""
        return not self.left_out


def linear(model: Model, free: Free, problem: Problem, levels: list[Level]) -> Stage:
    """Stiffness and damping by least squares on the data without field (1.13), (1.14)."""
    off = [level for level in levels if level.duty == 0.0]
    if not free:
        return _left_out("linear", model, "the model has no parameter that acts without field")
    if not off:
        reason = f"no stretch at zero duty: no stage for {_list(free)}"
        return Stage("linear", free, model, left_out=reason)
    part = only(problem, off[0].rows)
    found = fit(static(model), part, free, max_iter=MOST_ITERATIONS, tol=TOLERANCE)
    return _stage("linear", model, found, part)


def yield_force(
    model: Model, free: Free, problem: Problem, levels: list[Level], *, follow: int
) -> Stage:
    """Yield force by nonlinear least squares on F_YS (1.15) at all duties, (1.17) or (1.19).

    The static law, from the model's values and from the `follow` likeliest starts of its effects; what `free`
    leaves out is held, so that the rest of the force is F_YS.
    """
    held = [level for level in levels if level.duty > 0.0]
    if not free:
        return _left_out("yield", model, "the model has no yield force")
    if not held:
        reason = f"no stretch of constant duty above zero: no stage for {_list(free)}"
        return Stage("yield", free, model, left_out=reason)
    part = among(problem, *(level.rows for level in held))
    tried = [
        fit(start, part, free, max_iter=FIRST) for start in _starts(model, free, part, follow)
    ]
    best = min(tried, key=lambda f: f.mse(part.train))
    return _stage(
        "yield", model, fit(best.model, part, free, max_iter=MOST_ITERATIONS, tol=TOLERANCE), part
    )


def response(
    model: Model, shape: Free, free: Free, problem: Problem, levels: list[Level]
) -> tuple[Stage, Table | None]:
    """Response time at each constant duty (1.20), then its law over the duty (1.21)."""
    held = [level for level in levels if level.duty > 0.0]
    if not free:
        return _left_out("response", model, "the model is static: it has no response time"), None
    if not held:
        reason = f"no stretch of constant duty above zero: no stage for {_list(free)}"
        return Stage("response", free, model, left_out=reason), None
    table = response_times(static(model), shape, problem, held)
    shaped = taken_over(model, table.model, shape)
    followed = follow_table(shaped, free, table, problem)
    rows = sum(int(level.rows.sum()) for level in held)
    return Stage("response", (*shape, *free), followed, rows, table.rmse), table


def taken_over(model: Model, found: Model, free: Free) -> Model:
    """The model with some values, and their deviations, of another one."""
    effects = {k: dict(v) for k, v in model.effects.items()}
    deviations = {k: dict(v) for k, v in model.deviations.items()}
    for effect, name in free:
        effects[effect][name] = found.value(effect, name)
        if name in found.deviations.get(effect, {}):
            deviations.setdefault(effect, {})[name] = found.deviations[effect][name]
    return replace(model, effects=effects, deviations=deviations)


def names(free: Free) -> list[str]:
    """Parameters as a user reads them."""
    return [name for _, name in free]


def _list(free: Free) -> str:
    return ", ".join(names(free))


def _left_out(name: str, model: Model, reason: str) -> Stage:
    """A stage the model does not need."""
    return Stage(name, (), model, left_out=reason, needed=False)


def _stage(name: str, model: Model, found: Fit, part: Problem) -> Stage:
    """A stage that was carried out, with its values in the whole model."""
    after = taken_over(model, with_deviations(found, part), found.free)
    rmse = float(np.sqrt(found.mse(part.train)))
    return Stage(name, found.free, after, int(part.train.sum()), rmse)


def _starts(model: Model, free: Free, problem: Problem, follow: int) -> list[Model]:
    """The static model with its own values, and with the likeliest starts of its effects, scaled to the data."""
    box = Box(static(model), free, problem.scales)
    effects = list(dict.fromkeys(effect for effect, _ in free))
    grids = [starts(model.catalogue[effect], problem) for effect in effects]
    points = [box.start()]
    for values in itertools.islice(itertools.product(*grids), MOST_STARTS):
        known = dict(zip(effects, values, strict=True))
        point = np.array([known[effect][name] for effect, name in free]) / box.scale
        points.append(np.clip(point, box.low, box.high))
    forces = problem.predict_many(box.model, box.vectors(np.array(points)))
    costs = np.mean((problem.force - forces)[:, problem.train] ** 2, axis=1)
    best = np.argsort(np.nan_to_num(costs[1:], nan=np.inf), kind="stable")[:follow]
    return [box.model_at(points[k]) for k in (0, *(1 + best))]
