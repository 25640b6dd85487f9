"""One piece of a program: scaled to the limits, and judged by what imitates what along it."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np
from er_models.model import Model
from er_models.program import Program

from er_model_lab.planning.limits import Limits, Sensors
from er_model_lab.planning.linear import Triangle, design, floor_of, left, triangle
from er_model_lab.planning.segment import Segment, program_of
from er_model_lab.planning.strength import Rivals
from er_model_lab.planning.virtual_rig import Run, run_all
from er_model_lab.work import HERE, Work

MARGIN = 0.97
"""Share of a limit that is used, so that another run does not exceed it."""
SCALINGS = 4
ENOUGH_TONES = 3
"""Fewer frequencies the lab takes for a single tone."""


@dataclass(frozen=True, eq=False)
class Tried:
    """A piece scaled to the limits, and for each truth the triangles of every mimic and of the truth itself.

    What a truth leaves of its own force is the sampling's: a jump between two samples.
    """

    segment: Segment
    parts: Mapping[str, tuple[Triangle, ...]]
    own: Mapping[str, Triangle]


@dataclass(frozen=True)
class Bench:
    """Everything a piece is judged with; sd_velocity: error of the fused velocity [m/s]; work: how jobs are done."""

    rivals: Rivals
    limits: Limits
    sensors: Sensors
    sd_velocity: float
    seed: int
    work: Work = HERE

    def __getstate__(self) -> dict[str, Any]:
        return {**self.__dict__, "work": HERE}

    @property
    def car(self) -> bool:
        """Whether the model is a vehicle."""
        return self.rivals.question.base.is_vehicle

    @property
    def models(self) -> dict[str, Model]:
        """Every model that may turn out true, by name of its effect: the limits must hold for all."""
        return {"": self.rivals.question.base, **self.rivals.truths}

    def program(self, segments: Sequence[Segment], *, once: bool = False) -> Program:
        """The segments as a program of this rig; once: only once through."""
        return program_of(segments, self.limits, seed=self.seed, car=self.car, once=once)

    def runs(self, program: Program, names: Iterable[str]) -> dict[str, Run]:
        """The program run with some of the models."""
        models = self.models
        return run_all({name: models[name] for name in names}, program, self.limits.dt)


def scaled(segment: Segment, bench: Bench) -> tuple[Segment, dict[str, Run]] | None:
    """The piece as large as its level of the limits allows, and its run for every truth; None if it cannot be run."""
    names = tuple(bench.rivals.truths) or ("",)
    fits = None
    for _ in range(SCALINGS):
        runs = bench.runs(bench.program([segment], once=True), names)
        share = max(r.share(bench.limits) for r in runs.values())
        if share <= segment.level:
            fits = segment, runs
            if share > 0.9 * segment.level or not segment.moves:
                break
        ratio = MARGIN * segment.level / max(share, 1e-9) if np.isfinite(share) else 0.1
        segment = segment.scaled(ratio)
    return fits


def judged(segment: Segment, bench: Bench) -> Tried | None:
    """A piece with its triangles; None if it cannot be run within the limits."""
    ready = scaled(segment, bench)
    if ready is None:
        return None
    segment, runs = ready
    rivals, base = bench.rivals, bench.rivals.question.base
    parts, own = {}, {}
    for name, mimics in rivals.mimics.items():
        noise = floor_of(base, runs[name], bench.sensors, bench.sd_velocity, bench.seed)
        problem = design(runs[name], bench.sensors, base.scales)
        parts[name] = tuple(triangle(m, problem, noise) for m in mimics)
        own[name] = triangle(rivals.truths[name], problem, noise)
    return Tried(segment, parts, own)


def separations(pieces: Sequence[Tried]) -> dict[str, float]:
    """By truth: what the best imitation leaves beyond what the truth leaves of itself, over the noise, to a hundredth.

    Less than that tells nothing: where no piece tells anything, the order of the menu decides, not the last digit.
    """
    out = {}
    for name in pieces[0].parts:
        groups = zip(*(p.parts[name] for p in pieces), strict=True)
        rest = min(left(group) for group in groups) ** 2 - left([p.own[name] for p in pieces]) ** 2
        out[name] = round(float(np.sqrt(max(rest, 0.0))), 2)
    return out


def score(pieces: Sequence[Tried], directions: Sequence[str]) -> float:
    """The smaller of the separations that count."""
    found = separations(pieces)
    return min(found[name] for name in directions)


def broad(pieces: Sequence[Tried]) -> bool:
    """Whether the motion has so many frequencies that the lab does not take it for a single tone."""
    return len({round(t, 6) for p in pieces for t in p.segment.tones}) >= ENOUGH_TONES
