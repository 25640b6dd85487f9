"""One question to one problem: which effects does a model lack? Search, noise floor, ties, and the verdict on them."""

from __future__ import annotations

import itertools
from dataclasses import replace

from er_models.model import Model

from er_model_lab.diagnosis import decisive_round
from er_model_lab.diagnosis.candidates import Candidate, baseline, effect_size, refit
from er_model_lab.diagnosis.clock import clock_ties, second_clocks
from er_model_lab.diagnosis.coverage import coverage, stays_unlike
from er_model_lab.diagnosis.determined import at_end, loose
from er_model_lab.diagnosis.evidence import VISIBLE, evidence, reasons, shares, worse_unseen
from er_model_lab.diagnosis.floor_estimates import AGREE, credible
from er_model_lab.diagnosis.found import Diagnosis
from er_model_lab.diagnosis.noise_floor import Floor, bounded, noise_floor
from er_model_lab.diagnosis.null import Null, simulate_null
from er_model_lab.diagnosis.passing import passes, there, threshold
from er_model_lab.diagnosis.rule import RULE, Rule
from er_model_lab.diagnosis.search import (
    MOST_EFFECTS,
    Round,
    afresh,
    close,
    decided,
    one_round,
    promising,
    prune,
    swapped,
    taken_in,
    try_pairs,
)
from er_model_lab.diagnosis.special_cases import as_one, plain
from er_model_lab.diagnosis.verdict import ENOUGH, NOTHING_NAMED, decide
from er_model_lab.problem.problem import Problem
from er_model_lab.residual.errors import explainable
from er_model_lab.work import STOPPED

MOST, CLEAR = 0.5, 0.15
"""Share of what is left that a further effect must explain, and the same where its size leaves no doubt."""
BEYOND_DOUBT = 1.5
"""Size, over what chance gives, of a further effect that no longer needs to explain most of what is left, and of
one that is kept beside others: they may stand for what the form of a rightly named effect lacks."""

MISSED = 1.5
"""Error without the effects that pruning took out, over that with them, from which on others are looked for."""
PART_OF = 0.5
"""Share of what an effect explains alone below which, beside one that explains as much, it may be but another form."""


def search_effects(
    model: Model, problem: Problem, *, seed: int = 0, rule: Rule = RULE, known: Candidate | None = None,
    begun: Round | None = None,
) -> Diagnosis:  # fmt: skip
    """Refit the model, then find which effects are missing and how sure that is.

    known: the model where it is fitted to the problem already. begun: the `further` of a diagnosis of the same problem
    whose best model this is: what was tried is not tried again.

    Ctrl-C, or `cancel` of the problem's work, ends the search with the effects taken so far; before there is one it
    goes to the caller.
    """
    if begun is None:
        begun = one_round(known or baseline(model, problem), problem, seed, rule)
    elif rule.small_steps or rule.barred:
        begun = decided(begun.base, begun.candidates, begun.null, problem, rule)
    base, rounds = begun.base, [begun]
    best = begun.taken or base
    floor = _floor(problem, rounds[0].candidates, _leader(rounds[0]), rounds[0].null, seed)
    able = [base, *(c for c in begun.candidates if not at_end(c))]
    if stays_unlike(problem, [c.fit.residual for c in able]):
        # the verdict is that, whatever else is found
        return judge(base, best, rounds, floor, problem, (), rule)
    try:
        best, floor, ties, further = _searched(best, rounds, floor, problem, seed, rule)
    except STOPPED:
        problem.work.wind_up()
        taken = [step.taken for step in rounds if step.taken is not None]
        if not taken:
            raise
        ties = _alternatives(taken[-1], rounds)
        found = judge(base, taken[-1], rounds, floor, problem, ties, rule)
        return replace(found, interrupted=True)
    found = judge(base, best, rounds, floor, problem, ties, rule)
    same = further is not None and further.base is found.best
    return replace(found, further=afresh(further) if further and same else None)


def one_effect(
    model: Model, problem: Problem, effect: str | None, seed: int, known: Candidate | None = None
) -> Diagnosis:
    """Diagnosis that considers one effect (or none) only; known: the model, fitted to the problem already."""
    base = known or baseline(model, problem)
    tried = [refit(base, model.catalogue[effect], problem, max_iter=20)] if effect else []
    null = simulate_null(base, tried, problem, seed)
    floor = _floor(problem, tried, min([base, *tried], key=lambda c: c.mse), null, seed)
    limit = threshold(null, floor.floor)
    able = [c for c in tried if there(base, c, problem, limit)]
    step = Round(base, tried, null, limit, able[0] if able else None, [])
    found = judge(base, able[0] if able else base, [step], floor, problem)
    return replace(found, best=tried[0]) if tried else found


