"""The absolute schedule: no drift, lateness made up, long stops reported."""

from er_plant_sim.schedule import Progress, Schedule, due, next_due

MS = 1_000_000
P = Schedule(period=5 * MS, catch_up=20)


def test_no_error_adds_up_when_every_call_is_late() -> None:
    state, total = Progress(start=1000 * MS), 0
    for k in range(1000):
        state, ticks = due(P, state, 1000 * MS + k * 5 * MS + 3 * MS)
        total += ticks
    assert total == 1000
    assert next_due(P, state) == 6000 * MS


def test_nothing_is_due_early() -> None:
    state, ticks = due(P, Progress(1000 * MS), 1000 * MS - 1)
    assert (state.done, ticks) == (0, 0)
    state, ticks = due(P, state, 1000 * MS)
    assert (state.done, ticks) == (1, 1)


def test_missed_ticks_are_made_up() -> None:
    state, ticks = due(P, Progress(0, done=10), 10 * 5 * MS + 49 * MS)
    assert (state.done, state.skipped, ticks) == (20, 0, 10)


def test_a_long_stop_starts_the_schedule_anew() -> None:
    state, ticks = due(P, Progress(0, done=10), 10 * 5 * MS + 60_000 * MS)
    assert ticks == 1
    assert state.skipped == 12_000
    assert next_due(P, state) == (10 + 12_001) * 5 * MS
