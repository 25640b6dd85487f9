"""How strong the effects are taken to be: as the data say, or so strong that they stand out.

Without data each effect begins at a starting value of the catalogue (a multiple of the model's
natural scales) and its amplitudes are scaled until, in a rich program within the limits, what the
refitted model cannot absorb is as large as the noise: half of that would hardly be worth a name,
several times that is told apart by anything.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from er_models.effect import Effect, Param
from er_models.model import Model
from er_models.prediction import predict
from er_models.scales import Scales

from er_model_lab.diagnosis.candidates import baseline, effect_size, refit
from er_model_lab.diagnosis.rule import RULE
from er_model_lab.fitting.deviations import with_deviations
from er_model_lab.planning.limits import Sensors
from er_model_lab.planning.linear import design, left, triangle
from er_model_lab.planning.question import Question
from er_model_lab.planning.virtual_rig import Run
from er_model_lab.problem.problem import Problem

STANDS_OUT = 1.0
"""Unexplained change of the force over the noise at the strength that is taken without data."""
MOST_STARTS = 2
"""Starting points of an imitation, beside the other effect at its own strength."""
MOST_POINTS = 8
TRIES = 6
FITTED = "fitted to the data"
HELD = "the model's own"
STANDING_OUT = "as strong as the noise in a rich program"
Rich = Sequence[tuple[Run, float]]
"""Runs of the base model with their noise floors [N]."""
CLOSE = 0.05


@dataclass(frozen=True)
class Rivals:
    """The models to tell apart, and from where the imitations begin.

    truths: model with each effect at its strength, by name; mimics: by name of the truth, the
    models from which the other explanation is fitted; shown: unexplained change over the noise in
    a rich program; sources: where each strength comes from.
    """

    question: Question
    truths: Mapping[str, Model]
    mimics: Mapping[str, tuple[Model, ...]]
    shown: Mapping[str, float]
    sources: Mapping[str, str]


def standing_out(question: Question, rich: Rich, sensors: Sensors) -> Rivals:
    """Every effect so strong that it stands out; rich: runs of the base model with their noise floors."""
    truths, shown, sources = {}, {}, {}
    for name in question.names:
        effect, held = question.effect(name), question.held.get(name)
        if held:
            truths[name] = question.base.with_effect(name, held)
            shown[name], sources[name] = _shown(question.base, truths[name], rich, sensors), HELD
            continue
        points = _grid(effect, question.base.scales)
        found = [_scaled(question.base, effect, point, rich, sensors) for point in points]
        best = max(found, key=lambda pair: -abs(np.log(max(pair[1], 1e-6) / STANDS_OUT)))
        (truths[name], shown[name]), sources[name] = best, STANDING_OUT
    return _rivals(question, truths, shown, sources)


def from_data(assumed: Rivals, problem: Problem, rich: Rich, sensors: Sensors) -> Rivals:
    """Every effect as it is fitted to what was measured; as assumed where the data show too little of it."""
    question, base = assumed.question, baseline(assumed.question.base, problem)
    model = replace(base.fit.model, scales=question.base.scales)
    truths, shown, sources = {}, {}, {}
    for name in question.names:
        found = refit(base, question.effect(name), problem, max_iter=20)
        seen = effect_size(base, found) >= RULE.smallest * np.sqrt(found.mse)
        values = assumed.truths[name].effects[name]
        truth = with_deviations(found.fit, problem) if seen else model.with_effect(name, values)
        truths[name] = replace(truth, scales=question.base.scales)
        shown[name] = _shown(model, truths[name], rich, sensors)
        sources[name] = FITTED if seen else STANDING_OUT
    return _rivals(replace(question, base=model), truths, shown, sources)


def _rivals(
    question: Question, truths: Mapping[str, Model], shown: Mapping[str, float], sources: Mapping[str, str]
) -> Rivals:  # fmt: skip
    """Truths with the models that shall imitate them."""
    mimics: dict[str, tuple[Model, ...]] = {}
    for name in question.names:
        others = [n for n in question.names if n != name]
        mimics[name] = (question.base,) if not others else (truths[others[0]],)
        for other in others:
            points = _grid(question.effect(other), question.base.scales)[:MOST_STARTS]
            mimics[name] += tuple(question.base.with_effect(other, point) for point in points)
    return Rivals(question, truths, mimics, shown, sources)


def _grid(effect: Effect, scales: Scales) -> list[dict[str, float]]:
    """Combinations of an effect's starting values [SI]."""
    grids = [[s * scales.of(q.unit) for s in q.starts] for q in effect.parameters]
    points = itertools.islice(itertools.product(*grids), MOST_POINTS)
    return [dict(zip(effect.names, point, strict=True)) for point in points]


def _scaled(
    base: Model, effect: Effect, point: Mapping[str, float], rich: Rich, sensors: Sensors
) -> tuple[Model, float]:
    """The model with the effect's amplitudes scaled until it stands out, and by how much it does."""
    q, power, tried = 1.0, 1.0, list[tuple[float, Model, float]]()
    for _ in range(TRIES):
        model = base.with_effect(effect.name, _at(effect, point, q, base.scales))
        tried.append((q, model, _shown(base, model, rich, sensors)))
        size = tried[-1][2]
        if not 1e-6 < size < np.inf or abs(np.log(size / STANDS_OUT)) < CLOSE:
            break
        if len(tried) > 1 and tried[-1][0] != tried[-2][0] and tried[-2][2] > 1e-6:
            slope = np.log(size / tried[-2][2]) / np.log(q / tried[-2][0])
            power = float(np.clip(slope, 0.4, 3.0))
        q *= float(np.clip((STANDS_OUT / size) ** (1.0 / power), 0.05, 20.0))
    best = min(tried, key=lambda t: abs(np.log(max(t[2], 1e-9) / STANDS_OUT)))
    return best[1], best[2]


def _at(effect: Effect, point: Mapping[str, float], q: float, scales: Scales) -> dict[str, float]:
    """The point with its amplitudes q times as far from neutral, inside the bounds."""
    return {p.name: _moved(p, point[p.name], q, scales.of(p.unit)) for p in effect.parameters}


def _moved(p: Param, value: float, q: float, scale: float) -> float:
    """One parameter q times as strong; a shape parameter stays."""
    if p.neutral is None:
        return value
    moved = (
        p.neutral * scale + q * (value - p.neutral * scale)
        if np.isfinite(p.neutral)
        else value / q
    )
    return float(np.clip(moved, p.low * scale, p.high * scale))


def _shown(base: Model, truth: Model, rich: Rich, sensors: Sensors) -> float:
    """What the refitted base cannot absorb of the effect along these motions, over the noise."""
    parts = []
    for run, noise in rich:
        problem = design(run, sensors, base.scales)
        truly = replace(problem, force=predict(truth, problem.motion))
        parts.append(triangle(base, truly, noise))
    return left(parts)
