"""What reports and terminals draw: records, evidence cards, regions."""

from __future__ import annotations

from collections.abc import Mapping
from typing import Any

import numpy as np
from er_models.model import Array

from er_model_lab.diagnosis.candidates import Candidate
from er_model_lab.diagnosis.decisive_round import told
from er_model_lab.diagnosis.found import Diagnosis
from er_model_lab.diagnosis.search import Round
from er_model_lab.level.study import Study
from er_model_lab.problem.problem import Problem
from er_model_lab.residual.excess import noise_at, region_tables
from er_model_lab.residual.region import RegionTable
from er_model_lab.results.candidate import reason
from er_model_lab.results.values import headline
from er_model_lab.view import CandidateView, RecordView, View

SHOWN = 12
"""Candidates that get an evidence card."""
POINTS = 600
"""Points of a signature picture."""


def record_views(study: Study) -> tuple[RecordView, ...]:
    """Measured force, and the model before and after, per record."""
    problem, found = study.problem, study.diagnosis
    before = problem.force - found.base.fit.residual
    after = problem.force - found.best.fit.residual if found.best is not found.base else None
    return views(problem, before, after)


def views(problem: Problem, before: Array, after: Array | None) -> tuple[RecordView, ...]:
    """Per-record slices of a problem and its predictions, of the first output."""
    n, problem = problem.forward.outputs, problem.parts[0]
    before, after = before[::n], None if after is None else after[::n]
    m, out = problem.motion, []
    for name, i, j in zip(problem.names, m.starts[:-1], m.starts[1:], strict=True):
        cut = slice(int(i), int(j))
        out.append(
            RecordView(
                name, np.arange(j - i) * m.dt, m.x[cut], m.v[cut], m.u[cut], problem.force[cut], before[cut],
                None if after is None else after[cut], problem.used[cut], problem.held_out[cut],
            )
        )  # fmt: skip
    return tuple(out)


def candidate_views(study: Study, result: Mapping[str, Any]) -> tuple[CandidateView, ...]:
    """Evidence cards of the leading candidates."""
    found, problem = study.diagnosis, study.problem
    seen = {c.name: (c, step) for c, step in told(found)}
    shown = [e for e in result["candidates"] if e["effect"] in seen][:SHOWN]
    return tuple(_card(*seen[e["effect"]], found, problem, e) for e in shown)


def _card(
    candidate: Candidate,
    step: Round,
    found: Diagnosis,
    problem: Problem,
    fields: Mapping[str, Any],
) -> CandidateView:
    """One evidence card: the change of force the effect makes beside what the model left."""
    effect = candidate.fit.model.catalogue[candidate.name]
    n, problem = problem.forward.outputs, problem.parts[0]
    rows = np.flatnonzero(problem.train)
    rows = rows[:: max(1, rows.size // POINTS)]
    axis = {"force-deflection": problem.motion.x, "force-duty": problem.motion.u, "time": problem.motion.t,
            "force-acceleration": problem.motion.a}.get(effect.signature.plane, problem.motion.v)  # fmt: skip
    left = step.base.fit.residual[::n]
    change = left - candidate.fit.residual[::n]
    return CandidateView(
        candidate.name, effect.title, effect.physics, candidate.fit.model.catalogue,
        effect.signature.mark, effect.signature.experiment, fields, reason(candidate, step, found),
        effect.signature.plane, axis[rows], change[rows], left[rows],
    )  # fmt: skip


def study_regions(
    study: Study, seed: int, *residuals: Array
) -> tuple[tuple[RegionTable, ...], ...]:
    """Where models fail that leave these residuals (n,) [N] of the data of a study, one after the other."""
    found, problem = study.diagnosis, study.problem
    noise = noise_at(problem, found.floor.first.floor, found.null.input_square)
    return tuple(region_tables(problem, residual, seed, noise) for residual in residuals)


def study_view(
    command: str, study: Study, result: Mapping[str, Any], provenance: Mapping[str, Any]
) -> View:
    """Everything a report of `diagnose`, `add` or `improve` shows."""
    found = study.diagnosis
    return View(
        command=command, model=study.model.name, result=result, records=record_views(study),
        candidates=candidate_views(study, result),
        headline=headline(result["rmse"]["held_out"], result["noise_floor"]),
        notes=(*result["notes"], *found.coverage.hints), provenance=provenance,
    )  # fmt: skip
