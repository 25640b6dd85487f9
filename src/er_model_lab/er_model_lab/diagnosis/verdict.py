"""The verdict: exactly one of six, with the numbers behind it."""

from __future__ import annotations

from dataclasses import dataclass, replace
from typing import Literal

import numpy as np
from er_models.model import Model

from er_model_lab.diagnosis.candidates import Candidate, baseline, effect_size
from er_model_lab.diagnosis.coverage import Coverage, coverage
from er_model_lab.diagnosis.noise_floor import Floor, noise_floor
from er_model_lab.diagnosis.null import Null
from er_model_lab.diagnosis.rule import RULE, Rule
from er_model_lab.diagnosis.search import (
    MOST_EFFECTS,
    Round,
    one_round,
    passes,
    promising,
    prune,
    swapped,
    threshold,
    try_pairs,
)
from er_model_lab.problem.problem import Problem
from er_model_lab.residual.errors import explainable
from er_model_lab.work import STOPPED

Name = Literal[
    "adequate", "missing_effect", "ambiguous", "partial", "unknown_effect", "insufficient_data"
]

ENOUGH = 0.8
"""Share of the explainable error that a named effect must explain."""
MOST, CLEAR = 0.5, 0.15
"""Share of what is left that a further effect must explain, and the same where its size leaves no doubt."""
BEYOND_DOUBT = 1.5
"""Size, over what chance gives, of a further effect that no longer needs to explain most of what is left, and of
one that is kept beside others: they may stand for what the form of a rightly named effect lacks."""
VISIBLE = 0.05
"""Share [1] of what is left, in mean square, that must lie above the floor, or that boosted trees must explain, before
anything more is looked for or something unknown is claimed."""


@dataclass(frozen=True)
class Diagnosis:
    """Result of a diagnosis; `rounds` holds every step of the search, fewer where it was interrupted."""

    verdict: Name
    effects: tuple[str, ...]
    alternatives: tuple[tuple[str, ...], ...]
    base: Candidate
    best: Candidate
    rounds: tuple[Round, ...]
    floor: Floor
    null: Null
    explainable: float
    explained: float
    coverage: Coverage
    reasons: tuple[str, ...]
    interrupted: bool = False

    @property
    def model(self) -> Model:
        """The model with the named effects, refitted."""
        return self.best.fit.model


def diagnose(
    model: Model,
    problem: Problem,
    *,
    seed: int = 0,
    rule: Rule = RULE,
) -> Diagnosis:
    """Refit the model, then find which effects are missing and how sure that is.

    Ctrl-C, or `cancel` of the problem's work, ends the search with the effects taken so far; before there is one it
    goes to the caller.
    """
    base = baseline(model, problem)
    rounds = [one_round(base, problem, seed, rule)]
    best = rounds[0].taken or base
    floor = noise_floor(problem, _leader(rounds[0]), rounds[0].null, seed)
    try:
        best, floor, ties = _searched(best, rounds, floor, problem, seed, rule)
    except STOPPED:
        problem.work.wind_up()
        taken = [step.taken for step in rounds if step.taken is not None]
        if not taken:
            raise
        ties = _alternatives(taken[-1], rounds)
        found = judge(base, taken[-1], rounds, floor, problem, ties, rule)
        return replace(found, interrupted=True)
    return judge(base, best, rounds, floor, problem, ties, rule)


def _searched(
    best: Candidate, rounds: list[Round], floor: Floor, problem: Problem, seed: int, rule: Rule
) -> tuple[Candidate, Floor, tuple[tuple[str, ...], ...]]:  # fmt: skip
    """Further effects beside the first, those still needed, and ties; `rounds` grows."""
    best, floor = _grow(best, rounds, floor, problem, seed, rule)
    if len(best.effects) > 1:
        best = _standing(prune(best, problem, BEYOND_DOUBT * rounds[0].threshold), rounds[0])
    ties = _alternatives(best, rounds)
    if len(best.effects) > 1:
        best, ties = swapped(best, rounds, problem)
    return best, floor, ties


