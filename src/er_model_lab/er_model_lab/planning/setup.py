"""Sets up what programs are judged with: strengths of the effects, noise, and the rig's own everyday program."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from er_models.scales import Scales
from er_records.dataset import Dataset

from er_model_lab.planning import motions_and_duties
from er_model_lab.planning.limits import Limits, Sensors, nothing_fits
from er_model_lab.planning.linear import floor_of
from er_model_lab.planning.piece import Bench, scaled
from er_model_lab.planning.question import Question
from er_model_lab.planning.simulated_decision import measured
from er_model_lab.planning.strength import Rivals, from_data, standing_out
from er_model_lab.planning.virtual_rig import Run
from er_model_lab.problem.prepare import prepare
from er_model_lab.problem.problem import Problem


def bench_for(
    question: Question, limits: Limits, sensors: Sensors, problem: Problem | None, seed: int
) -> Bench:
    """The bench of a question: without data the effects stand out, with data they are as fitted."""
    if problem is not None:
        scales = _wider(question.base.scales, problem.scales)
        question = replace(question, base=replace(question.base, scales=scales))
    bare = Bench(Rivals(question, {}, {}, {}, {}), limits, sensors, 0.0, seed)
    pieces = [
        piece for segment in motions_and_duties.rich(limits) if (piece := scaled(segment, bare))
    ]
    runs = [made[""] for _, made in pieces]
    if not runs:
        raise nothing_fits(limits)
    sd = _fused_velocity(runs[0], sensors, problem, seed)
    rich = [(r, floor_of(question.base, r, sensors, sd, seed)) for r in runs]
    rivals = standing_out(question, rich, sensors)
    if problem is not None:
        rivals = from_data(rivals, problem, rich, sensors)
    return replace(bare, rivals=rivals, sd_velocity=sd)


def _wider(a: Scales, b: Scales) -> Scales:
    """An envelope that holds both."""
    return Scales(
        max(a.force, b.force), max(a.deflection, b.deflection), max(a.velocity, b.velocity), max(a.duty, b.duty),
    )  # fmt: skip


def _fused_velocity(made: Run, sensors: Sensors, problem: Problem | None, seed: int) -> float:
    """Error of the velocity after fusion [m/s], from the data or from a simulated measurement."""
    if problem is None:
        problem = prepare(
            Dataset.of([measured(made, sensors, np.random.default_rng(seed), "rig")])
        )
    return float(np.mean([f.sd_v for f in problem.fused]))
