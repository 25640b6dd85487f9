"""Inputs that stay away, come late, repeat themselves or jump in time are named, with a cure."""

from __future__ import annotations

from random import Random
from typing import Any

import pytest
from er_common.stamps import StampLimits, StampState, check_stamp
from er_ros_common.inputs import ERROR, OK, WARN, Finding, Input

MS = 1_000_000
T0 = 1_000_000 * MS


def watched(**other: Any) -> Input:
    """An input that began at 100 s."""
    return Input("/sensors/force", StampLimits(), 100.0, **other)


def feed(each: Input, seqs: range, start: float = 100.0, age: int = 1 * MS) -> float:
    """One message each 5 ms; the time after the last."""
    for seq in seqs:
        stamp = T0 + 5 * MS * seq
        each.note(stamp, seq, start + 0.005 * seq, stamp + age)
    return start + 0.005 * seqs[-1]


def test_what_comes_as_it_should_is_nothing_to_say() -> None:
    each = watched()
    each.measure(100.0)
    end = feed(each, range(1, 401))
    each.measure(end)
    assert each.measured == pytest.approx(200.0)
    assert each.flow(end).level == OK
    assert each.stamps(end) == []


def test_silence_is_a_warning_after_one_second_and_an_error_after_five() -> None:
    each = watched()
    assert each.flow(100.9).level == OK
    assert each.flow(101.1).level == WARN
    found = each.flow(105.1)
    assert (found.level, found.topic) == (ERROR, "/sensors/force")
    assert "nothing came for 5.1 s: start its publisher" in found.text
    end = feed(each, range(1, 10), 105.1)
    assert each.flow(end).level == OK
    assert "nothing came any more for 1.5 s" in each.flow(end + 1.5).text


def test_counts_are_those_of_a_check_of_each_message() -> None:
    each, state = watched(), StampState()
    for seq in (1, 2, 3, 5, 6, 6, 4, 7, 8, 900, 901, 2, 3, 4):
        stamp = T0 + 5 * MS * seq
        each.note(stamp, seq, 100.0, stamp + MS)
        state, _ = check_stamp(each.limits, state, stamp, seq, stamp + MS)
        if seq % 4 == 0:
            assert each.state == state
    assert each.state == state
    assert (state.duplicate, state.out_of_order, state.resets) == (1, 1, 2)


def test_an_input_that_may_be_missing_is_not_missed() -> None:
    assert watched(needed=False).flow(200.0).level == OK


@pytest.mark.parametrize(("rate", "level"), [(0.0, OK), (200.0, OK), (190.0, OK), (1000.0, WARN)])
def test_samples_at_another_rate_than_the_node_is_made_for_are_told(
    rate: float, level: int
) -> None:
    """By stamps: in simulated time, whose own pace is another (`steady` false), and with losses, too."""
    each = watched(rate=rate, steady=False)
    end = feed(each, range(1, 400))
    each.measure(end)
    end = feed(each, range(400, 800, 2))
    each.measure(end)
    found = each.flow(end)
    assert found.level == level
    if level == WARN:
        assert "samples of 200 Hz, but this node is made for 1000 Hz: set its" in found.text


def test_stamps_that_jitter_make_no_other_rate() -> None:
    """200 Hz, each stamp off by up to 0.7 ms: 200 Hz should come, and half of them is told within a second."""
    each, random, found = watched(), Random(1), []
    for seq in range(1, 4001):
        stamp = T0 + 5 * MS * seq + round(random.uniform(-0.7, 0.7) * MS)
        if seq <= 3000 or seq % 2:
            each.note(stamp, seq, 100.0 + 0.005 * seq, stamp + 2 * MS)
        if seq % 200 == 0:
            each.measure(100.0 + 0.005 * seq)
        if seq % 20 == 0:
            found.append(each.flow(100.0 + 0.005 * seq))
    assert {f.level for f in found[:150]} == {OK}
    assert {f.level for f in found[159:]} == {WARN}
    assert "100 Hz of 200 Hz arrive" in found[-1].text


def test_numbers_that_begin_anew_make_no_other_rate() -> None:
    each = watched()
    for k in range(400):
        each.note(T0 + 5 * MS * k, k + 300 if k < 300 else k - 299, 100.0 + 0.005 * k, None)
        if k % 200 == 199:
            each.measure(100.0 + 0.005 * k)
            assert each.flow(100.0 + 0.005 * k).level == OK


