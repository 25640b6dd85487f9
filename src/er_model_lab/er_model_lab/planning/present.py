"""A plan as JSON and as what reports and terminals draw."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import replace
from typing import Any, Literal

import numpy as np
from er_models.program import Program, document_of
from scipy.special import betaincinv

from er_model_lab.planning.explanation import rival, sentences, title
from er_model_lab.planning.finalist import Direction, Finalist
from er_model_lab.planning.planner import Plan
from er_model_lab.planning.segment import in_words
from er_model_lab.planning.simulated_decision import Outcome
from er_model_lab.results.values import parameters
from er_model_lab.view import ImitationView, ProgramView, View

LEVEL = 0.9
"""Probability of the interval of a share."""


Verdict = Literal["told_apart", "one_way", "not_told_apart", "revealed", "not_revealed"]


def verdict(plan: Plan) -> Verdict:
    """The verdict; of one effect against its absence in its own words."""
    if plan.question.second is not None:
        return plan.verdict
    return "revealed" if plan.verdict == "told_apart" else "not_revealed"


def plan_json(plan: Plan, noise_source: str) -> dict[str, Any]:
    """The result of `plan`; forces in N, everything else SI."""
    question, limits, sensors = plan.question, plan.bench.limits, plan.bench.sensors
    asked = (
        {"reveal": question.first}
        if question.second is None
        else {"between": list(question.names)}
    )
    return {
        "command": "plan", "model": question.base.name, **asked,
        "verdict": verdict(plan), "why": sentences(plan), "counted": list(plan.counted),
        "moves": "wheel" if plan.bench.car else "damper",
        "limits": dict(vars(limits)), "noise": {**vars(sensors), "source": noise_source},
        "noise_floor": plan.best.directions[plan.counted[0]].floor if plan.finalists else None,
        "strengths": {n: _strength(plan, n) for n in question.names},
        "programs": [_program(f) for f in plan.finalists],
        "identification": _program(plan.everyday) if plan.everyday else None,
        "measurements": _measurements(plan.outcomes),
        "measurements_identification": _measurements(plan.everyday_outcomes),
        "raise": [{"limit": r.limit, "factor": r.factor, "separation": r.separations} for r in plan.raised],
    }  # fmt: skip


def _strength(plan: Plan, name: str) -> dict[str, Any]:
    """How strong an effect was taken to be."""
    rivals = plan.bench.rivals
    values = parameters(rivals.truths[name], name)
    return {"parameters": values, "shown": rivals.shown[name], "source": rivals.sources[name]}


def _program(found: Finalist) -> dict[str, Any]:
    """One program with what it uses of the limits and how it separates, by truth."""
    return {
        "name": found.name, "pieces": [in_words(s) for s in found.segments],
        "used": dict(found.used),
        "separation": {n: d.separation for n, d in found.directions.items()},
        "gap": {n: d.gap for n, d in found.directions.items()},
        "chi2": {n: d.chi2 for n, d in found.directions.items()},
        "t": {n: d.t for n, d in found.directions.items()},
        "program": document_of(found.program),
    }  # fmt: skip


def _measurements(outcomes: Mapping[str, Outcome]) -> dict[str, Any]:
    """How often the lab named what, and the share named rightly with its interval (Jeffreys)."""
    out = {}
    for name, o in outcomes.items():
        tail = (1.0 - LEVEL) / 2.0
        a, b = o.right + 0.5, o.runs - o.right + 0.5
        interval = [float(betaincinv(a, b, q)) for q in (tail, 1.0 - tail)]
        out[name] = {
            "named": dict(o.named), "right": o.right, "runs": o.runs, "probability": o.right / o.runs,
            "interval": interval,
        }  # fmt: skip
    return out


def proposed(plan: Plan, name: str, source: str) -> Program:
    """The proposed program under its own name."""
    return replace(plan.best.program, name=name, source=source)


def plan_view(plan: Plan, result: Mapping[str, Any], provenance: Mapping[str, Any]) -> View:
    """Everything a report or terminal shows of a plan."""
    shown = [*plan.finalists[:1], *([plan.everyday] if plan.everyday else [])]
    return View(
        command="plan", model=plan.question.base.name, headline=_headline(plan), result=result, records=(),
        provenance=provenance, programs=tuple(_drawn(plan, f) for f in shown),
        notes=tuple(result.get("notes", ())),
    )  # fmt: skip


def _headline(plan: Plan) -> str:
    """One line in newtons."""
    if not plan.finalists:
        return "nothing to measure"
    gaps = ", ".join(
        f"{plan.best.directions[n].gap:.3g} N of {title(plan, n)}" for n in plan.counted
    )
    floor = plan.best.directions[plan.counted[0]].floor
    return f"cannot be imitated: {gaps}; noise {floor:.3g} N"


def _drawn(plan: Plan, found: Finalist) -> ProgramView:
    """Road, motion and duty of a program, and the forces of every truth with their imitations."""
    first = next(iter(found.runs.values())).channels
    return ProgramView(
        found.name, np.asarray(first["t"]), first["road"], first["deflection"], first["duty"],
        min(sum(s.seconds for s in found.segments), found.program.duration),
        tuple(_imitation(plan, found, n, d) for n, d in found.directions.items()),
    )  # fmt: skip


def _imitation(plan: Plan, found: Finalist, truth: str, d: Direction) -> ImitationView:
    """One truth and what imitates it."""
    force = found.runs[truth].channels["damper_force"]
    other = rival(plan, truth)
    return ImitationView(
        title(plan, truth), title(plan, other), force, force - d.difference, d.floor
    )
