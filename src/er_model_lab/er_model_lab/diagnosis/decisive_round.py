"""Which round of a search speaks for each candidate: the one that took it, and for what none took the first."""

from __future__ import annotations

from dataclasses import replace

from er_model_lab.diagnosis.candidates import Candidate
from er_model_lab.diagnosis.investigation import Diagnosis
from er_model_lab.diagnosis.search import Round, close, taken_in


def told(found: Diagnosis) -> list[tuple[Candidate, Round]]:
    """Every candidate once, with the round whose numbers are told of it."""
    firsts: dict[str, Round] = {}
    for step in found.rounds:
        for candidate in step.candidates:
            firsts.setdefault(candidate.name, step)
    return [_told(name, first, found) for name, first in firsts.items()]


def _told(name: str, first: Round, found: Diagnosis) -> tuple[Candidate, Round]:
    """A candidate and the round that speaks for it; first: the one that tried it first."""
    step = deciding(name, found)
    if step is None and name in found.best.effects and len(found.best.effects) == 2:
        return beside(name, first, found.best)
    step = step or first
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


def beside(name: str, first: Round, best: Candidate) -> tuple[Candidate, Round]:
    """An effect of a pair that no round took: what it gains beside the other one, which alone was not enough."""
    (other,) = (n for n in best.effects if n != name)
    singles = {c.name: c for c in first.candidates}
    own, alone = singles[name], singles[other]
    candidate = replace(best, effects=(other, name), kept=own.kept, reach=own.reach)
    return candidate, replace(first, base=alone, candidates=[candidate], taken=candidate, ties=[])
