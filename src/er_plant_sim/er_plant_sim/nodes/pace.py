"""When the ticks are, and their stamps: of the system clock, or simulated time from zero."""

from __future__ import annotations

from time import monotonic_ns, time_ns

from er_plant_sim.schedule import Progress, Schedule, due

CLOCK_STEP = 10_000_000
"""Difference between the system clock and the stamps beyond which the stamps follow [ns]."""


class Pace:
    """An absolute schedule on the steady clock, and the stamp of each of its ticks [ns].

    In real time the stamps are the system's time at which a tick was due. They do not follow the
    small corrections of a system clock, and follow at once where it was set.
    """

    def __init__(self, dt: float, rate_factor: float, *, real: bool) -> None:
        self.dt = round(1e9 * dt)
        self.real = real
        self.schedule = Schedule(period=max(round(1e9 * dt / rate_factor), 1))
        self.progress = Progress(monotonic_ns())
        self.anchor = time_ns()
        self.clock_steps = 0

    def restart(self) -> None:
        """Begin the schedule now."""
        self.progress = Progress(monotonic_ns())
        self.anchor = time_ns()

    def ticks(self) -> range:
        """Places in the schedule of the ticks that are due now."""
        self.progress, count = due(self.schedule, self.progress, monotonic_ns())
        return range(self.progress.done - count, self.progress.done)

    def stamp(self, place: int, tick: int) -> int:
        """Stamp of a tick [ns]: when it was due, or its simulated time."""
        return self.anchor + place * self.dt if self.real else tick * self.dt

    def follow_clock(self) -> None:
        """Let the stamps follow a system clock that was set."""
        step = time_ns() - (self.anchor + monotonic_ns() - self.progress.start)
        if abs(step) > CLOCK_STEP:
            self.anchor += step
            self.clock_steps += 1
