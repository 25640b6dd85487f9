"""The duty gate: limits, timeout, conflicts and refused commands."""

import math
from collections.abc import Callable

import pytest
from er_models.errors import InputError
from er_plant_sim.duty_gate import (
    BURST,
    Command,
    Gate,
    GateState,
    Reason,
    program,
    receive,
    step,
)
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


def second_of(*senders: Callable[[int], int | None]) -> int:
    """Answers counted as repeated in 200 ticks; a sender gives the number it writes at a tick, None: nothing."""
    state = START
    for tick in range(1, 201):
        for number in (sender(tick) for sender in senders):
            if number is not None:
                state = receive(state, Command(0.005 * tick, number, 0.2, 2), newest=tick)
    return state.repeated


def numbered(tick: int) -> int:
    return tick


def unnumbered(_: int) -> int:
    return 0


@pytest.mark.parametrize(
    "senders",
    [
        (numbered, numbered),
        (numbered, unnumbered),
        (unnumbered, numbered),
        (unnumbered, unnumbered),
    ],
)
def test_two_that_answer_every_sample_repeat_one_another_with_number_or_without(
    senders: tuple[Callable[[int], int], ...],
) -> None:
    assert second_of(*senders) >= 200 - BURST


@pytest.mark.parametrize(
    "sender",
    [
        numbered,
        unnumbered,
        lambda tick: 0 if tick % 2 else tick,
        lambda tick: None if tick % 3 else 0,
    ],
)
def test_one_alone_repeats_nothing(sender: Callable[[int], int | None]) -> None:
    assert second_of(sender) == 0


@pytest.mark.parametrize("number", [0, 1])
def test_what_was_held_up_and_comes_at_once_repeats_nothing(number: int) -> None:
    state = START
    for tick in range(200):
        if tick % 8 == 0:
            for back in range(7, -1, -1):
                wish = Command(0.005 * tick, number * (tick + 8 - back), 0.2, 2)
                state = receive(state, wish, newest=tick + 8)
    assert (state.repeated, state.refused) == (0, 0)


def test_a_late_answer_is_refused_also_after_one_without_number() -> None:
    state = receive(START, Command(1.0, 11, 0.2, 2), newest=11)
    state = receive(state, Command(1.0, 0, 0.25, 2), newest=11)
    state = receive(state, Command(1.0, 10, 0.3, 2), newest=11)
    assert state.command == Command(1.0, 0, 0.25, 2)
    assert state.refused == 1