def test_half_of_the_ticks_is_too_slow_and_a_slow_plant_is_not() -> None:
    each, slow = watched(), watched()
    each.measure(100.0)
    slow.measure(100.0)
    end = feed(each, range(2, 802, 2))
    for seq in range(1, 201):
        slow.note(T0 + 20 * MS * seq, seq, 100.0 + 0.02 * seq, None)
    each.measure(end)
    slow.measure(104.0)
    assert "100 Hz of 200 Hz arrive" in each.flow(end).text
    assert each.flow(end).level == WARN
    assert slow.flow(104.0).level == OK


@pytest.mark.parametrize(
    ("stamp", "now", "words"),
    [
        (T0 + 10 * MS, T0 + 40 * MS, "1 messages too old on arrival (the last by 0.03 s)"),
        (T0 + 20 * MS, T0 + 10 * MS, "1 messages ahead of this machine's clock (the last by 0.01 s)"),
        (0, T0, "1 messages without a stamp: set header.stamp"),
        (T0 + 5 * MS, T0 + 6 * MS, "1 messages with the stamp of the one before"),
        (T0, T0 + 6 * MS, "1 messages out of order"),
    ],
)  # fmt: skip
def test_a_bad_stamp_is_named_for_a_second(stamp: int, now: int, words: str) -> None:
    each = watched()
    feed(each, range(1, 2))
    each.note(stamp, 2, 100.01, now)
    (found,) = each.stamps(100.5)
    assert found.level == WARN
    assert words in found.text
    assert each.stamps(101.5) == []


@pytest.mark.parametrize("needed", [True, False])
@pytest.mark.parametrize(
    ("numbers", "valid", "words", "counts"),
    [
        ((0.1, float("nan")), True, "1 messages with NaN or infinite numbers", (0, 1)),
        ((float("-inf"), 0.0), True, "1 messages with NaN or infinite numbers", (0, 1)),
        ((0.0, 0.0), False, "1 messages that their sender calls not valid", (1, 0)),
    ],
)
def test_values_that_cannot_be_used_are_named_for_a_second(
    numbers: tuple[float, float], valid: bool, words: str, counts: tuple[int, int], needed: bool
) -> None:
    each = watched(needed=needed)
    each.read((0.1, 0.2), 100.0, valid=True)
    assert each.values(100.0) == []
    each.read(numbers, 100.0, valid=valid)
    assert (each.invalid, each.non_finite) == counts
    found = each.values(100.5)
    assert [(f.level, f.topic) for f in found] == [(WARN, "/sensors/force")] * (needed or valid)
    assert all(words in f.text for f in found)
    assert each.values(101.5) == []


def test_a_message_without_a_part_that_is_needed_is_named_for_a_second() -> None:
    each = watched()
    each.read((0.1, 0.0), 100.0, valid=True, lacks="velocity")
    assert (each.incomplete, each.invalid, each.non_finite) == (1, 0, 0)
    (found,) = each.values(100.5)
    assert found.level == WARN
    assert "1 messages without velocity" in found.text
    assert each.values(101.5) == []


@pytest.mark.parametrize(
    ("step", "words"),
    [(-60_000, "time jumped back by 60 s"), (450_000, "time jumped forward by 450 s")],
)
def test_a_jump_of_time_is_said_and_is_no_fault(step: int, words: str) -> None:
    each = watched()
    end = feed(each, range(100, 110))
    each.note(T0 + (545 + step) * MS, 1, end + 0.005, None)
    (found,) = each.stamps(end + 1.0)
    assert found.level == OK
    assert words in found.text
    assert each.state.resets == 1


def test_a_forged_number_makes_no_rate() -> None:
    each = watched()
    each.measure(100.0)
    end = feed(each, range(1, 201))
    each.measure(end)
    each.note(T0 + 5 * MS * 200 + MS, 10**18, end + 0.001, None)
    end = feed(each, range(201, 401))
    each.measure(end)
    assert each.flow(end) == Finding(OK, "/sensors/force", "comes")
    for k, seq in enumerate(
        range(401, 601)
    ):  # a number far ahead among good ones, again and again
        at = end + 0.005 * k
        each.note(T0 + 5 * MS * seq, seq + (10**6 if k % 50 == 49 else 0), at, None)
    each.measure(end + 1.0)
    assert each.flow(end + 1.0).level == OK


def test_the_second_in_which_an_input_begins_is_no_slow_one() -> None:
    each = watched()
    each.measure(100.0)
    each.measure(101.0)
    end = feed(each, range(1, 81), 101.6)
    each.measure(end)
    assert each.flow(end).level == OK
    end = feed(each, range(81, 281), 101.6)
    each.measure(end)
    assert each.measured == pytest.approx(200.0)
    each.measure(feed(each, range(281, 301), end + 3.0 - 1.4))  # after a pause it begins anew
    assert each.flow(end + 3.1).level == OK
