"""What the lab would decide: noisy records of a program, and the lab's own decision on each."""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, replace

import numpy as np
from er_models.prediction import Motion
from er_records.dataset import Dataset
from er_records.record import Record

from er_model_lab.diagnosis.candidates import Candidate, baseline, refit
from er_model_lab.diagnosis.null import simulate_null
from er_model_lab.diagnosis.passing import passes, threshold
from er_model_lab.diagnosis.ties import nested, tied
from er_model_lab.motion.fuse import channels_of, fuse
from er_model_lab.planning.limits import Sensors
from er_model_lab.planning.question import Question
from er_model_lab.planning.virtual_rig import Run
from er_model_lab.problem.prepare import prepare
from er_model_lab.problem.problem import Problem
from er_model_lab.work import HERE, Work

REPLICATES = 8
TIED, NOTHING = "tied", "nothing"


@dataclass(frozen=True)
class Outcome:
    """How often the lab named which effect (or `tied`, `nothing`) where `truth` was true."""

    truth: str
    named: Mapping[str, int]

    @property
    def runs(self) -> int:
        """Number of simulated measurements."""
        return sum(self.named.values())

    @property
    def right(self) -> int:
        """How often the truth alone was named."""
        return self.named.get(self.truth, 0)


def measured(made: Run, sensors: Sensors, rng: np.random.Generator, name: str) -> Record:
    """A run as the rig's sensors would record it."""
    sd = {
        "deflection": sensors.deflection, "deflection_velocity": sensors.velocity,
        "sprung_acceleration": sensors.acceleration, "unsprung_acceleration": sensors.acceleration,
        "damper_force": sensors.force,
    }  # fmt: skip
    channels = {
        k: y + sd.get(k, 0.0) * rng.standard_normal(y.size) for k, y in made.channels.items()
    }
    t = made.channels["t"]
    return Record(name, t, {k: y for k, y in channels.items() if k != "t"})


def again(problem: Problem, record: Record) -> Problem:
    """The problem of another measurement of the same program, with the noise levels already found."""
    c = record.channels
    a = c["sprung_acceleration"] - c["unsprung_acceleration"]
    raw = channels_of(record.dt, c["deflection"], c["deflection_velocity"], a).only(
        problem.raw[0].has
    )
    fused = fuse(raw, problem.fused[0].noise)
    m = problem.motion
    motion = Motion(m.dt, fused.x, fused.v, fused.a if raw.has[2] else a, m.u, m.theta, m.starts)
    return replace(problem, motion=motion, force=c["damper_force"], raw=(raw,), fused=(fused,))


def decision(question: Question, problem: Problem, seed: int) -> str:
    """The effect the lab names when it asks for these alone, or `tied`, or `nothing`."""
    base = baseline(question.base, problem)
    found = [refit(base, question.effect(n), problem) for n in question.names]
    found.sort(key=lambda c: c.mse)
    null = simulate_null(base, found, problem, seed, REPLICATES)
    limit = threshold(null, float(np.sqrt(min(found[0].mse, base.mse))))
    able = [c for c in found if passes(base, c, limit)]
    return _named(base, able, problem, limit)


def _named(base: Candidate, able: list[Candidate], problem: Problem, limit: float) -> str:
    """One name, or a tie of forms that are not nested."""
    if not able:
        return NOTHING
    group = tied(base, able, problem, limit)
    apart = [c for c in group if c is group[0] or not nested(group[0], c, problem)]
    return group[0].name if len(apart) == 1 else TIED


def outcomes(
    question: Question,
    runs: Mapping[str, Run],
    sensors: Sensors,
    seeds: Iterable[int],
    work: Work = HERE,
) -> dict[str, Outcome]:
    """The lab's decisions on measurements of every truth, one per seed."""
    jobs = [(k, truth, seed) for k, truth in enumerate(runs) for seed in seeds]
    first = prepare(Dataset.of([_measured(jobs[0], runs, sensors)]), work=work)
    names = work.map(
        _decided, jobs, question, runs, sensors, first, stage="simulated measurements"
    )
    found = {truth: Counter[str]() for truth in runs}
    for (_, truth, _), name in zip(jobs, names, strict=True):
        found[truth][name] += 1
    return {truth: Outcome(truth, dict(named)) for truth, named in found.items()}


def _measured(job: tuple[int, str, int], runs: Mapping[str, Run], sensors: Sensors) -> Record:
    """One simulated measurement: of which truth, and with which seed."""
    place, truth, seed = job
    return measured(runs[truth], sensors, np.random.default_rng([seed, place]), f"{truth} {seed}")


def _decided(
    job: tuple[int, str, int], question: Question, runs: Mapping[str, Run], sensors: Sensors, first: Problem
) -> str:  # fmt: skip
    """The lab's decision on one of them; first: the problem of the first one."""
    record = _measured(job, runs, sensors)
    problem = first if record.name == first.names[0] else again(first, record)
    return decision(question, problem, job[2])
