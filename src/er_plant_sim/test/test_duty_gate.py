"""The duty gate: limits, timeout, conflicts and refused commands."""

import math

import pytest
from er_models.errors import InputError
from er_plant_sim.duty_gate import Command, Gate, GateState, Reason, program, receive, step
from hypothesis import given
from hypothesis import strategies as st

GATE = Gate(duty_min=0.0, duty_max=0.3, safe_duty=0.1, timeout=0.05)
START = GateState(duty=0.1, t=0.0)


def test_command_passes_and_is_named() -> None:
    state = receive(START, Command(t=1.0, seq=7, duty=0.2, source=2))
    _, applied = step(GATE, state, 1.02)
    assert applied == (0.2, 7, 2, False, Reason.COMMAND)


def test_safe_duty_before_the_first_command() -> None:
    _, applied = step(GATE, START, 0.0)
    assert (applied.duty, applied.command_seq, applied.reason) == (0.1, 0, Reason.NO_COMMAND)


@pytest.mark.parametrize(("age", "reason"), [(0.049, Reason.COMMAND), (0.051, Reason.OLD_COMMAND)])
def test_an_old_command_is_not_held(age: float, reason: Reason) -> None:
    state = receive(START, Command(1.0, 7, 0.3, 2))
    _, applied = step(GATE, state, 1.0 + age)
    assert applied.reason is reason
    assert applied.duty == (0.3 if reason is Reason.COMMAND else 0.1)


def test_two_publishers_make_it_safe() -> None:
    state = receive(START, Command(1.0, 7, 0.3, 2))
    _, applied = step(GATE, state, 1.0, conflict=True)
    assert (applied.duty, applied.reason) == (0.1, Reason.CONFLICT)


@pytest.mark.parametrize("duty", [math.nan, math.inf, -math.inf])
def test_what_is_not_finite_is_refused_and_counted(duty: float) -> None:
    good = receive(START, Command(1.0, 7, 0.2, 2))
    state = receive(good, Command(1.0, 8, duty, 2))
    assert state.command == good.command
    assert state.refused == 1


def test_invalid_and_late_commands_are_refused() -> None:
    good = receive(START, Command(1.0, 7, 0.2, 2))
    state = receive(good, Command(1.0, 8, 0.3, 2), valid=False)
    state = receive(state, Command(1.0, 6, 0.3, 2))
    assert state.command == good.command
    assert state.refused == 2


def test_slew_limits_the_change() -> None:
    gate = Gate(0.0, 0.3, 0.1, 0.05, slew=10.0)
    state, applied = program(gate, START, 0.005, 0.3)
    assert applied.duty == pytest.approx(0.15)
    assert applied.saturated
    assert program(gate, state, 0.02, 0.3)[1].duty == pytest.approx(0.3)


def test_limits_are_counted() -> None:
    state, applied = program(GATE, START, 0.0, 0.9)
    assert (applied.duty, applied.saturated, state.limited) == (0.3, True, 1)


@pytest.mark.parametrize(
    ("low", "high", "safe"), [(0.2, 0.1, 0.1), (0.0, 1.2, 0.1), (0.0, 0.3, 0.4)]
)
def test_contradicting_limits_are_named(low: float, high: float, safe: float) -> None:
    with pytest.raises(InputError, match="duty"):
        Gate(low, high, safe, 0.05)


@given(
    duty=st.floats(allow_nan=True, allow_infinity=True),
    t=st.floats(0.0, 10.0),
    slew=st.sampled_from([math.inf, 0.0, 3.0]),
)
def test_nothing_outside_the_range_ever_leaves(duty: float, t: float, slew: float) -> None:
    gate = Gate(0.05, 0.3, 0.1, 0.05, slew)
    _, applied = step(gate, receive(START, Command(t, 1, duty, 2)), t)
    assert 0.05 <= applied.duty <= 0.3
