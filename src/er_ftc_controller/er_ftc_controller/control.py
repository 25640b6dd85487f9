r"""The whole fault-tolerant controller, one pure step: from samples and fault estimates to a duty, with its mode.

``hear(p, state, faults)`` when a fault estimate arrives, ``step(p, state, t, sample)`` at each sample, and with
None for the sample while none comes. Nothing raises; what is wrong shows as mode and reason.

- *nominal*: no loss is certain; the domain is that of the healthy damper.
- *fault_tolerant*: the domain (6.14) is that of the estimated faults, which are faded in and out.
- *safe*: no usable sample for `timeout`, or no force left to control: a constant duty.

Modes change without a bump: factors move at `fade`, and the duty is a mixture of the safe and the controlled one
whose share moves from 1 to 0 in `ramp` and back in `recovery`.

Source: thesis (6.12)-(6.17), figure 6.11; modes, ramps and what is held are ours.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, replace
from enum import Enum
from functools import cached_property, lru_cache
from typing import NamedTuple, TypeAlias

from er_models.constants import SAMPLE_TIME
from er_models.errors import InputError
from er_models.forms.loss import Factors

from er_ftc_controller import force_loop, lateness, lpv, state_law
from er_ftc_controller.force_loop import ForceLoop, LoopState, Motion
from er_ftc_controller.lateness import Lateness
from er_ftc_controller.state_law import StateLaw

SLACK = 1e-9
"""Times that are closer are equal: stamps are sums of rounded periods [s]."""


class Mode(Enum):
    """What the controller does."""

    NOMINAL = "nominal"
    FAULT_TOLERANT = "fault_tolerant"
    SAFE = "safe"


@dataclass(frozen=True)
class Rules:
    """When the mode changes, and how fast.

    safe_duty [1]; timeout: silence that makes it safe [s]; ramp: to the safe duty [s]; recovery: back [s]; gap: jump
    of time that starts the controller afresh [s]; believed: largest deflection [m] and velocity [m/s]; fade: fastest
    change of a factor [1/s]; fault_age: after which an estimate is old [s]; least_left: share of the field's force
    below which nothing is left to control; restore: share of the lost passive force that the field gives back;
    latency: from a sample to its duty [s], until it is learnt; ahead: from the moment a duty begins to act to the
    middle of the time it acts [s], so far beyond its lateness the motion is led on; adapt: whether the domain follows
    the faults (False: the nominal LPV controller).
    """

    safe_duty: float
    believed: tuple[float, float]
    timeout: float = 0.025
    ramp: float = 0.02
    recovery: float = 0.1
    gap: float = 0.05
    fade: float = 2.0
    fault_age: float = 0.5
    least_left: float = 0.05
    restore: float = 0.0
    latency: float = 0.0
    ahead: float = 0.0
    adapt: bool = True

    def __post_init__(self) -> None:
        for name in ("timeout", "ramp", "recovery", "gap", "fade", "fault_age", "believed"):
            value = getattr(self, name)
            if not all(v > 0.0 for v in (value if isinstance(value, tuple) else (value,))):
                raise InputError("ftc_controller", name, "above 0", value)
        for name in ("latency", "ahead"):
            if not 0.0 <= getattr(self, name) < math.inf:
                raise InputError(
                    "ftc_controller", name, "a time of 0 s or more", getattr(self, name)
                )
        for name in ("safe_duty", "least_left", "restore"):
            if not 0.0 <= getattr(self, name) <= 1.0:
                raise InputError("ftc_controller", name, "0 to 1", getattr(self, name))


@dataclass(frozen=True, eq=False)
class Ftc:
    """The LPV controller, the inner loop of the force, the rules of the modes.

    body: sprung mass [kg] and spring [N/m], which tell the force where no sample holds one; None: nothing does.
    feedback: the scheduled state feedback, in charge while accelerations come; None: `law`, which needs the deflection
    alone, always is.
    """

    law: lpv.Lpv
    loop: ForceLoop
    rules: Rules
    body: tuple[float, float] | None = None
    feedback: StateLaw | None = None

    @cached_property
    def direct(self) -> ForceLoop:
        """The force loop without a horizon: the state feedback reckons with the lag itself."""
        return replace(self.loop, horizon=math.inf, dead_zone=0.0)

    @cached_property
    def rest(self) -> lpv.State:
        """The first state of `law`."""
        return lpv.start(self.law)


class Sample(NamedTuple):
    """Deflection [m], its velocity [m/s]; both accelerations [m/s2], force [N], duty that acted: NaN for none."""

    deflection: float
    velocity: float
    sprung_acceleration: float = math.nan
    unsprung_acceleration: float = math.nan
    force: float = math.nan
    duty: float = math.nan


class Faults(NamedTuple):
    """Estimate at time t [s]: factors f1, f2, f3; whether a loss is certain; whether the estimate may be used."""

    t: float
    electrical: float
    leakage: float
    deformation: float
    certain: bool
    usable: bool


class Command(NamedTuple):
    """Duty [1]; its mode and why; force asked for and nearest that can be given [N]; rho; the factors in use.

    rho: of the LPV controller; of the state feedback the share of its gains that acts. x, v: the motion the force is
    meant for [m, m/s].
    """

    duty: float
    mode: Mode
    reason: str
    wanted: float
    given: float
    rho: float
    left: tuple[float, float, float]
    x: float = 0.0
    v: float = 0.0


HEALTHY = (1.0, 1.0, 1.0)


class State(NamedTuple):
    """Memory between samples.

    t: of the last call [s], None before; heard: of the last usable sample; share: of the controlled duty, 0 safe;
    left: factors in use; aim: where they go; faults: last usable estimate; control, loop, feedback: of their own;
    command; lateness: of the duties.
    """

    t: float | None
    heard: float | None
    share: float
    left: tuple[float, float, float]
    aim: tuple[float, float, float]
    faults: Faults | None
    refused: bool
    control: lpv.State
    loop: LoopState
    command: Command
    feedback: state_law.State = state_law.START
    lateness: Lateness = Lateness()


Moved: TypeAlias = tuple[
    lpv.State, LoopState, state_law.State, float, float, float, tuple[float, float]
]
"""States of controller, force loop and state feedback; force wanted, given [N], rho, the motion it is meant for."""


def start(p: Ftc) -> State:
    """Safe, until samples come."""
    duty = p.rules.safe_duty
    first = Command(duty, Mode.SAFE, "no sample yet", 0.0, 0.0, p.law.schedule.high, HEALTHY)
    loop = LoopState(duty=duty)
    return State(None, None, 0.0, HEALTHY, HEALTHY, None, False, lpv.start(p.law), loop, first)


def hear(p: Ftc, state: State, faults: Faults) -> State:
    """Take an estimate of the faults; one that may not be used, or is none, leaves the factors as they are."""
    values = (faults.electrical, faults.leakage, faults.deformation)
    if not (faults.usable and all(0.0 <= v <= 1.0 for v in values) and math.isfinite(faults.t)):
        return state._replace(refused=True)
    aim = values if faults.certain and p.rules.adapt else HEALTHY
    return state._replace(aim=aim, faults=faults, refused=False)


def step(p: Ftc, state: State, t: float, sample: Sample | None) -> tuple[State, Command]:
    """Command from time t [s] on; sample None, or one that is not usable: the time goes on without one."""
    if not math.isfinite(t) or (state.t is not None and -p.rules.gap < t - state.t <= SLACK):
        return state, state.command
    state, dt = _aged(p, state, t)
    lost = force_left(state.left) < p.rules.least_left
    usable = sample is not None and _usable(p, sample)
    heard = t if usable else state.heard
    awake = heard is not None and t - heard <= p.rules.timeout + SLACK
    running = awake and not lost
    share = min(max(state.share + _share_gained(p, dt, running=running), 0.0), 1.0)
    last = state.command
    moved: Moved = (
        state.control, state.loop, state.feedback, last.wanted, last.given, last.rho, (last.x, last.v),
    )  # fmt: skip
    late = state.lateness
    if usable and sample is not None:
        late = lateness.hear(late, t, sample.duty)
        moved = _controlled(p, state, sample, dt, latency(p, late))
    control, loop, feedback, wanted, given, rho, motion = moved
    mode, reason = _mode(p, state, t, heard=heard, running=running, lost=lost)
    duty = p.rules.safe_duty + share * (loop.duty - p.rules.safe_duty)
    command = Command(duty, mode, reason, wanted, given, rho, state.left, *motion)
    late = lateness.say(late, t, duty)
    rest = (
        state.left,
        state.aim,
        state.faults,
        state.refused,
        control,
        loop,
        command,
        feedback,
        late,
    )
    return State(t, heard, share, *rest), command


def latency(p: Ftc, learnt: Lateness) -> float:
    """Time from a sample until the duty that answers it acts [s]: as learnt, else as told."""
    return p.rules.latency if learnt.late is None else learnt.late * SAMPLE_TIME


def _share_gained(p: Ftc, dt: float, *, running: bool) -> float:
    """Change of the controlled duty's share in a time [s], of which more than `timeout` was silence."""
    if not running:
        return -dt / p.rules.ramp
    silent = dt - p.rules.timeout
    return -silent / p.rules.ramp if silent > SLACK else dt / p.rules.recovery


