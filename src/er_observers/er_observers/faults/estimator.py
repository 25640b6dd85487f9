r"""Estimates what faults have left of a damper: `start`, `step`.

(6.8) is linear in f_2 k_0, f_2 f_3 c_0 and f_1 f_2 f_3: every sample is one row of a regression (`regression.py`), with
the motion from an iterated Kalman filter (`follow.py`, whose equations are in `passage.py`). Blocks of rows fill a
window; those that leave it while the damper is healthy become the belief about the very damper at hand, its springs and
its mass (`tick.py`). A force that is not what was expected cuts the window, so that it holds one state of the damper
only, and grows from there. At the end of every block the evidence of each kind of fault is weighed (`evidence.py`) and
turned into factors, statuses and a name (`decision.py`).

``step(p, state, sample) -> (state, estimate)`` is pure; nothing in the loop raises, what is wrong shows as a status.
One `Estimator` serves one thread at a time: the compiled part works in its room.

Source: thesis (2.16), (2.19), (6.8); MacKay 1992; Page 1954 (detection of changes).
"""

from __future__ import annotations

import math
from typing import NamedTuple

import numpy as np
from er_models.model import Array

from er_observers.faults import decision, tick
from er_observers.faults.passage import V
from er_observers.faults.rules import Estimator
from er_observers.faults.sample import NOTHING, Estimate, FactorStatus, Kind, Sample, Status
from er_observers.faults.sums import N
from er_observers.observers.status import ROUNDING

_VELOCITY = tick.MIND.start + V
"""Place of the velocity in the memory."""


class State(NamedTuple):
    """Memory between samples.

    t: time of the last sample [s]; lost: since the last valid one [s]; memory, window: see `tick`; running: whether a
    valid sample has come; resets: new beginnings of the motion; rejected: samples not used.
    """

    t: float
    lost: float
    memory: Array
    window: Array
    running: bool
    estimate: Estimate
    resets: int = 0
    rejected: int = 0


def start(p: Estimator, sample: Sample) -> State:
    """State at the first sample; one that is not valid leaves the estimator waiting."""
    memory, window = np.zeros(tick.MEMORY), np.zeros((tick.BLOCKS, tick.STORED))
    memory[tick.VERDICT] = decision.begin()
    memory[tick.EXPECTED] = p.first[:N]
    memory[tick.BENDS] = tick.FIRST
    return _placed(
        p, State(sample.t, 0.0, memory, window, running=False, estimate=NOTHING), sample
    )


def step(p: Estimator, state: State, sample: Sample) -> tuple[State, Estimate]:
    """Estimate with this sample; until then the duty of the one before was in force.

    Late or double samples change nothing. After a gap longer than the hold limit, and after a jump of time, the
    motion begins anew; what is known of the damper stays.
    """
    hold, dt = p.rules.hold + ROUNDING, sample.t - state.t
    if not math.isfinite(sample.t) or (state.running and -hold < dt <= 0.0):
        state = state._replace(rejected=state.rejected + 1)
    elif not state.running or abs(dt) > hold or state.lost > hold:
        state = _placed(p, state, sample)
    else:
        state = _follow(p, state, sample, dt)
    return state, state.estimate


def _follow(p: Estimator, state: State, sample: Sample, dt: float) -> State:
    """Advance with a sample; where it is beyond belief, or its force, the motion goes on without.

    A motion that is no number any more begins anew.
    """
    memory, window, good = state.memory.copy(), state.window, _valid(p, sample)
    a = (sample.sprung_acceleration, sample.unsprung_acceleration)
    seen = (sample.deflection, sample.deflection_velocity)
    if not good:
        a = seen = (math.nan, math.nan)
    duty = _duty(sample.duty, float(memory[tick.COUNTED][tick.DUTY]))
    force = sample.force if abs(sample.force) <= p.limits[3] else math.nan
    lost, estimate = 0.0 if good else state.lost + dt, state.estimate
    full = tick.run(p.p, p.noise, p.setup, a, seen, duty, force, dt, memory)
    if not math.isfinite(memory[_VELOCITY]):
        return _placed(p, state, sample)
    if full:
        window = window.copy()
        tick.close(p.p, p.noise, p.setup, p.judging, p.prior, p.first, p.room, window, memory)
        estimate = _says(p, memory, lost)
    elif lost != state.lost:
        estimate = _says(p, memory, lost)
    rejected = state.rejected + (not good)
    return State(sample.t, lost, memory, window, True, estimate, state.resets, rejected)


def _placed(p: Estimator, state: State, sample: Sample) -> State:
    """The motion begins with this sample."""
    if not _valid(p, sample):
        lost = state.lost + max(0.0, sample.t - state.t)
        estimate = _says(p, state.memory, math.inf) if state.running else state.estimate
        rejected = state.rejected + 1
        return state._replace(t=sample.t, lost=lost, estimate=estimate, rejected=rejected)
    memory = state.memory.copy()
    tick.place(p.p, p.noise, sample.deflection, sample.deflection_velocity, memory)
    memory[tick.COUNTED][tick.DUTY] = _duty(sample.duty, 0.0)
    resets, estimate = state.resets + state.running, _says(p, memory, 0.0)
    return State(sample.t, 0.0, memory, state.window, True, estimate, resets, state.rejected)


def _duty(duty: float, before: float) -> float:
    """Duty within 0 to 1; the one before where it is no number."""
    return min(max(duty, 0.0), 1.0) if math.isfinite(duty) else before


def _valid(p: Estimator, sample: Sample) -> bool:
    """Whether a sample holds a time, a duty and numbers within belief; comparisons with NaN are false."""
    acceleration, deflection, velocity, _ = p.limits
    return math.isfinite(sample.t + sample.duty) and (
        abs(sample.sprung_acceleration) <= acceleration
        and abs(sample.unsprung_acceleration) <= 10.0 * acceleration
        and abs(sample.deflection) <= deflection
        and not abs(sample.deflection_velocity) > velocity
    )


def _says(p: Estimator, memory: Array, lost: float) -> Estimate:
    """The estimate that the memory holds."""
    if lost > p.rules.hold + ROUNDING:
        reason = "no valid sample for too long"
        return NOTHING._replace(status=Status.INVALID, reason=reason)
    verdict = memory[tick.VERDICT]
    kind = Kind(int(verdict[decision.KIND]))
    doubted = float(verdict[decision.DOUBTED])
    unexplained = doubted > p.rules.lasting
    status, reason = Status.OK, ""
    if unexplained:
        status, reason = Status.UNEXPLAINED, "something that is no fault acts as well"
    elif lost > 0.0:
        status, reason = Status.DEGRADED, "samples are missing"
    elif doubted > 0.0:
        status, reason = Status.DEGRADED, "measurement and model disagree"
    elif kind is Kind.UNKNOWN:
        status, reason = Status.INITIALISING, "not enough samples yet"
    f1, f2, f3 = verdict[decision.FACTORS].tolist()
    d1, d2, d3 = verdict[decision.SPREAD].tolist()
    s1, s2, s3 = (FactorStatus(int(v)) for v in verdict[decision.STATUS])
    certainty, residual, ratio = (
        float(verdict[i]) for i in (decision.CERTAINTY, decision.RESIDUAL, decision.RATIO)
    )
    return Estimate(
        (f1, f2, f3), (d1, d2, d3), (s1, s2, s3), kind, certainty, residual, ratio, unexplained, status, reason,
    )  # fmt: skip
