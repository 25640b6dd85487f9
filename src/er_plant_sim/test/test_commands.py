"""Which sample a command answers, and which commands answer none."""

from __future__ import annotations

import pytest

pytest.importorskip("rclpy")

from er_common.stamps import SECOND, StampLimits
from er_plant_sim.duty_gate import Applied, Command, Gate, GateState, Reason, receive, step
from er_plant_sim.ros_commands import Answer, Commands, command, judged, passed_on
from er_ros_common.builders import Tick, pwm_duty
from er_ros_common.clock import to_stamp

from er_damper_msgs.msg import PwmDuty
from er_plant_sim import ros_msgs

DT, MS = 0.005, 1_000_000
LAST = Tick(1_700_000_000 * SECOND, 100)
"""The newest sample."""
NOW = LAST.stamp + 2 * MS
LIMITS = StampLimits(stale=0.045)
GATE = Gate(0.0, 0.3, 0.1, 0.045)


def wish(stamp: int, seq: int) -> PwmDuty:
    message = pwm_duty(Tick(0, seq), 0.2, source=PwmDuty.SOURCE_NOMINAL)
    message.header.stamp = to_stamp(stamp)
    return message


@pytest.mark.parametrize(
    ("stamp", "seq", "counter"),
    [
        (0, 100, "zero_stamp"),
        (0, 0, "zero_stamp"),
        (LAST.stamp - 10 * SECOND, 100, "stale"),
        (LAST.stamp - 10 * SECOND, 0, "stale"),
        (LAST.stamp + 10 * SECOND, 100, "future"),
        (LAST.stamp + 10 * SECOND, 0, "future"),
    ],
)
def test_a_bad_stamp_is_dropped_and_counted_whatever_the_number(
    stamp: int, seq: int, counter: str
) -> None:
    state, answer = judged(LIMITS, Commands(), wish(stamp, seq), LAST, NOW)
    assert answer is None
    assert (state.stamps.received, state.stamps.used) == (1, 0)
    assert getattr(state.stamps, counter) == 1


@pytest.mark.parametrize(
    ("stamp", "seq", "number", "t"),
    [
        (LAST.stamp, 100, 100, 100 * DT),
        (LAST.stamp, 0, 100, 100 * DT),
        (LAST.stamp - 10 * MS, 98, 98, 98 * DT),
        (LAST.stamp - 10 * MS, 0, 0, 98 * DT),
        (NOW, 100, 100, 100 * DT),
        (NOW, 0, 0, 100 * DT + 0.002),
        (NOW + 4 * MS, 0, 0, 100 * DT + 0.002),
        (NOW, 2**64 - 1, 0, 100 * DT + 0.002),
        (LAST.stamp - 40 * MS, 100, 100, 92 * DT),
    ],
    ids=["both", "stamp", "both, old", "stamp, old", "own time", "own time, no number", "ahead", "another plant's",
         "number newer than stamp"],
)  # fmt: skip
def test_a_command_is_as_old_as_the_sample_it_answers(
    stamp: int, seq: int, number: int, t: float
) -> None:
    message = wish(stamp, seq)
    _, answer = judged(LIMITS, Commands(), message, LAST, NOW)
    assert answer is not None
    made = command(message, answer, LAST, DT)
    assert made.seq == number
    assert made.t == pytest.approx(t, abs=1e-9)


def test_no_duty_acts_longer_than_50_ms_after_the_sample_by_stamp_alone() -> None:
    message = wish(LAST.stamp - 40 * MS, 0)
    _, answer = judged(LIMITS, Commands(), message, LAST, NOW)
    assert answer is not None
    state = receive(GateState(0.1, 0.0), command(message, answer, LAST, DT))
    reasons = [step(GATE, state, k * DT)[1].reason for k in (101, 102)]
    assert reasons == [Reason.COMMAND, Reason.OLD_COMMAND]


def test_what_the_gate_does_with_a_command_is_counted() -> None:
    state = passed_on(Commands(), wish(NOW, 100), 100, refused=False)
    state = passed_on(state, wish(NOW, 103), 103, refused=False)
    state = passed_on(state, wish(NOW, 99), 99, refused=True)
    invalid = wish(NOW, 104)
    invalid.valid = False
    state = passed_on(state, invalid, 104, refused=True)
    s = state.stamps
    assert (s.received, s.used, s.lost, s.out_of_order, state.invalid) == (4, 2, 2, 1, 1)


def test_a_source_that_there_is_not_is_unknown_on_the_applied_duty() -> None:
    made = command(wish(NOW, 1), Answer(0, 1), LAST, DT)
    assert made == Command(DT, 1, 0.2, 2)
    applied = Applied(0.2, 1, 77, False, Reason.COMMAND)
    assert ros_msgs.applied(LAST, applied).source == PwmDuty.SOURCE_UNKNOWN
    assert ros_msgs.applied(LAST, applied._replace(source=3)).source == PwmDuty.SOURCE_FTC
