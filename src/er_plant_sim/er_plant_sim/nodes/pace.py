"""When the ticks are, and their stamps: of the system clock, or simulated time from zero."""

from __future__ import annotations

from time import monotonic_ns, time_ns

from er_common.stamps import CLOCK_STEP

from er_plant_sim.schedule import Progress, Schedule, due

EARLY = 50
"""Ticks are due this part of a period early: none waits because a timer fired too soon."""


class Pace:
    """An absolute schedule on the steady clock, and the stamp of each of its ticks [ns].

    In real time the stamps are the system's time at which a tick was due. They do not follow the
    small corrections of a system clock, and follow at once where it was set by more than half of what is refused.
    """

    def __init__(self, dt: float, rate_factor: float, *, real: bool) -> None:
        self.dt = round(1e9 * dt)
        self.real = real
        self.schedule = Schedule(period=max(round(1e9 * dt / rate_factor), 1))
        self.progress = Progress(monotonic_ns())
        self.anchor = time_ns()
        self.clock_steps = 0

    def restart(self, since: int) -> None:
        """Begin the schedule; its first tick was due `since` nanoseconds ago.

        A timer that wakes us must be in step with the schedule: were the first tick due just after
        the timer fires, every tick would wait for the next time it does.
        """
        early = since + self.schedule.period // EARLY
        self.progress = Progress(monotonic_ns() - early)
        self.anchor = time_ns() - since

    def ticks(self) -> range:
        """Places in the schedule of the ticks that are due now."""
        self.progress, count = due(self.schedule, self.progress, monotonic_ns())
        return range(self.progress.done - count, self.progress.done)

    def stamp(self, place: int, tick: int) -> int:
        """Stamp of a tick [ns]: when it was due, or its simulated time."""
        return self.anchor + place * self.dt if self.real else tick * self.dt

    def now(self, tick: int) -> int:
        """Time on the clock of the stamps [ns]; the simulated one stands still at the last tick."""
        if not self.real:
            return tick * self.dt
        early = self.schedule.period // EARLY
        return self.anchor + monotonic_ns() - self.progress.start - early

    def late(self, place: int) -> float:
        """How long ago a tick was due [s]."""
        early = self.schedule.period // EARLY
        due_at = self.progress.start + early + place * self.schedule.period
        return 1e-9 * (monotonic_ns() - due_at)

    def follow_clock(self) -> None:
        """Let the stamps follow a system clock that was set."""
        step = time_ns() - self.now(0) if self.real else 0
        if abs(step) > CLOCK_STEP:
            self.anchor += step
            self.clock_steps += 1