def _searched(
    best: Candidate, rounds: list[Round], floor: Floor, problem: Problem, seed: int, rule: Rule
) -> tuple[Candidate, Floor, tuple[tuple[str, ...], ...], Round | None]:  # fmt: skip
    """Further effects beside the first, those still needed, ties, and the round none was taken of; `rounds` grows.

    The threshold of the first round takes effects out. Where that leaves much more, the search goes on without them.
    """
    best, floor, further = _grow(best, rounds, floor, problem, seed, rule)
    if len(best.effects) > 1:
        kept = _standing(prune(best, problem, BEYOND_DOUBT * rounds[0].threshold), rounds[0])
        if kept.effects and kept.mse > MISSED**2 * best.mse:
            # what was taken before all others were there did much, but something else may do it better
            best, floor, further = _grow(kept, rounds, floor, problem, seed, rule)
        else:
            best = kept
    best, earned = as_one(best, rounds, problem, rule)
    ties = _alternatives(best, rounds)
    if len(best.effects) > 1:
        whole, groups = swapped(best, rounds, problem)
        # what stands in for effects that are still missing looks better than what is there
        if whole is best or not (rule.goes_on and _incomplete(best, floor, further)):
            best, ties = whole, groups
        ties = (*ties, *halves(best, rounds, ties))
    best, special = plain(best, problem, rounds[-1].threshold, earned)
    ties = (*ties, *special)
    return best, floor, (*ties, *clock_ties(best, rounds, ties, problem)), further


def _incomplete(best: Candidate, floor: Floor, further: Round | None) -> bool:
    """Whether a further effect passes beside a model that leaves more than the floor."""
    passed = further is not None and further.taken is not None
    return passed and best.mse > (AGREE * floor.floor) ** 2


def halves(
    best: Candidate, rounds: list[Round], known: tuple[tuple[str, ...], ...]
) -> tuple[tuple[str, ...], ...]:
    """Pairs of effects of a model that may be one effect, of a form that neither has; known: groups tied anyhow.

    Each alone explained nearly the same, so that what the second explains beside the first is little of that.
    """
    found = []
    for (first, step), (second, later) in itertools.combinations(taken_in(rounds).items(), 2):
        assert later.taken is not None
        if not {first, second} <= set(best.effects) or second not in close(step):
            continue
        if any({first, second} <= set(group) for group in known):
            continue
        alone = next(c for c in step.candidates if c.name == second)
        if effect_size(later.base, later.taken) < PART_OF * effect_size(step.base, alone):
            found.append((first, second))
    return tuple(found)


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
    unsure = loose(best, problem)
    seen = evidence(best, rounds[0], floor, beyond_fit, explained, ties, cover, unsure, rule)
    seen = replace(seen, slow=second_clocks(best), worse_unseen=worse_unseen(best, problem))
    verdict = decide(seen, rule)
    why = reasons(verdict, seen, base, best, rounds[0], floor, rule)
    if verdict in NOTHING_NAMED:
        best, ties = base, ()
    if verdict == "insufficient_data" and cover.unlike:
        cover = replace(cover, blocking=(*cover.blocking, cover.unlike))
    found = Diagnosis(
        verdict, best.effects, ties, base, best, tuple(rounds), floor, rounds[0].null, to_explain,
        explained if best is not base else 0.0, cover, why, seen,
    )  # fmt: skip
    return replace(found, beside=decisive_round.beside(found, problem))


def _floor(
    problem: Problem, tried: list[Candidate], leader: Candidate, null: Null, seed: int
) -> Floor:
    """The floor that counts under what the leader of a round leaves; tried: all that were."""
    floor = credible(noise_floor(problem, leader, null, seed), problem, leader.fit.residual)
    return bounded(floor, tried, problem)


def _leader(step: Round) -> Candidate:
    """The candidate that gains most in a round, or its beginning: no more than its fit gains is believed."""
    return max([step.base, *step.candidates], key=lambda c: effect_size(step.base, c))


def _grow(
    best: Candidate, rounds: list[Round], floor: Floor, problem: Problem, seed: int, rule: Rule
) -> tuple[Candidate, Floor, Round | None]:  # fmt: skip
    """Add further effects while each explains most of what is left; `rounds` grows, also where it is interrupted.

    The last round is given beside where nothing was taken of it.
    """
    first, further = rounds[0], None
    while best.effects and len(best.effects) < MOST_EFFECTS:
        left = best.mse - floor.floor**2
        nothing = left < VISIBLE * best.mse and floor.explained <= VISIBLE
        if nothing and not promising(best, rounds[-1], problem):
            break
        step = one_round(best, problem, seed + len(rounds), rule, rounds[-1])
        leader = _leader(step)
        tried = [c for each in (*rounds, step) for c in each.candidates]
        deeper = _floor(problem, tried, leader, step.null, seed)
        floor = deeper if deeper.floor < floor.floor else bounded(floor, tried, problem)
        if step.taken is None or not worth(step, floor):
            further = step
            break
        rounds.append(step)
        best = step.taken
    explained = (first.base.mse - best.mse) / max(first.base.mse - floor.floor**2, 1e-300)
    if (
        not rule.small_steps
        and explained < ENOUGH
        and explained >= 0.0
        and len(best.effects) < 2
        and floor.explained > VISIBLE
    ):
        target = first.base.mse - ENOUGH * (first.base.mse - floor.floor**2)
        pair = try_pairs(first, problem, target)
        if pair is not None:
            best = pair
    return best, floor, further


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
