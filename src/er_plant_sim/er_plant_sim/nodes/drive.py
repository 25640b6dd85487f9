"""What makes the plant tick: time, or the commands that answer its samples."""

from __future__ import annotations

from collections.abc import Callable
from time import monotonic

from er_plant_sim.nodes.pace import Pace

ANSWER_TIMEOUT = 0.05
"""Longest wait in lockstep for the command that answers a sample [s]."""

Sense = Callable[[int], int]
"""Publishes the sample of a place in the schedule; returns its seq."""
Act = Callable[[], bool]
"""Decides the duty of the last sample and goes on to the next; false when it was the last."""


class Timed:
    """A sample whenever one is due, acted upon at once with the newest command."""

    def __init__(self, pace: Pace, sense: Sense, act: Act) -> None:
        self.pace, self.sense, self.act = pace, sense, act
        self.timeouts = 0

    def on_time(self) -> None:
        """Run the ticks that are due."""
        for place in self.pace.ticks():
            self.sense(place)
            if not self.act():
                return

    def on_command(self, seq: int) -> None:
        """A command waits for the next tick."""


class Answered:
    """A sample, then nothing until it is answered or the wait is over: lockstep.

    paced: the next sample is also not sent before it is due.
    """

    def __init__(self, pace: Pace, sense: Sense, act: Act, *, paced: bool) -> None:
        self.pace, self.sense, self.act, self.paced = pace, sense, act, paced
        self.timeouts, self.due, self.asked, self.asked_at = 0, 0, 0, 0.0

    def on_time(self) -> None:
        """Send the next sample, or give up waiting for the answer to the last one."""
        self.due += len(self.pace.ticks())
        if not self.asked:
            self._ask()
        elif monotonic() - self.asked_at > ANSWER_TIMEOUT:
            self.timeouts += 1
            self._go_on()

    def on_command(self, seq: int) -> None:
        """Go on if this answers the last sample."""
        if self.asked and seq == self.asked:
            self._go_on()

    def _go_on(self) -> None:
        self.asked = 0
        if self.act():
            self._ask()

    def _ask(self) -> None:
        if self.paced and self.due <= 0:
            return
        self.due = max(self.due - 1, 0)
        self.asked, self.asked_at = self.sense(0), monotonic()
