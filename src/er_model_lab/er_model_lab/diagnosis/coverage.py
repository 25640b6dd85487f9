"""What the data exercise: the ranges visited, and what cannot be learnt for want of them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
from er_models.model import Array

from er_model_lab.motion.repetition import FEW_CURVES, REMEDY, curves, one_curve
from er_model_lab.motion.unlike_records import REMEDY as APART
from er_model_lab.motion.unlike_records import Course, difference, unlike
from er_model_lab.motion.white_noise import white_noise
from er_model_lab.problem.problem import Problem

STEP = 0.01
"""Change of the duty from one sample to the next that is a step."""
Line = tuple[float, float]
"""Frequency of a spectral line, and the width that it is known to [Hz]."""
EVEN = 0.25
"""Share of a difference between records from which on it stays: the states in which they begin take up a part."""
MOVED = 1.2
"""Ratio of a channel's deviation to its white noise above which something moved."""


@dataclass(frozen=True)
class Coverage:
    """Ranges of the data, what blocks a verdict, and hints on what to record next.

    tones: number of frequencies that carry 95 % of the motion; curves: number of closed curves that the motion runs
    through again and again, 0 where it does not repeat itself; unlike: that the force of two records differs at the
    same motion, in a sentence, or ''.
    """

    deflection: float
    velocity: float
    duty: tuple[float, float]
    tones: int
    seconds: float
    temperature: float
    blocking: tuple[str, ...]
    hints: tuple[str, ...]
    curves: int = 0
    unlike: str = ""


def coverage(problem: Problem) -> Coverage:
    """Measure what the records exercise."""
    m = problem.motion
    u = m.u
    steps = int(np.sum(np.abs(np.diff(u)) > STEP))
    tones = _tones(problem)
    used = problem.used[:: problem.forward.outputs]
    seconds = sum(int(used[i:j].sum()) for i, j in problem.learnt) * m.dt
    blocking, hints = [], []
    if seconds < 5.0:
        blocking.append(f"only {seconds:.1f} s of usable data: record at least 20 s")
    many = curves(problem.cycles, m.v, problem.learnt)
    if still(problem):
        blocking.append(
            f"the damper stands still: its motion is not above the noise of its sensors; {REMEDY}"
        )
    elif 0 < many <= FEW_CURVES:
        blocking.append(f"{one_curve(problem.cycles[0].frequency)}; {REMEDY}")
    elif tones <= 2:
        blocking.append(
            "the motion is a single tone: effects of velocity, deflection and acceleration cannot be told apart; "
            f"{REMEDY}"
        )
    if np.ptp(u) <= STEP:
        hints.append(
            "the duty never changes: effects of the actuation cannot be seen; record steps of the duty"
        )
    elif steps == 0:
        hints.append(
            "the duty changes without steps: delay and lag of the actuation are hardly seen; record steps of the duty"
        )
    if np.max(np.abs(m.v)) > 0 and np.std(u) > 0:
        correlation = abs(float(np.corrcoef(u, np.abs(m.v))[0, 1]))
        if correlation > 0.9:
            hints.append(
                "the duty follows the velocity: record with a duty that does not depend on the motion"
            )
    return Coverage(
        float(np.max(np.abs(m.x))), float(np.max(np.abs(m.v))), (float(u.min()), float(u.max())),
        tones, seconds, float(np.ptp(m.theta)), tuple(blocking), tuple(hints), many, _unlike(problem),
    )  # fmt: skip


def _unlike(problem: Problem) -> str:
    """How the force of two records of a damper differs at the same motion; '' where it does not."""
    if problem.forward.outputs > 1:
        return ""
    found = unlike(_courses(problem, problem.force))
    return f"{found}; {APART}" if found else ""


def stays_unlike(problem: Problem, residuals: Sequence[Array]) -> bool:
    """Whether records of a damper differ at the same motion, and all of these residuals (n,) [N] still do."""
    if problem.forward.outputs > 1:
        return False
    courses = _courses(problem, problem.force)
    found = unlike(courses)
    least = EVEN * difference(found, courses) if found else 0.0
    return found is not None and all(
        difference(found, _courses(problem, each)) > least for each in residuals
    )


def _courses(problem: Problem, force: Array) -> list[Course]:
    """The records of a damper with a force (n,) [N], without wild samples."""
    m, rows = problem.motion, pairwise(problem.motion.starts.tolist())
    force = np.where(problem.wild, np.nan, force) if problem.wild is not None else force
    return [
        Course(name, m.x[i:j], m.v[i:j], m.u[i:j], force[i:j])
        for name, (i, j) in zip(problem.names, rows, strict=True)
    ]


def still(problem: Problem) -> bool:
    """Whether deflection [m] and velocity [m/s], as measured in every record, are white noise and nothing else."""
    measured = [
        c.z[:, k] for c in problem.raw for k in (0, 1) if c.has[k] and np.isfinite(c.z[:, k]).all()
    ]
    return bool(measured) and all(np.std(y) <= MOVED * white_noise([y]) for y in measured)


def _tones(problem: Problem) -> int:
    """Number of spectral lines that carry 95 % of the velocity, over all records learnt from.

    Lines of different records are one where they are no further apart than either resolves.
    """
    m, found = problem.motion, list[list[Line]]()
    for i, j in problem.learnt:
        v = m.v[i:j] - m.v[i:j].mean()
        power = np.abs(np.fft.rfft(v * np.hanning(v.size))) ** 2
        frequency = np.fft.rfftfreq(v.size, m.dt)
        width = max(4.0 / (v.size * m.dt), 0.1)
        place = (frequency / width).astype(int)
        bins, centre = np.bincount(place, power), np.bincount(place, power * frequency)
        order = np.argsort(bins)[::-1]
        share = np.cumsum(bins[order]) / max(bins.sum(), 1e-300)
        needed = int(np.searchsorted(share, 0.95)) + 1
        lines = order[: 1 if needed <= 2 else needed]
        found.append([(float(centre[k] / max(bins[k], 1e-300)), width) for k in lines])
    return _different(found)


def _different(records: list[list[Line]]) -> int:
    """How many lines there are of which no earlier record has one."""
    count, known = 0, list[Line]()
    for lines in records:
        new = [
            (f, width) for f, width in lines if all(abs(f - g) >= max(width, w) for g, w in known)
        ]
        count, known = count + len(new), known + new
    return count
