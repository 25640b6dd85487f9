"""Stamp checks: every refusal is counted and changes nothing else."""

from __future__ import annotations

import pytest
from er_common.stamps import (
    StampLimits,
    StampState,
    Verdict,
    check_input,
    check_stamp,
    counted,
)

MS = 1_000_000
START = 100_000 * MS
LIMITS = StampLimits()


def after(*stamps: int) -> StampState:
    """State after accepting the stamps, numbered from 1."""
    state = StampState()
    for seq, stamp in enumerate(stamps, 1):
        state, _ = check_stamp(LIMITS, state, stamp, seq)
    return state


def test_regular_samples_are_fresh_after_the_first() -> None:
    state, first = check_stamp(LIMITS, StampState(), START, 1)
    state, second = check_stamp(LIMITS, state, START + 5 * MS, 2)
    assert (first, second) == (Verdict.FIRST, Verdict.FRESH)
    assert first.restart
    assert not second.restart
    assert (state.received, state.used, state.lost, state.resets) == (2, 2, 0, 0)


@pytest.mark.parametrize(
    ("stamp", "now", "verdict", "counter"),
    [
        (START, None, Verdict.DUPLICATE, "duplicate"),
        (START - 5 * MS, None, Verdict.OUT_OF_ORDER, "out_of_order"),
        (0, None, Verdict.ZERO, "zero_stamp"),
        (START + 5 * MS, START + 26 * MS, Verdict.STALE, "stale"),
        (START + 11 * MS, START + 5 * MS, Verdict.FUTURE, "future"),
    ],
)
def test_refused_sample_is_counted_and_changes_nothing_else(
    stamp: int, now: int | None, verdict: Verdict, counter: str
) -> None:
    before = after(START)
    state, found = check_stamp(LIMITS, before, stamp, 2, now)
    assert found is verdict
    assert not found.use
    assert getattr(state, counter) == 1
    assert state._replace(received=1, **{counter: 0}) == before


@pytest.mark.parametrize(
    ("stamp", "now"),
    [(START + 5 * MS, START + 25 * MS), (START + 10 * MS, START + 5 * MS)],
    ids=["just not stale", "just not future"],
)
def test_limits_are_included(stamp: int, now: int) -> None:
    assert check_stamp(LIMITS, after(START), stamp, 2, now)[1] is Verdict.FRESH


def test_gap_restarts_and_counts_the_lost_samples() -> None:
    state, verdict = check_stamp(LIMITS, after(START), START + 55 * MS, 12)
    assert verdict is Verdict.GAP
    assert verdict.use
    assert verdict.restart
    assert (state.lost, state.resets) == (10, 1)


def test_jump_back_of_time_restarts_at_once_and_loses_nothing() -> None:
    state, verdict = check_stamp(LIMITS, after(START, START + 5 * MS), START - 1000 * MS, 1)
    assert verdict is Verdict.JUMPED_BACK
    assert verdict.use
    assert verdict.restart
    assert (state.stamp, state.lost, state.resets) == (START - 1000 * MS, 0, 1)


def test_messages_without_sequence_number_are_not_called_lost() -> None:
    state, _ = check_stamp(LIMITS, after(START), START + 10 * MS, 0)
    assert state.lost == 0


def test_junk_between_samples_leaves_the_same_state_as_without() -> None:
    clean = after(START, START + 5 * MS, START + 10 * MS)
    state = StampState()
    for stamp, seq in (
        (START, 1),
        (START, 1),
        (START + 5 * MS, 2),
        (START + 2 * MS, 1),
        (0, 9),
        (START + 10 * MS, 3),
    ):
        state, _ = check_stamp(LIMITS, state, stamp, seq)
    assert (state.duplicate, state.out_of_order, state.zero_stamp) == (1, 1, 1)
    assert state._replace(received=3, duplicate=0, out_of_order=0, zero_stamp=0) == clean


def test_a_number_from_nowhere_is_no_loss() -> None:
    """Otherwise one wrong number makes a count that no message can hold."""
    state, _ = check_stamp(LIMITS, StampState(), START, seq=1)
    state, verdict = check_stamp(LIMITS, state, START + 5 * MS, seq=2**64 - 1)
    assert verdict is Verdict.FRESH
    assert state.lost == 0


def test_each_of_several_inputs_has_its_own_limits_and_its_own_past() -> None:
    patient = StampLimits(stale=0.5)
    states, verdicts = (StampState(),) * 2, []
    for which, stamp, seq in ((0, START, 1), (1, START, 1), (0, START, 1), (1, START + 9 * MS, 3)):
        states, verdict = check_input((LIMITS, patient), states, which, stamp, seq, START + 9 * MS)
        verdicts.append(verdict)
    old = [
        check_input((LIMITS, patient), states, which, START + 11 * MS, 4, START + 50 * MS)[1]
        for which in (0, 1)
    ]
    assert verdicts == [Verdict.FIRST, Verdict.FIRST, Verdict.DUPLICATE, Verdict.FRESH]
    assert old == [Verdict.STALE, Verdict.FRESH]
    all_of_them = counted(states)
    assert (all_of_them.stamp, all_of_them.seq) == (START, 1)
    assert (all_of_them.received, all_of_them.used, all_of_them.lost) == (4, 3, 1)
    assert (all_of_them.duplicate, all_of_them.resets) == (1, 0)
