"""A whole program, verified against the limits, with the lab's own refits instead of linear steps."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np
from er_models.model import Array
from er_models.program import Program

from er_model_lab.diagnosis.candidates import Candidate, cross_judged, refit
from er_model_lab.fitting.fit import Fit, fit
from er_model_lab.motion.fuse import Noise
from er_model_lab.planning.limits import Sensors
from er_model_lab.planning.linear import floor_of
from er_model_lab.planning.piece import MARGIN, Bench
from er_model_lab.planning.segment import Segment
from er_model_lab.planning.virtual_rig import Run
from er_model_lab.problem.held_out import split
from er_model_lab.problem.problem import Problem

CORRECTIONS = 6


@dataclass(frozen=True)
class Direction:
    """One truth imitated by the other explanation.

    gap: root mean square [N] of what the best imitation leaves on unseen blocks; floor: noise [N];
    chi2: gap squared over floor squared, summed over the fitted samples; t: expected paired t
    over one-second blocks; difference (n,): truth minus imitation [N].
    """

    gap: float
    floor: float
    chi2: float
    t: float
    difference: Array

    @property
    def separation(self) -> float:
        """Gap over the noise floor."""
        return self.gap / self.floor


@dataclass(frozen=True)
class Finalist:
    """A program with its pieces, the peaks it reaches whoever is right, and how it separates by truth."""

    name: str
    segments: tuple[Segment, ...]
    program: Program
    runs: Mapping[str, Run]
    used: Mapping[str, float]
    directions: Mapping[str, Direction]

    def separation(self, names: Sequence[str]) -> float:
        """The smaller of the separations that count."""
        return min(self.directions[n].separation for n in names)


def finalist(name: str, segments: Sequence[Segment], bench: Bench) -> Finalist | None:
    """A program of these pieces; None when it cannot be kept within the limits."""
    ready = within_limits(segments, bench)
    if ready is None:
        return None
    program, segments, runs = ready
    used = {
        k: max(r.used()[k] for r in runs.values()) for k in ("stroke", "velocity", "duty", "road")
    }
    truths = {n: r for n, r in runs.items() if n in bench.rivals.truths}
    directions = {n: imitated(n, r, bench) for n, r in truths.items() if n in bench.rivals.mimics}
    return Finalist(name, tuple(segments), program, truths, used, directions)


def within_limits(
    segments: Sequence[Segment], bench: Bench
) -> tuple[Program, list[Segment], dict[str, Run]] | None:
    """The program with its pieces made smaller until the limits hold in every model."""
    segments = list(segments)
    for _ in range(CORRECTIONS):
        program = bench.program(segments)
        runs = bench.runs(program, bench.models)
        share = max(r.share(bench.limits) for r in runs.values())
        if share <= 1.0:
            return program, segments, runs
        ratio = MARGIN / share if np.isfinite(share) else 0.1
        segments = [s.scaled(ratio) for s in segments]
    return None


def clean_problem(made: Run, sensors: Sensors) -> Problem:
    """The run as the lab would split it, without noise."""
    motion = made.motion
    fold, held_out = split(motion)
    noise = Noise(sensors.deflection, sensors.velocity, sensors.acceleration, 0.0)
    return Problem(
        motion=motion, force=made.channels["damper_force"], fold=fold, held_out=held_out, raw=(),
        fused=(), noise=noise, names=("plan",), notes=(), complete=True, sd_force=sensors.force,
        velocity_lag=(0.0, 0.0),
    )  # fmt: skip


def imitated(truth: str, made: Run, bench: Bench) -> Direction:
    """The truth's force refitted by the other explanation and by itself, as the lab does it."""
    question = bench.rivals.question
    problem = replace(clean_problem(made, bench.sensors), work=bench.work)
    floor = floor_of(question.base, made, bench.sensors, bench.sd_velocity, bench.seed)
    base = candidate(fit(question.base, problem), problem)
    own = candidate(fit(bench.rivals.truths[truth], problem), problem)
    others = [n for n in question.names if n != truth]
    other = refit(base, question.effect(others[0]), problem) if others else base
    return _direction(own, other, floor, problem)


def _direction(own: Candidate, other: Candidate, floor: float, problem: Problem) -> Direction:
    """Gap, chi-square and expected t of the truth against its imitation."""
    gap2 = max(other.mse - own.mse, 0.0)
    train = problem.train
    change = other.residual[train] ** 2 - own.residual[train] ** 2
    length = max(round(1.0 / problem.motion.dt), 1)
    blocks = change[: change.size // length * length].reshape(-1, length).mean(axis=1)
    noise = 4.0 * floor**2 * float(np.mean(other.residual[train] ** 2)) / length
    spread = np.sqrt((float(np.var(blocks, ddof=1)) + noise) / blocks.size)
    return Direction(
        float(np.sqrt(gap2)), floor, gap2 / floor**2 * float(train.sum()),
        float(blocks.mean() / max(spread, 1e-300)), other.fit.residual - own.fit.residual,
    )  # fmt: skip


def candidate(fitted: Fit, problem: Problem) -> Candidate:
    """A fitted model as the lab holds it, cross-validated."""
    return cross_judged((), fitted, problem)
