"""Who watches the machine while a graph runs for long."""

from __future__ import annotations

import os
import signal
from time import monotonic, sleep

import pytest

from test.reliability.witness import AFTER, Witness


@pytest.fixture
def witness(monkeypatch: pytest.MonkeyPatch) -> Witness:
    """One that watches nothing."""
    monkeypatch.setattr(os, "sched_getaffinity", lambda _: set())
    return Witness()


def test_what_comes_soon_after_a_hold_up_may_be_its_doing(witness: Witness) -> None:
    witness.hold_ups = [(10.0, 0.02), (10.01, 0.03), (50.0, 0.006)]
    assert witness.explains(10.015) == pytest.approx(0.03)
    assert witness.explains(10.04 + 0.99 * AFTER) == pytest.approx(0.03)
    assert witness.explains(9.99) == witness.explains(10.05 + AFTER) == 0.0
    words = witness.words([10.1, 20.0], 0.0, 100.0)
    assert "3 times, at most 30 ms; losses within 0.1 s of that: 1 of 2" in words


def test_chance_is_the_share_of_time_near_hold_ups(witness: Witness) -> None:
    """Two of one moment count once; none reaches beyond the end."""
    witness.hold_ups = [(1.0, 0.1), (1.0, 0.1), (3.95, 0.2)]
    assert witness.chance(0.0, 4.0) == pytest.approx((0.1 + AFTER + 0.05) / 4.0)
    assert Witness().chance(0.0, 1.0) == 0.0


def test_a_core_that_stands_still_is_noticed() -> None:
    """Here it is the witness that is made to stand still."""
    with Witness() as witness:
        sleep(1.5)
        if any(process.poll() is not None for process in witness.processes):
            pytest.skip("real-time priority is not allowed here")
        witness.look()
        begun = monotonic()
        for process in witness.processes:
            os.kill(process.pid, signal.SIGSTOP)
        sleep(0.1)
        for process in witness.processes:
            os.kill(process.pid, signal.SIGCONT)
        sleep(0.3)
        witness.look()
        held = [late for when, late in witness.hold_ups if begun - 0.05 < when < begun + 0.15]
    assert len(held) >= len(witness.processes)
    assert max(held) > 0.05
    assert all(process.poll() is not None for process in witness.processes)


def test_without_the_right_to_it_it_says_so(witness: Witness) -> None:
    class Ended:
        stdout = None

        def poll(self) -> int:
            return 1

    witness.processes = [Ended()]  # type: ignore[list-item]
    assert "not allowed" in witness.words([], 0.0, 1.0)
