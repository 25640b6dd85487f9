"""What makes the plant tick: time, or the commands that answer its samples."""

from __future__ import annotations

from collections.abc import Callable
from time import monotonic

from er_plant_sim.nodes.pace import Pace

PATIENCE = 10.0
"""Longest wait in lockstep for the command that answers a sample: a controller that is merely held up answers [s]."""
BRIEF = 0.05
"""The same where nothing is to be expected: the last wait was in vain, or a fault is injected [s]."""

Sense = Callable[[int], int]
"""Publishes the sample of a place in the schedule; returns its seq."""
Act = Callable[[], bool]
"""Decides the duty of the last sample and goes on to the next; false when it was the last."""
Between = Callable[[], None]
"""Called between two samples of one go, as where the machine stood still: what hears them has a queue of five."""


class Timed:
    """A sample whenever one is due, acted upon at once with the newest command."""

    def __init__(self, pace: Pace, sense: Sense, act: Act, between: Between) -> None:
        self.pace, self.sense, self.act, self.between = pace, sense, act, between
        self.timeouts = 0

    def on_time(self) -> None:
        """Run the ticks that are due."""
        places = self.pace.ticks()
        for place in places:
            self.sense(place)
            if not self.act():
                return
            if place < places[-1]:
                self.between()

    def on_command(self, seq: int) -> None:
        """A command waits for the next tick."""

    def on_recorded(self) -> None:
        """Time waits for no recording."""


class Lockstep:
    """A sample, then nothing until it is answered or the wait is over; nor before the recording follows.

    between: see `Between`; may: whether the recording follows; paced: the next sample is also not sent before it is
    due; answered: whether anybody answers (else the duty comes from a program); hopeless: whether the answer may be
    missing on purpose.
    """

    def __init__(
        self,
        pace: Pace,
        sense: Sense,
        act: Act,
        between: Between,
        may: Callable[[], bool],
        *,
        paced: bool,
        answered: bool,
        hopeless: Callable[[], bool],
    ) -> None:
        self.pace, self.sense, self.act = pace, sense, act
        self.between, self.may = between, may
        self.paced, self.answered, self.hopeless = paced, answered, hopeless
        self.timeouts, self.due, self.asked, self.asked_at = 0, 0, 0, 0.0
        self.silent = False

    def on_time(self) -> None:
        """Send the next sample, or give up waiting for the answer to the last one."""
        self.due += len(self.pace.ticks())
        if not self.asked:
            self._ask()
        elif monotonic() - self.asked_at > self._patience():
            self.timeouts, self.silent = self.timeouts + 1, True
            self._go_on()

    def _patience(self) -> float:
        return BRIEF if self.silent or self.hopeless() else PATIENCE

    def on_command(self, seq: int) -> None:
        """Go on if this answers the last sample."""
        if self.asked and seq == self.asked:
            self.silent = False
            self._go_on()

    def on_recorded(self) -> None:
        """Go on if it was the recording that was waited for."""
        if not self.asked:
            self._ask()

    def _go_on(self) -> None:
        self.asked = 0
        if self.act():
            self._ask()

    def _ask(self) -> None:
        while (self.due > 0 or not self.paced) and self.may():
            self.due = max(self.due - 1, 0)
            seq = self.sense(0)
            if self.answered:
                self.asked, self.asked_at = seq, monotonic()
                return
            if not self.act():
                return
            self.between()
