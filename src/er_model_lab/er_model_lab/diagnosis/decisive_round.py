"""Which round of a search speaks for each candidate: the one that took it, and for what none took the first."""

from __future__ import annotations

from dataclasses import replace

from er_model_lab.diagnosis.candidates import Candidate, roughly_without
from er_model_lab.diagnosis.found import Diagnosis
from er_model_lab.diagnosis.search import Round, close, taken_in
from er_model_lab.fitting.fit import summed_up
from er_model_lab.problem.problem import Problem


def told(found: Diagnosis) -> list[tuple[Candidate, Round]]:
    """Every candidate once, with the round whose numbers are told of it."""
    firsts: dict[str, Round] = {}
    for step in found.rounds:
        for candidate in step.candidates:
            firsts.setdefault(candidate.name, step)
    return [_told(name, first, found) for name, first in firsts.items()]


def _told(name: str, first: Round, found: Diagnosis) -> tuple[Candidate, Round]:
    """A candidate and the round that speaks for it; first: the one that tried it first."""
    step = spoken(name, found) or deciding(name, found) or first
    return next(c for c in step.candidates if c.name == name), step


def deciding(name: str, found: Diagnosis) -> Round | None:
    """The round that took an effect, one that it is tied with, or one that it was exchanged for."""
    alike = {name, *(n for group in found.alternatives if name in group for n in group)}
    if name not in found.effects and len(alike) == 1:
        return None
    tried = {
        k: s
        for k, s in taken_in(found.rounds).items()
        if any(c.name == name for c in s.candidates)
    }
    for other in (name, *sorted(alike)):
        if other in tried:
            return tried[other]
    gone = (s for k, s in tried.items() if k not in found.effects)
    return next((s for s in gone if alike & {*s.ties, *close(s)}), None)


def spoken(name: str, found: Diagnosis) -> Round | None:
    """The round of `beside` that speaks for an effect, where there is one."""
    return next((s for s in found.beside if s.taken and s.taken.name == name), None)


def beside(found: Diagnosis, problem: Problem) -> tuple[Round, ...]:
    """Rounds that speak for effects that none took: those of a pair, and what came in the place of another effect.

    Each says what the effect gains beside all others of the model.
    """
    names = [name for name in found.effects if deciding(name, found) is None]
    return tuple(_beside(name, found, problem) for name in names)


def _beside(name: str, found: Diagnosis, problem: Problem) -> Round:
    """The round in which an effect would have come last."""
    best, tried = found.best, [c for s in found.rounds for c in s.candidates]
    own = next((c for c in tried if c.name == name), best)
    rest = {*best.effects} - {name}
    fitted = (c for c in tried if {*c.effects} == rest and not c.ranked)
    base = next(fitted, None) or roughly_without(name, problem, best)
    base = replace(base, fit=summed_up(base.fit, base.fit.model))
    taken = replace(best, effects=(*base.effects, name), kept=own.kept, reach=own.reach)
    return replace(found.rounds[-1], base=base, candidates=[taken], taken=taken, ties=[])
