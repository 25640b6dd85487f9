"""The plan: search, the lab's own refits of the best few, its decisions on simulated measurements, the verdict."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from typing import Literal

from er_model_lab.diagnosis.candidates import made_ready
from er_model_lab.planning import motions_and_duties
from er_model_lab.planning.finalist import Finalist, finalist
from er_model_lab.planning.limits import Limits, Sensors, nothing_fits
from er_model_lab.planning.piece import Bench, Tried, judged, scaled, separations
from er_model_lab.planning.question import Question
from er_model_lab.planning.search import best_sets, directions, refined, tried_menu, typical
from er_model_lab.planning.segment import Segment
from er_model_lab.planning.setup import bench_for
from er_model_lab.planning.simulated_decision import Outcome, outcomes
from er_model_lab.problem.forward import free_parameters
from er_model_lab.problem.problem import Problem
from er_model_lab.work import HERE, Work

COST = 30.0
"""Work of a plan on one core [s], some 150 pieces of programs and the lab's decisions on the best."""
SETS = 4
REFINED = 2
MEASUREMENTS = 5
"""Simulated measurements for every truth, of a model of up to `LIGHT` parameters; fewer of larger ones."""
LIGHT = 12
CLOSE = 0.5
"""Share of the first program's separation from which the second is tried where the lab fails on the first."""
SURE = 0.8
"""Share of them in which the lab must name the truth."""
RAISED = {"stroke": 2.0, "velocity": 2.0, "duty": 2.0}
"""Limits that are raised in thought, and by how much, where nothing within them tells the effects apart."""
LONGER = 6.0
EVERYDAY = "identification"

Verdict = Literal["told_apart", "one_way", "not_told_apart"]


@dataclass(frozen=True)
class Raised:
    """One limit raised by a factor, and the separations that would give, by truth."""

    limit: str
    factor: float
    separations: dict[str, float]


@dataclass(frozen=True)
class Plan:
    """The programs, best first, and what the lab would decide on the best and on the everyday one.

    counted: truths that some program tells from the other explanation.
    """

    bench: Bench
    counted: tuple[str, ...]
    finalists: tuple[Finalist, ...]
    everyday: Finalist | None
    outcomes: dict[str, Outcome]
    everyday_outcomes: dict[str, Outcome]
    verdict: Verdict
    raised: tuple[Raised, ...]

    @property
    def question(self) -> Question:
        """What was asked."""
        return self.bench.rivals.question

    @property
    def best(self) -> Finalist:
        """The program that is proposed."""
        return self.finalists[0]


def planned(
    question: Question, limits: Limits, sensors: Sensors, *, problem: Problem | None = None, seed: int = 0,
    work: Work = HERE,
) -> Plan:  # fmt: skip
    """The programs that would tell the effects of a question apart best, within the limits.

    problem: what is already measured; the effects are then as strong as they are fitted to it. work: how it is done.
    """
    work.expect(COST, made_ready, question.base)
    bench = replace(bench_for(question, limits, sensors, problem, seed), work=work)
    pieces = tried_menu(bench)
    if not any(p.segment.seconds <= limits.duration for p in pieces):
        raise nothing_fits(limits)
    counted = directions(pieces)
    ranked = sorted(
        _finalists(pieces, counted, bench), key=lambda f: -round(f.separation(counted), 2)
    )
    everyday = _everyday(bench)
    decided = [_decisions(f, bench) for f in ranked[:1]]
    if _verdict(decided[0] if decided else {}) != "told_apart" and _rivalled(ranked, counted):
        decided.append(_decisions(ranked[1], bench))
        if _right(decided[1]) > _right(decided[0]):
            ranked[:2], decided = ranked[1::-1], decided[::-1]
    ranked = [replace(f, name=f"program {k + 1}") for k, f in enumerate(ranked)]
    verdict = _verdict(decided[0]) if decided else "not_told_apart"
    return Plan(
        bench=bench, counted=counted, finalists=tuple(ranked), everyday=everyday,
        outcomes=decided[0] if decided else {},
        everyday_outcomes=_decisions(everyday, bench) if everyday else {},
        verdict=verdict,
        raised=() if verdict == "told_apart" else tuple(_raised(bench, counted, ranked)),
    )  # fmt: skip


def _rivalled(ranked: Sequence[Finalist], counted: Sequence[str]) -> bool:
    """Whether the second program separates nearly as well as the first."""
    return len(ranked) > 1 and ranked[1].separation(counted) > CLOSE * ranked[0].separation(
        counted
    )


def _finalists(
    pieces: Sequence[Tried], counted: Sequence[str], bench: Bench
) -> Iterator[Finalist]:
    """The best sets of pieces, the first ones refined, as whole programs within the limits."""
    sets = best_sets(pieces, counted, SETS, bench.limits.duration)
    better = [refined(s, bench, counted) for s in sets[:REFINED]]
    whole = [[p.segment for p in chosen] for chosen in [*better, *sets[REFINED:]]]
    for found in bench.work.map(_refitted, whole, bench, stage="whole programs"):
        if found is not None:
            yield found


def _refitted(segments: list[Segment], bench: Bench) -> Finalist | None:
    """`finalist` as a job."""
    return finalist("program", segments, bench)


def _everyday(bench: Bench) -> Finalist | None:
    """The program by which a damper is identified, as large as the limits allow."""
    ready = scaled(motions_and_duties.everyday(bench.limits), bench)
    return None if ready is None else finalist(EVERYDAY, [ready[0]], bench)


def _decisions(found: Finalist, bench: Bench) -> dict[str, Outcome]:
    """The lab's decisions on simulated measurements of a program."""
    size = max(len(free_parameters(m)) for m in bench.rivals.truths.values())
    runs = max(2, round(MEASUREMENTS * min(1.0, LIGHT / size)))
    seeds = range(bench.seed, bench.seed + runs)
    return outcomes(bench.rivals.question, found.runs, bench.sensors, seeds, bench.work)


def _right(decided: dict[str, Outcome]) -> int:
    """How often the truth was named, over all truths."""
    return sum(o.right for o in decided.values())


def _verdict(decided: dict[str, Outcome]) -> Verdict:
    """Whether the lab names every truth, some, or none."""
    sure = [o.right >= SURE * o.runs for o in decided.values()]
    return "told_apart" if all(sure) else "one_way" if any(sure) else "not_told_apart"


def _raised(bench: Bench, counted: Sequence[str], ranked: Sequence[Finalist]) -> Iterator[Raised]:
    """What raising one limit would give, by the linear estimate."""
    for name, factor in RAISED.items():
        limits = bench.limits.raised(name, factor)
        if limits != bench.limits:
            other = replace(bench, limits=limits)
            sets = best_sets(typical(other), counted, 1, limits.duration)
            if sets:
                yield Raised(
                    name, getattr(limits, name) / getattr(bench.limits, name), separations(sets[0])
                )
    if ranked:
        segments = [motions_and_duties.longer(s, LONGER) for s in ranked[0].segments]
        pieces = [p for s in segments if (p := judged(s, bench)) is not None]
        if pieces:
            yield Raised("duration", LONGER, separations(pieces))
