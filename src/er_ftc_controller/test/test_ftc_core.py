"""The controller on messages: the same messages give the same commands, whatever their order within a tick."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from er_ftc_controller.ros_ftc import FtcCore, State, faults_of
from er_ftc_controller.settings import FtcParameters
from er_ros_common.builders import (
    Tick,
    fault_estimate,
    pwm_duty,
    suspension_acceleration,
    suspension_deflection,
)
from er_ros_common.core import When

from er_common import topics
from er_damper_msgs.msg import FaultEstimate, NodeStatus, PwmDuty
from er_ftc_controller import control

CONFIG = Path(__file__).resolve().parents[3] / "config"
BASE, PERIOD = 1_700_000_000_000_000_000, 5_000_000
CONFIRMED = (FaultEstimate.FAULT_HEALTHY, FaultEstimate.FAULT_CONFIRMED) * 2


def made(**other: Any) -> FtcCore:
    """The controller of the rig, with other parameters."""
    file = CONFIG / "nodes" / "ftc_controller.yaml"
    values = yaml.safe_load(file.read_text())["/**"]["ros__parameters"]
    car, gains = CONFIG / "vehicles/inove_quarter_car.yaml", CONFIG / "gains/lpv_ftc.yaml"
    return FtcCore(FtcParameters(model_file=str(car), gains_file=str(gains), **(values | other)))


@pytest.fixture(scope="module")
def core() -> FtcCore:
    return made()


def stamp(k: int) -> int:
    return BASE + k * PERIOD


def halves(k: int) -> list[tuple[topics.Topic, Any]]:
    """Acceleration and deflection of tick k on a ride of 4 Hz."""
    w, t = 2.0 * math.pi * 4.0, 0.005 * k
    tick = Tick(stamp(k), k)
    return [
        (topics.ACCELERATION, suspension_acceleration(tick, 0.5 * math.sin(w * t), 0.0)),
        (topics.DEFLECTION, suspension_deflection(tick, 0.003 * math.sin(w * t), 0.075 * math.cos(w * t))),
    ]  # fmt: skip


def leak(k: int, **changed: Any) -> tuple[topics.Topic, Any]:
    """An estimate of a leak, made at tick k."""
    factors, deviations = (1.0, 0.6, 1.0), (0.02,) * 3
    return topics.FAULT, fault_estimate(
        Tick(stamp(k), k), factors, deviations, CONFIRMED[:3], **changed
    )


def play(
    core: FtcCore, messages: list[tuple[topics.Topic, Any]], state: State | None = None
) -> tuple[State, list[PwmDuty]]:
    """All commands for messages that come when they were measured."""
    state, said = state or core.start(), []
    for topic, message in messages:
        s = message.header.stamp
        now = s.sec * 1_000_000_000 + s.nanosec + 1_000_000
        state, out = core.on_message(state, topic, message, When(now, now))
        said += [m for _, m in out]
    return state, said


def test_the_controller_is_made_for_the_rate_of_its_samples(core: FtcCore) -> None:
    slower, usual = (each.controller.law.A[0] for each in (made(rate=100.0), core))
    assert np.allclose(slower, usual @ usual)


def test_order_within_a_tick_and_lateness_of_estimates_change_nothing(core: FtcCore) -> None:
    early = [m for k in range(1, 200) for m in [*halves(k), leak(k)]]
    late = [m for k in range(1, 200) for m in ([leak(k - 3)] if k > 3 else []) + halves(k)[::-1]]
    (_, first), (_, second) = play(core, early), play(core, late)
    assert len(first) == 199
    assert [(m.duty, m.source, m.seq) for m in first] == [
        (m.duty, m.source, m.seq) for m in second
    ]
    assert {m.source for m in first} == {PwmDuty.SOURCE_NOMINAL, PwmDuty.SOURCE_FTC}
    assert first[-1].header.stamp == halves(199)[0][1].header.stamp
    (_, healthy) = play(core, [m for k in range(1, 200) for m in halves(k)])
    assert [m.duty for m in healthy] != [m.duty for m in first]


def test_how_late_its_duties_act_is_learnt_from_those_that_acted(core: FtcCore) -> None:
    """The duty of tick k is told when it is in force, two samples after the sample it answers, and from then on."""
    state, duties = core.start(), {}
    for k in range(1, 200):
        told = pwm_duty(Tick(stamp(k), k), duties.get(k - 2, 0.0), command_seq=max(k - 2, 0))
        state, (said,) = play(core, [*halves(k), (topics.PWM_APPLIED, told)], state)
        duties[k] = said.duty
    assert max(duties.values()) > min(duties.values()) + 0.05
    assert control.latency(core.controller, state.mind.lateness) == pytest.approx(0.01)
    assert core.report(state).values["latency [ms]"] == "10"
    (_, untold) = play(core, [m for k in range(1, 200) for m in halves(k)])
    assert [m.duty for m in untold] != list(duties.values())
    gone = pwm_duty(Tick(stamp(200), 200), 0.0, valid=False)
    lost, _ = play(core, [(topics.PWM_APPLIED, gone)], state)
    assert lost.applied == ()
    assert control.latency(core.controller, lost.mind.lateness) == pytest.approx(0.01)


@pytest.mark.parametrize(
    "changed", [{"unexplained": True}, {"valid": False}, {"status": FaultEstimate.STATUS_LOST}]
)
def test_estimates_that_prove_no_fault_are_not_acted_on(
    core: FtcCore, changed: dict[str, Any]
) -> None:
    state, said = play(core, [m for k in range(1, 60) for m in [*halves(k), leak(k, **changed)]])
    assert {m.source for m in said} == {PwmDuty.SOURCE_NOMINAL}
    assert "no usable fault estimate" in state.mind.command.reason


def test_what_was_said_last_of_one_tick_is_what_counts(core: FtcCore) -> None:
    """The estimator takes its last estimate back with a message of the same stamp that is not valid."""
    taken_back = [leak(10), leak(10, valid=False)]
    state, said = play(core, taken_back + [m for k in range(11, 40) for m in halves(k)])
    assert {m.source for m in said} == {PwmDuty.SOURCE_NOMINAL}
    assert "no usable fault estimate" in state.mind.command.reason
    _, said = play(core, taken_back[::-1] + [m for k in range(11, 40) for m in halves(k)])
    assert said[-1].source == PwmDuty.SOURCE_FTC


@pytest.mark.parametrize(("late", "used"), [(25, 1), (490, 1), (510, 0)])
def test_an_estimate_that_waited_for_a_part_is_not_too_old(
    core: FtcCore, late: int, used: int
) -> None:
    """The estimator holds a tick for 20 ms where a sensor is missing; an estimate acts until it is old."""
    now = stamp(1) + late * 1_000_000
    state, _ = core.on_message(core.start(), *leak(1), When(now, now))
    assert (len(state.waiting), state.stamps.stale) == (used, 1 - used)
    assert core.limits[core.inputs.index(topics.FAULT)].stale == core.p.fault_age


@pytest.mark.parametrize(
    ("factors", "states", "certain", "usable"),
    [
        ((1.0, 0.6, 1.0), (1, 3, 1), True, True),
        ((0.7, 0.9, 0.8), (5, 1, 5), True, True),
        ((1.0, 1.0, 1.0), (4, 1, 1), False, True),
        ((0.5, 1.0, 1.0), (4, 1, 1), False, False),
        ((1.0, 0.8, 1.0), (1, 2, 1), False, False),
        ((1.0, 1.0, 1.0), (0, 0, 0), False, False),
    ],
)
def test_statuses_are_acted_on_forgotten_or_waited_for(
    factors: tuple[float, float, float], states: tuple[int, int, int], certain: bool, usable: bool
) -> None:
    """Confirmed or confounded: act. All well: forget. Suspected, or lost when last excited: stay as it is."""
    message = leak(1)[1]
    for i in range(3):
        setattr(message, f"f{i + 1}", factors[i])
        setattr(message, f"f{i + 1}_status", states[i])
    found = faults_of(message)
    assert (found.certain, found.usable) == (certain, usable)
    assert found[1:4] == factors


def test_silence_ends_at_the_safe_duty_within_50_ms(core: FtcCore) -> None:
    state, _ = play(core, [m for k in range(1, 100) for m in halves(k)])
    last, said = stamp(99) + 1_000_000, []
    for ms in range(1, 60, 5):
        when = When(last + 1_000_000 * ms, last + 1_000_000 * ms)
        state, out = core.on_time(state, when)
        said += [(ms, m) for _, m in out]
    assert all(ms > 25 for ms, _ in said)
    safe = [ms for ms, m in said if m.duty == core.p.safe_duty]
    assert safe
    assert safe[0] <= 50
    assert said[-1][1].source == PwmDuty.SOURCE_SAFE
    state, again = play(core, [m for k in range(120, 140) for m in halves(k)], state)
    assert {m.source for m in again} == {PwmDuty.SOURCE_NOMINAL}


def test_answers_after_a_silence_do_not_depend_on_who_looked_when(core: FtcCore) -> None:
    """40 ms without samples, looked at or not, as live and in replay; the duty goes on where the ramp has come to."""
    before = [m for k in range(1, 100) for m in halves(k)]
    after = [m for k in range(107, 140) for m in halves(k)]
    first, _ = play(core, before)
    looked, ramp = first, []
    for ms in range(1, 38, 5):
        when = When(stamp(99) + 1_000_000 * (1 + ms), stamp(99) + 1_000_000 * (1 + ms))
        looked, out = core.on_time(looked, when)
        ramp += [m.duty for _, m in out]
    assert ramp
    _, one = play(core, after, looked)
    _, two = play(core, after, first)
    assert [m.duty for m in one] == [m.duty for m in two]
    reach = max(core.p.safe_duty, core.p.u_max - core.p.safe_duty)
    assert abs(one[0].duty - core.p.safe_duty) <= 0.5 * reach


def test_a_missing_acceleration_costs_the_force_not_the_duty(core: FtcCore) -> None:
    blind = [
        (topics.ACCELERATION, suspension_acceleration(Tick(stamp(k), k), 0.0, 0.0, valid=False))
        for k in range(1, 50)
    ]
    messages = [m for k, b in enumerate(blind, 1) for m in (b, halves(k)[1])]
    _, said = play(core, messages)
    assert len(said) == 49
    assert {m.source for m in said} == {PwmDuty.SOURCE_NOMINAL}


@pytest.mark.parametrize(
    ("sprung", "valid", "why"),
    [
        (0.5, False, "not valid"),
        (math.nan, True, "not a number"),
        (-math.inf, True, "not a number"),
        (1e30, True, "beyond belief"),
        (0.3, True, "stuck"),
    ],
)
def test_an_acceleration_that_is_not_used_says_why_and_costs_no_duty(
    core: FtcCore, sprung: float, valid: bool, why: str
) -> None:
    messages = [m for k in range(1, 60) for m in halves(k)]
    for (topic, message), wheel in zip(messages, range(len(messages)), strict=True):
        if topic is topics.ACCELERATION and message.seq > 20:
            message.sprung, message.unsprung, message.valid = sprung, 0.01 * wheel, valid
    state, said = play(core, messages)
    assert len(said) == 59
    assert {m.source for m in said} == {PwmDuty.SOURCE_NOMINAL}
    assert state.unused == (why, stamp(59))
    told = core.report(state)
    assert (told.status, told.valid) == (NodeStatus.STATUS_DEGRADED, True)
    assert f"sensors/acceleration is not used: {why}" in told.reason
    assert state.unusable == (39 if why != "stuck" else 19)
    without, _ = play(core, messages[:40])
    assert without.unused == ("", 0)
    blind = [(t, suspension_acceleration(Tick(stamp(m.seq), m.seq), 0.0, 0.0, valid=False)
              if t is topics.ACCELERATION and m.seq > 20 else m) for t, m in messages]  # fmt: skip
    if why != "stuck":
        assert [m.duty for m in said] == [m.duty for m in play(core, blind)[1]]


def test_a_velocity_that_no_longer_changes_ends_at_the_safe_duty(core: FtcCore) -> None:
    frozen = [
        (topics.DEFLECTION, suspension_deflection(Tick(stamp(k), k), 0.001 + 1e-5 * (k % 7), 0.05))
        for k in range(1, 60)
    ]
    messages = [m for k, f in enumerate(frozen, 1) for m in (halves(k)[0], f)]
    state, said = play(core, messages)
    assert len(said) < 30
    assert state.unusable > 25


def test_old_double_and_invalid_samples_are_counted_and_not_answered(core: FtcCore) -> None:
    state, _ = play(core, [m for k in range(1, 20) for m in halves(k)])
    state, said = play(core, [*halves(10), *halves(19)], state)
    assert not said
    tick = Tick(stamp(20), 20)
    bad = (topics.DEFLECTION, suspension_deflection(tick, 0.0, 0.0, valid=False))
    state, said = play(core, [bad], state)
    assert (said, state.unusable) == ([], 1)