def force_left(left: tuple[float, float, float]) -> float:
    """Share of the field's force that the faults leave, f1 f2 f3."""
    return left[0] * left[1] * left[2]


def _aged(p: Ftc, state: State, t: float) -> tuple[State, float]:
    """The state with its factors faded to time t, and the time since the last call; a jump of time starts afresh."""
    dt = 0.0 if state.t is None else t - state.t
    if not 0.0 <= dt <= p.rules.gap + SLACK:  # whoever applies duties has gone to the safe one
        state = state._replace(
            heard=None, faults=None, share=0.0, control=p.rest, loop=LoopState(), feedback=state_law.START,
            lateness=Lateness(late=state.lateness.late),
        )  # fmt: skip
        dt = 0.0
    if state.left == state.aim:
        return state, dt
    room = p.rules.fade * dt
    moved = (v + min(max(a - v, -room), room) for v, a in zip(state.left, state.aim, strict=True))
    f1, f2, f3 = moved
    return state._replace(left=(f1, f2, f3)), dt


def _usable(p: Ftc, sample: Sample) -> bool:
    """Whether deflection and velocity are numbers within belief."""
    return _believed(p, sample.deflection, sample.velocity)


def _believed(p: Ftc, x: float, v: float) -> bool:
    """Whether a motion is within belief; comparisons with NaN are false."""
    far, fast = p.rules.believed
    return abs(x) <= far and abs(v) <= fast


