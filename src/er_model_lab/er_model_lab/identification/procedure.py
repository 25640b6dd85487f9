"""Identification as in section 1.5 of the thesis: passive terms, yield force, response time, then all together."""

from __future__ import annotations

from dataclasses import dataclass, replace
from itertools import pairwise

import numpy as np
from er_models.effect import arguments
from er_models.model import Array, Model
from er_records.dataset import Dataset

from er_model_lab.fitting.deviations import with_deviations
from er_model_lab.fitting.envelope import with_unfelt
from er_model_lab.fitting.velocity_channel import put_back
from er_model_lab.identification.law import Quadratic, quadratic
from er_model_lab.identification.levels import Table
from er_model_lab.identification.refine import Refined, refine
from er_model_lab.identification.roles import roles
from er_model_lab.identification.stages import FOLLOWED, Stage, linear, response, yield_force
from er_model_lab.identification.stretches import Level, levels, stretches
from er_model_lab.level.damper import opened
from er_model_lab.problem.forward import Free
from er_model_lab.problem.held_out import WARM_UP
from er_model_lab.problem.problem import Problem
from er_model_lab.span.span import Span
from er_model_lab.work import HERE, Work

STAGES = 4
"""Three stages and the joint refinement."""
FADED, GONE = 4.0, 5.0
"""Response times after which a change of the duty has faded to 2 %, which will do, and to under a hundredth."""
AT_MOST = 0.5
"""Share of the usual stretch that is cut at most."""
ROUNDS = 3
"""How often the stages are repeated with stretches cut to the response time they found."""


@dataclass(frozen=True)
class Identified:
    """An identified model.

    model: with standard deviations; stages: what each gave on its own; levels: constant duties found; table and
    quadratic: response time over the duty, where the model has one; given: residual (n,) of the model as it
    was [N]; lag: of the velocity channel, undone before [s] with its deviation, or None.
    """

    model: Model
    before: Model
    problem: Problem
    stages: tuple[Stage, ...]
    levels: tuple[Level, ...]
    table: Table | None
    quadratic: Quadratic | None
    refined: Refined
    given: Array
    lag: tuple[float, float] | None
    span: Span

    @property
    def held(self) -> Free:
        """Parameters that keep the given model's values because the data do not say them."""
        return self.refined.held

    @property
    def residual(self) -> Array:
        """Measured minus predicted force (n,) [N]."""
        return self.refined.fit.residual


def identified(data: Dataset, model: Model, work: Work = HERE) -> Identified:
    """Identify the parameters of a model; records that score are not learnt from.

    Nothing rests on the model's values but what the data do not say: starts come from the data.

    Raises:
        MissingChannel: Without force, both deflection and velocity, or a duty that the model follows.
        InputError: When there is not enough data.
    """
    if _follows_field(model):
        for record in data.records:
            record.need("duty", "to identify the yield force")
    asked = opened(data, model, work=work)
    problem = learn_from_all(asked.problem, len(data.score))
    bare = asked.searched
    stages, found, table = staged(bare, problem)
    work.report("all parameters together", 3, STAGES)
    refined = refine(stages[-1].model, bare, problem)
    fitted = replace(refined.fit, model=replace(refined.fit.model, deviations=bare.deviations))
    final = put_back(with_unfelt(with_deviations(fitted, problem), bare, problem), model)
    return Identified(
        final, model, problem, stages, tuple(found), table, quadratic(table) if table else None, refined,
        asked.given, asked.lag, asked.span,
    )  # fmt: skip


def _follows_field(model: Model) -> bool:
    """Whether any effect of the model asks for the duty or makes a yield force."""
    hooks = [h for e in model.effects for h in model.catalogue[e].hooks.items()]
    return any(name == "target" or "u" in arguments(function) for name, function in hooks)


def staged(model: Model, problem: Problem) -> tuple[tuple[Stage, ...], list[Level], Table | None]:
    """The stages one after another; again, where the response time outlasts the cut of the stretches."""
    who = roles(model, problem)
    settle = WARM_UP
    for again in range(ROUNDS):
        found = levels(problem.motion, problem.train, settle)
        problem.work.report("passive terms", 0, STAGES)
        first = linear(model, who.linear, problem, found)
        shape = who.shape if first.done else (*who.linear, *who.shape)
        problem.work.report("yield force", 1, STAGES)
        second = yield_force(first.model, shape, problem, found, follow=0 if again else FOLLOWED)
        problem.work.report("response time", 2, STAGES)
        third, table = response(second.model, shape, who.response, problem, found)
        longest = float(table.tau.max()) if table else 0.0
        if FADED * longest <= settle:
            break
        model = third.model
        settle = max(min(GONE * longest, AT_MOST * _usual_stretch(problem)), settle)
    return (first, second, third), found, table


def _usual_stretch(problem: Problem) -> float:
    """Length of the stretches of constant duty that hold most of the samples [s]: median over samples."""
    lengths = np.array([j - i for i, j in stretches(problem.motion)])
    return float(np.median(np.repeat(lengths, lengths))) * problem.motion.dt


def learn_from_all(problem: Problem, scored: int) -> Problem:
    """Every record but the last ones, which score, to learn from; nothing spared."""
    m = problem.motion
    fold, held = np.full(m.n, -1, np.int64), np.zeros(m.n, bool)
    pairs = list(pairwise(int(s) for s in m.starts))
    for r, (i, j) in enumerate(pairs):
        rows = slice(min(i + round(WARM_UP / m.dt), j), j)
        if r < len(pairs) - scored:
            fold[rows] = 0
        else:
            held[rows] = True
    return replace(problem, fold=fold, held_out=held).without(problem.wild)
