"""Why a program tells two effects apart, in plain sentences."""

from __future__ import annotations

import math

from er_model_lab.output.text.units import discrete, percent, where
from er_model_lab.planning.finalist import Direction, Finalist, clean_problem
from er_model_lab.planning.planner import RAISED, SURE, Plan
from er_model_lab.planning.segment import in_words
from er_model_lab.residual.excess import region_tables
from er_model_lab.residual.region import Region

WOULD_DO = 0.3
"""Separation that is enough for a limit to be worth raising."""
UNITS = {"stroke": "m", "velocity": "m/s", "duty": "", "duration": "s"}
NO_PLACE = ("time", "work done", "frequency")
"""Quantities that are no place in the range of the damper."""
NOTABLE = 0.1
"""Concentration s log(s / t) from which a region is worth naming."""


def sentences(plan: Plan) -> list[str]:
    """What is to be done, what it shows where, what the everyday program would show, what limits it."""
    if not plan.finalists:
        return ["No program of the menu moves the damper within the limits.", *_raising(plan)]
    out = [_result(plan), _marks(plan), _pieces(plan.best)]
    out += [_where(plan, name) for name in plan.counted]
    out += _one_sided(plan) + _everyday(plan)
    return [s for s in [*out, *_raising(plan)] if s]


def title(plan: Plan, name: str | None) -> str:
    """An effect as a reader would call it; None: its absence."""
    return "the model without it" if name is None else plan.question.effect(name).title


def rival(plan: Plan, truth: str) -> str | None:
    """The explanation that imitates a truth; None: the model without any."""
    others = [n for n in plan.question.names if n != truth]
    return others[0] if others else None


def _result(plan: Plan) -> str:
    """How far imitations are off, and how often the lab names the truth."""
    right, runs = (sum(getattr(o, k) for o in plan.outcomes.values()) for k in ("right", "runs"))
    far = min(plan.best.directions[n].separation for n in plan.counted)
    return (
        f"What the best imitation leaves is {far:.2g} times the noise; the lab names the truth in "
        f"{right} of {runs} simulated measurements."
    )


def _marks(plan: Plan) -> str:
    """How each effect shows itself."""
    marks = [
        f"{title(plan, n)}: {plan.question.effect(n).signature.mark}" for n in plan.question.names
    ]
    return "; ".join(marks) + "."


def _pieces(best: Finalist) -> str:
    """The pieces of the program."""
    cycle = sum(s.seconds for s in best.segments)
    parts = "; ".join(in_words(s) for s in best.segments)
    return f"The program repeats every {cycle:.3g} s: {parts}."


def _where(plan: Plan, truth: str) -> str:
    """Where in the damper's range the imitation fails."""
    d = plan.best.directions[truth]
    place = _place(plan, truth, d)
    other = title(plan, rival(plan, truth))
    return (
        f"If {title(plan, truth)} is true, the best fit of {other} leaves {d.gap:.3g} N of it "
        f"({d.separation:.2g} times the noise of {d.floor:.2g} N){place}."
    )


def _place(plan: Plan, truth: str, d: Direction) -> str:
    """The region in which the difference is concentrated most, as a clause."""
    problem = clean_problem(plan.best.runs[truth], plan.bench.sensors)
    tables = region_tables(problem, d.difference, plan.bench.seed)
    found = [(r, t) for t in tables if t.quantity not in NO_PLACE for r in t.regions]
    if not found:
        return ""
    region, table = max(found, key=lambda pair: _concentration(pair[0]))
    if _concentration(region) < NOTABLE:
        return ""
    place = where(region, single=discrete(table.regions))
    return f", {percent(region.share)} of its square at {place} in {percent(region.of_samples)} of the time"


def _concentration(r: Region) -> float:
    """How much more of the difference lies in a region than its share of the time: s log(s / t)."""
    return r.share * math.log(max(r.share, 1e-12) / max(r.of_samples, 1e-12))


def _one_sided(plan: Plan) -> list[str]:
    """Where one effect contains the other, nothing can be shown if the simpler is true."""
    out = []
    for truth in plan.question.names:
        if truth in plan.counted:
            continue
        outcome = plan.outcomes.get(truth)
        said = (
            "the lab then names the simpler one"
            if outcome and outcome.right >= SURE * outcome.runs
            else "a measurement then stays open"
        )
        other = title(plan, rival(plan, truth))
        out.append(f"If {title(plan, truth)} is true, {other} imitates it completely: {said}.")
    return out


def _everyday(plan: Plan) -> list[str]:
    """What the program by which dampers are identified would show."""
    if plan.everyday is None:
        return []
    far = min(plan.everyday.directions[n].separation for n in plan.counted)
    right = sum(o.right for o in plan.everyday_outcomes.values())
    runs = sum(o.runs for o in plan.everyday_outcomes.values())
    planned = sum(o.right for o in plan.outcomes.values())
    enough = ", as good as it needs to be" if right >= max(planned, SURE * runs) else ""
    return [
        f"A random road with random steps of the duty leaves {far:.2g} times the noise; "
        f"{right} of {runs} simulated measurements then name the truth{enough}."
    ]


def _raising(plan: Plan) -> list[str]:
    """Which limit would have to be raised."""
    if plan.verdict == "told_apart":
        return []
    gains = {r.limit: min(r.separations[n] for n in plan.counted) for r in plan.raised}
    enough = [r for r in plan.raised if gains[r.limit] >= WOULD_DO]
    if not enough:
        tried = ", ".join(f"{r.limit} by {r.factor:.3g}" for r in plan.raised)
        return [f"Raising a single limit ({tried or ', '.join(RAISED)}) would not do either."]
    best = max(enough, key=lambda r: gains[r.limit])
    value = (
        f"{getattr(plan.bench.limits, best.limit) * best.factor:.3g} {UNITS[best.limit]}".rstrip()
    )
    return [
        f"Raising the {best.limit} to {value} would give {gains[best.limit]:.2g} times the noise."
    ]