def _controlled(p: Ftc, state: State, sample: Sample, dt: float, late: float) -> Moved:
    """Controller and force loop one sample on; late: until the duty acts [s]."""
    left, (x, v) = _factors(state.left), sample[:2]
    loop = LoopState(state.loop.force, state.loop.gate, state.command.duty)
    motion = Motion(x, v, _force(p, sample), sample.duty)
    loop = force_loop.follow(p.loop, loop, motion, dt, left)
    rate = sample.sprung_acceleration - sample.unsprung_acceleration
    then = force_loop.ahead(x, v, rate, late + p.rules.ahead)
    if not _believed(p, *then):
        then = (x, v)
    if (moved := _fed_back(p, state, loop, sample, then, dt, late)) is not None:
        return moved
    control, asked = lpv.step(p.law, state.control, x, then, left, p.rules.restore)
    wanted, given, passive, gate, rho = asked
    loop, _ = force_loop.duty_for(p.loop, loop, given - passive, gate, dt, left, late)
    return control, loop, state_law.START, wanted, given, rho, then


def _fed_back(
    p: Ftc,
    state: State,
    loop: LoopState,
    sample: Sample,
    then: tuple[float, float],
    dt: float,
    late: float,
) -> Moved | None:
    """The state feedback one sample on; None where it is not in charge."""
    accelerations = (sample.sprung_acceleration, sample.unsprung_acceleration)
    heard = math.isfinite(sum(accelerations)) or state.feedback.missing + dt <= p.rules.timeout
    if p.feedback is None or not heard:
        return None
    left, damper = _factors(state.left), p.loop.damper
    passive, gate = float(damper.passive(*then, left)), float(damper.gate(*then))
    feedback, goal = state_law.step(
        p.feedback, state.feedback, sample[:2], accelerations, loop.force, dt, left.leakage * left.deformation, late
    )  # fmt: skip
    low, high = sorted(damper.ends(passive, gate, p.loop.duties, left))
    given = min(max(passive + goal, low), high)
    loop, _ = force_loop.duty_for(p.direct, loop, given - passive, gate, dt, left, late)
    return p.rest, loop, feedback, passive + goal, given, sum(feedback.shares), then


@lru_cache(maxsize=4)
def _factors(left: tuple[float, float, float]) -> Factors:
    """The factors with their names: nearly always those of the sample before."""
    return Factors(*left)


def _force(p: Ftc, sample: Sample) -> float:
    """Damper force [N] of a sample, measured or from the body's balance; NaN for none."""
    if p.body is None or not math.isnan(sample.force):
        return sample.force
    return force_loop.balance(*p.body, sample.sprung_acceleration, sample.deflection)


def _mode(
    p: Ftc, state: State, t: float, *, heard: float | None, running: bool, lost: bool
) -> tuple[Mode, str]:
    """Mode and why."""
    if heard is None:
        return Mode.SAFE, "no sample yet"
    if lost:
        return Mode.SAFE, "the faults leave no force to control"
    if not running:
        return Mode.SAFE, f"no usable sample for {p.rules.timeout:g} s"
    if not p.rules.adapt:
        return Mode.NOMINAL, ""
    reason = _trust(p, state, t)
    if state.left == HEALTHY and state.aim == HEALTHY:
        return Mode.NOMINAL, reason
    return Mode.FAULT_TOLERANT, reason or "a loss is certain"


def _trust(p: Ftc, state: State, t: float) -> str:
    """What is wrong with the estimate of the faults; empty for nothing."""
    if state.faults is None and state.aim == HEALTHY:
        return "no usable fault estimate yet: a healthy damper is assumed"
    if state.faults is None or t - state.faults.t > p.rules.fault_age:
        return "the fault estimate is old: the last factors are held"
    if state.refused:
        return "the fault estimate may not be used: the last factors are held"
    return ""
