"""What a search of effects found, as evidence for the verdict, and the same in plain sentences."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from er_model_lab.diagnosis.candidates import Candidate, effect_size
from er_model_lab.diagnosis.coverage import Coverage
from er_model_lab.diagnosis.floor_estimates import AGREE
from er_model_lab.diagnosis.noise_floor import Floor
from er_model_lab.diagnosis.passing import passes, threshold
from er_model_lab.diagnosis.rule import Rule
from er_model_lab.diagnosis.search import MOST_EFFECTS, Round
from er_model_lab.diagnosis.verdict import Evidence, Verdict
from er_model_lab.problem.problem import Problem
from er_model_lab.residual.errors import explainable

VISIBLE = 0.05
"""Share [1] of what is left, in mean square, that must lie above the floor, or that boosted trees must explain, before
anything more is looked for or something unknown is claimed."""
MUCH_MORE = 1.5
"""Error of data that only score over that of the data learnt from, from which it is said, and unlike records count."""
MUCH_LEFT = 2.0
"""Error over the noise floor from which several effects are no certain causes: they may stand for a form of one."""


def shares(before: float, after: float, floor: Floor) -> tuple[float, float]:
    """Share [1] of a mean square [N2] that is explainable, and how much of that a later model explains."""
    limit = floor.floor**2
    return (
        explainable(before, floor.floor),
        float((before - after) / max(before - limit, 1e-12 * before)),
    )


def leaves_more_than_noise(mse: float, floor: float) -> bool:
    """Whether a mean square [N2] lies visibly above the floor [N]."""
    return mse - floor**2 > VISIBLE * mse


def evidence(
    best: Candidate, first: Round, floor: Floor, beyond_fit: float, explained: float,
    ties: Sequence[Sequence[str]], cover: Coverage, unsure: tuple[str, ...], rule: Rule,
) -> Evidence:  # fmt: skip
    """What a search found of one model.

    beyond_fit: share of what the refitted model leaves that is above the floor; explained: see `shares`; unsure: see
    `diagnosis.determined.loose`.
    """
    added = len(best.effects)
    return Evidence(
        effects=added,
        explained=explained,
        without_lines=explained * (1.0 - floor.line[2]),
        too_many=bool(
            (added >= MOST_EFFECTS and leaves_more_than_noise(best.mse, floor.floor))
            or (added > 1 and np.sqrt(best.mse) > MUCH_LEFT * floor.floor)
        ),
        tied=any(len(group) > 1 for group in ties),
        loose=unsure,
        blocking=cover.blocking,
        remains=not added and _remains(first, floor, beyond_fit),
        within_errors=not added
        and (_within_errors(first, rule) is not None or _hidden(first, floor, beyond_fit)),
        unlike_sensors=not added and _unlike_sensors(best, floor),
        unlike=cover.unlike,
    )


def worse_unseen(best: Candidate, problem: Problem) -> bool:
    """Whether the model leaves much more of the data that only score than of those it was made with."""
    if not problem.held_out.any():
        return False
    left, there = (best.fit.mse(rows) for rows in (problem.train, problem.held_out))
    return bool(there > MUCH_MORE**2 * left)


def _unlike_sensors(best: Candidate, floor: Floor) -> bool:
    """Whether more is left than the white noise and the motion sensors make, and no rest or repeat shows the noise."""
    return (
        floor.measured is None and not floor.parts and np.sqrt(best.mse) > AGREE * floor.of_sensors
    )


def _remains(first: Round, floor: Floor, beyond_fit: float) -> bool:
    """Whether what is left, of which no effect was taken, comes in bursts, can be predicted, or is above the floor.

    What can be predicted counts only where more is left than rest, repeats and motion sensors show as noise.
    """
    return bool(
        _counts(first, floor.bursts, 0.0)
        or floor.line[2] > VISIBLE
        or (_predicted(first, floor, beyond_fit) and not _as_measured(first, floor))
    )


def _counts(first: Round, share: float, visible: float) -> bool:
    """Whether a share of what is left is visible, and more than the errors of the motion may cause."""
    return share > visible and share * first.base.mse > first.null.least**2


def _predicted(first: Round, floor: Floor, beyond_fit: float) -> bool:
    """Whether what is left can be predicted from the inputs, or is above the floor."""
    explained = _counts(first, floor.explained, VISIBLE)
    return explained or _counts(first, beyond_fit, 2 * VISIBLE)


def _as_measured(first: Round, floor: Floor) -> bool:
    """Whether no more is left than noise that was measured: at rest and by the motion sensors, or in repeats."""
    return floor.measured is not None and first.base.mse <= floor.measured**2


def _hidden(first: Round, floor: Floor, beyond_fit: float) -> bool:
    """Whether what can be predicted of what is left may as well be errors of the motion."""
    return _predicted(first, floor, beyond_fit) and _as_measured(first, floor)


def _within_errors(first: Round, rule: Rule) -> Candidate | None:
    """The effect that gains more than noise does, but no more than the errors of the motion may cause."""
    limit = _of_noise(first, rule)
    able = [c for c in first.candidates if passes(first.base, c, limit)]
    return max(able, key=lambda c: effect_size(first.base, c)) if able else None


def _of_noise(first: Round, rule: Rule) -> float:
    """Effect size [N] that counts if the motion is taken as exact."""
    return threshold(replace(first.null, least=0.0), float(np.sqrt(first.base.mse)), rule)


def reasons(
    verdict: Verdict, seen: Evidence, base: Candidate, best: Candidate, first: Round, floor: Floor, rule: Rule
) -> tuple[str, ...]:  # fmt: skip
    """The evidence in plain sentences, as far as the verdict rests on it."""
    left = (
        f"on training data, block by block left out: root mean square error {np.sqrt(base.mse):.3g} N after "
        f"refitting, noise floor {floor.floor:.3g} N"
    )
    if floor.learnt is not None:
        left += f" (as a rest or repeats show it; trees and filters leave {floor.learnt[0]:.3g} N unexplained)"
    if verdict == "insufficient_data" and seen.unlike:
        return (left, seen.unlike)
    if not seen.effects:
        return (left, *_reasons_of_nothing(verdict, seen, first, floor, rule))
    catalogue = best.fit.model.catalogue
    fall = (
        f"added: {', '.join(catalogue[e].title for e in best.effects)}; the error falls by "
        f"{effect_size(base, best):.3g} N, {seen.explained:.0%} of what is explainable"
    )
    open_ = [f"{catalogue[e].title}: these data do not determine its values" for e in seen.loose]
    open_ += [
        f"{catalogue[e].title}: beside another effect of heat or ageing it may stand for the form of that one"
        for e in seen.slow
    ]
    return (left, fall, *_reasons_of_effects(verdict, seen, open_))


def _reasons_of_effects(verdict: Verdict, seen: Evidence, open_: list[str]) -> tuple[str, ...]:
    """Why what was taken is not all, or not certain; open_: what is not of single effects."""
    if seen.too_many:
        return (
            f"{seen.effects} effects together leave more than noise: they may stand for another",
        )
    if verdict == "ambiguous":
        tie = ("the data cannot tell some effects apart",) if seen.tied else ()
        return (*tie, *open_, *seen.blocking)
    if verdict == "partial":
        return ("a part remains that no known effect explains",)
    if verdict == "unknown_effect":
        return (
            "what the known effects explain is too little to be the cause; to take what helps a little all the same, "
            f"set helps to {_below(seen.explained):.2g}",
        )
    return ()


def _reasons_of_nothing(
    verdict: Verdict, seen: Evidence, first: Round, floor: Floor, rule: Rule
) -> tuple[str, ...]:
    """Why nothing was taken."""
    if seen.blocking:
        return seen.blocking
    if seen.remains:
        bursts = floor.bursts * first.base.mse > first.null.least**2
        what = (
            "comes in bursts that noise does not make"
            if bursts
            else "can be predicted from the inputs"
        )
        return (f"no known effect passes, yet the residual {what}",)
    if seen.unlike_sensors:
        return (
            f"{np.sqrt(first.base.mse):.3g} N are left, the noise of the sensors makes {floor.of_sensors:.3g} N; the "
            "rest is noise of another kind, or something that neither a known effect nor trees predict: record a rest "
            "of two seconds or the same motion twice, and the noise shows",
        )
    near = _within_errors(first, rule)
    if near is None and floor.measured is not None and verdict != "adequate":
        return (
            f"a part of what is left can be predicted from the inputs, yet {np.sqrt(first.base.mse):.3g} N are left, "
            f"where rest or repeats and the errors of the motion sensors make {floor.measured:.3g} N: these "
            "errors hide whether anything is missing; a better deflection sensor, or both accelerations, would show it",
        )
    if near is None or verdict == "adequate":
        return (
            f"no effect exceeds what chance gives in a complete model ({first.threshold:.3g} N)",
        )
    title = near.fit.model.catalogue[near.name].title
    return (
        f"{title} gains {effect_size(first.base, near):.3g} N, more than noise does ({_of_noise(first, rule):.3g} N), "
        f"but the errors of the motion may cause {first.threshold:.3g} N: record both accelerations and motion that "
        "does not repeat itself",
    )


def _below(share: float) -> float:
    """A share in whole hundredths that is not above a given one."""
    return max(int(100.0 * share), 0) / 100.0