def shares(before: float, after: float, floor: Floor) -> tuple[float, float]:
    """Share [1] of a mean square [N2] that is explainable, and how much of that a later model explains."""
    limit = floor.floor**2
    return (
        explainable(before, floor.floor),
        float((before - after) / max(before - limit, 1e-12 * before)),
    )


def _standing(best: Candidate, first: Round) -> Candidate:
    """What is left of several effects; where one is, only if it passes by itself, else what the first round took."""
    if len(best.effects) > 1 or passes(first.base, best, first.threshold):
        return best
    return first.taken or first.base


def judge(
    base: Candidate, best: Candidate, rounds: list[Round], floor: Floor, problem: Problem,
    ties: tuple[tuple[str, ...], ...] = (), rule: Rule = RULE,
) -> Diagnosis:  # fmt: skip
    """The verdict on what a search found; ties: groups that the data cannot tell apart."""
    cover = coverage(problem)
    to_explain, explained = shares(base.mse, best.mse, floor)
    beyond_fit = explainable(min(base.mse, base.fit.mse(problem.train)), floor.floor)
    name, reasons = _decide(base, best, rounds, floor, beyond_fit, explained, ties, cover, rule)
    if name in ("adequate", "insufficient_data", "unknown_effect"):
        best, ties = base, ()
    return Diagnosis(
        name, best.effects, ties, base, best, tuple(rounds), floor, rounds[0].null, to_explain,
        explained if best is not base else 0.0, cover, tuple(reasons),
    )  # fmt: skip


def _leader(step: Round) -> Candidate:
    """The candidate that gains most in a round, or its beginning: no more than its fit gains is believed."""
    return max([step.base, *step.candidates], key=lambda c: effect_size(step.base, c))


def _grow(
    best: Candidate, rounds: list[Round], floor: Floor, problem: Problem, seed: int, rule: Rule
) -> tuple[Candidate, Floor]:  # fmt: skip
    """Add further effects while each explains most of what is left; `rounds` grows, also where it is interrupted."""
    first = rounds[0]
    while best.effects and len(best.effects) < MOST_EFFECTS:
        left = best.mse - floor.floor**2
        nothing = left < VISIBLE * best.mse and floor.explained <= VISIBLE
        if nothing and not promising(best, rounds[-1], problem):
            break
        step = one_round(best, problem, seed + len(rounds), rule)
        leader = _leader(step)
        deeper = noise_floor(problem, leader, step.null, seed)
        floor = deeper if deeper.floor < floor.floor else floor
        if step.taken is None:
            break
        if not worth(step, floor):
            break
        rounds.append(step)
        best = step.taken
    explained = (first.base.mse - best.mse) / max(first.base.mse - floor.floor**2, 1e-300)
    if (
        explained < ENOUGH
        and explained >= 0.0
        and len(best.effects) < 2
        and floor.explained > VISIBLE
    ):
        target = first.base.mse - ENOUGH * (first.base.mse - floor.floor**2)
        pair = try_pairs(first, problem, target)
        if pair is not None:
            best = pair
    return best, floor


def worth(step: Round, floor: Floor) -> bool:
    """Whether what a round took explains enough of what was left to be named.

    That is most of it, or a good part beyond any doubt: the floor is a lower bound, so that the share looks too small.
    """
    assert step.taken is not None
    share = (step.base.mse - step.taken.mse) / max(step.base.mse - floor.floor**2, 1e-300)
    sure = effect_size(step.base, step.taken) > BEYOND_DOUBT * step.threshold
    return share >= (CLEAR if sure else MOST)


