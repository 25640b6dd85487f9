"""The verdict: exactly one of six, decided here and nowhere else.

`Evidence` holds all that a verdict rests on; `decide` is a pure function of it. Who gathers it: `evidence.py` from a
search of effects, `level/damper.py` for a lag that the motion sensors show, `results/passes.py` from several searches.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Literal

from er_model_lab.diagnosis.rule import RULE, Rule

Verdict = Literal[
    "adequate", "missing_effect", "ambiguous", "partial", "unknown_effect", "insufficient_data"
]
SETTLED: tuple[Verdict, ...] = ("adequate", "missing_effect", "ambiguous")
"""Verdicts after which the model with the effects that were named lacks nothing."""
NOTHING_NAMED: tuple[Verdict, ...] = ("adequate", "insufficient_data", "unknown_effect")
"""Verdicts that add nothing to the model."""

ENOUGH = 0.8
"""Share of the explainable error that named effects must explain."""


@dataclass(frozen=True)
class Earlier:
    """What earlier searches leave open: a tie, or so many effects that they describe the data and are no cause."""

    tied: bool
    too_many: bool


@dataclass(frozen=True)
class Evidence:
    """All that a verdict rests on.

    effects: how many were taken; explained: share [1] of the explainable error that they explain, and
    `without_lines` the same less what a spectral line hides; too_many: they are as many as a search takes and leave
    more than noise, or several and leave much more; tied: the data cannot tell some of them apart; loose: effects
    whose values the data do not determine; slow: effects of heat and ageing beside another, which may be one slow
    change of another form; blocking: what the data lack, in sentences; remains: that something unknown is left
    where no effect was taken; within_errors: that an effect gains more than noise does, or that trees predict a
    part of what is left, but no more than the errors of the motion may cause; unlike_sensors: that more is left
    than the sensors' noise makes, and no rest or repeat says whether that is noise; unlike: how the force of two
    records differs at the same motion, or '': what all share explains no such thing, unless it explains all;
    worse_unseen: that the model leaves much more of the data that only score than of those it was made with;
    with_lag: share explained where the velocity channel was found to lag, which the sensors show whatever the force
    does; earlier: searches of which this one is the last.
    """

    effects: int
    explained: float
    without_lines: float
    too_many: bool
    tied: bool
    blocking: tuple[str, ...]
    remains: bool
    within_errors: bool
    unlike_sensors: bool = False
    unlike: str = ""
    worse_unseen: bool = False
    loose: tuple[str, ...] = ()
    slow: tuple[str, ...] = ()
    with_lag: float | None = None
    earlier: Earlier | None = None


def decide(seen: Evidence, rule: Rule = RULE) -> Verdict:
    """The verdict."""
    verdict = _on_effects(seen, rule) if seen.effects else _on_nothing(seen)
    if seen.unlike and (seen.worse_unseen or verdict not in ("adequate", "missing_effect")):
        verdict = "insufficient_data"
    if seen.with_lag is not None:
        verdict = _on_lag(verdict, seen.with_lag, rule)
    if seen.earlier is not None:
        verdict = _on_all_searches(verdict, seen.earlier)
    return verdict


def _on_effects(seen: Evidence, rule: Rule) -> Verdict:
    """Where effects were taken: do they explain enough, and could others?"""
    if seen.too_many:
        return "partial"
    if seen.without_lines >= ENOUGH:
        unsure = seen.tied or seen.loose or seen.slow or seen.blocking
        return "ambiguous" if unsure else "missing_effect"
    return "partial" if seen.explained >= rule.helps else "unknown_effect"


def _on_nothing(seen: Evidence) -> Verdict:
    """Where no effect was taken: is nothing missing, or can nobody know?"""
    if seen.blocking:
        return "insufficient_data"
    if seen.remains:
        return "unknown_effect"
    return "insufficient_data" if seen.within_errors or seen.unlike_sensors else "adequate"


def _on_lag(verdict: Verdict, explained: float, rule: Rule) -> Verdict:
    """With a lag of the velocity channel as first effect: it is certain, and makes up for nothing else."""
    if verdict == "adequate":
        return "missing_effect"
    if verdict == "insufficient_data":
        return "ambiguous"
    if verdict == "unknown_effect" and explained >= rule.helps:
        return "partial"
    return verdict


def _on_all_searches(last: Verdict, earlier: Earlier) -> Verdict:
    """On all that several searches added: a tie of any of them leaves the whole unsure."""
    if earlier.too_many:
        return "partial"
    if last in ("adequate", "missing_effect"):
        return "ambiguous" if earlier.tied else "missing_effect"
    return "ambiguous" if last == "ambiguous" else "partial"