def _alternatives(best: Candidate, rounds: list[Round]) -> tuple[tuple[str, ...], ...]:
    """Groups the data cannot tell apart, for the effects that were kept; two that are both needed are no rivals."""
    groups = []
    for step in rounds:
        if step.taken is None or step.taken.name not in best.effects:
            continue
        group = [n for n in step.ties if n == step.taken.name or n not in best.effects]
        if len(group) > 1:
            groups.append(tuple(group))
    return tuple(groups)


def _decide(
    base: Candidate, best: Candidate, rounds: list[Round], floor: Floor, explainable: float, explained: float,
    ties: tuple[tuple[str, ...], ...], cover: Coverage, rule: Rule,
) -> tuple[Name, list[str]]:  # fmt: skip
    """The verdict and its reasons in plain sentences."""
    size = effect_size(base, best)
    reasons = [
        f"root mean square error {np.sqrt(base.mse):.3g} N after refitting, noise floor {floor.floor:.3g} N"
    ]
    if not best.effects:
        name, why = _without(rounds[0], floor, explainable, cover, rule)
        return name, reasons + why
    line_share = floor.line[2]
    explained_all = explained * (1.0 - line_share)
    reasons.append(
        f"added: {', '.join(best.fit.model.catalogue[e].title for e in best.effects)}; "
        f"the error falls by {size:.3g} N, {explained:.0%} of what is explainable"
    )
    if len(best.effects) >= MOST_EFFECTS and best.mse - floor.floor**2 > VISIBLE * best.mse:
        reasons.append(
            f"{len(best.effects)} effects together leave more than noise: they may stand for another"
        )
        return "partial", reasons
    if explained_all >= ENOUGH:
        if any(len(group) > 1 for group in ties):
            said = "the data cannot tell some effects apart"
            return "ambiguous", [*reasons, said, *cover.blocking]
        if cover.blocking:
            return "ambiguous", reasons + list(cover.blocking)
        return "missing_effect", reasons
    if explained >= rule.helps:
        reasons.append("a part remains that no known effect explains")
        return "partial", reasons
    reasons.append(
        "what the known effects explain is too little to be the cause; to take what helps a little all the same: "
        f"--helps {_below(explained):.2g}"
    )
    return "unknown_effect", reasons


def _without(
    step: Round, floor: Floor, explainable: float, cover: Coverage, rule: Rule
) -> tuple[Name, list[str]]:
    """The verdict where no effect was taken, and why."""
    if cover.blocking:
        return "insufficient_data", list(cover.blocking)
    least = step.null.least
    bursts = floor.bursts * step.base.mse > least**2
    predicted = floor.explained > VISIBLE and floor.explained * step.base.mse > least**2
    unexplained = explainable > 2 * VISIBLE and explainable * step.base.mse > least**2
    if not (bursts or predicted or unexplained or floor.line[2] > VISIBLE):
        if why := _within_errors(step, rule):
            return "insufficient_data", [why]
        return "adequate", [
            f"no effect exceeds what chance gives in a complete model ({step.threshold:.3g} N)"
        ]
    what = (
        "comes in bursts that noise does not make"
        if bursts
        else "can be predicted from the inputs"
    )
    return "unknown_effect", [f"no known effect passes, yet the residual {what}"]


def _within_errors(step: Round, rule: Rule) -> str | None:
    """What is said where an effect gains more than noise does, but no more than the errors of the motion may cause."""
    limit = threshold(replace(step.null, least=0.0), float(np.sqrt(step.base.mse)), rule)
    able = [c for c in step.candidates if passes(step.base, c, limit)]
    if not able:
        return None
    best = max(able, key=lambda c: effect_size(step.base, c))
    title = best.fit.model.catalogue[best.name].title
    return (
        f"{title} gains {effect_size(step.base, best):.3g} N, more than noise does ({limit:.3g} N), but the errors of "
        f"the motion may cause {step.threshold:.3g} N: record both accelerations and motion that does not repeat itself"
    )


def _below(share: float) -> float:
    """A share in whole hundredths that is not above a given one."""
    return max(int(100.0 * share), 0) / 100.0
