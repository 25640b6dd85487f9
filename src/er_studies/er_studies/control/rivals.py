"""The controllers that are compared, behind one interface: fault-tolerant LPV, nominal LPV, Skyhook, passive."""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import replace
from functools import partial
from typing import Any, NamedTuple

from er_ftc_controller.control import HEALTHY, Command, Faults, Ftc, Mode, Sample
from er_ftc_controller.skyhook import Skyhook

from er_ftc_controller import control, skyhook


class Law(NamedTuple):
    """A controller: its first state, what it makes of a fault estimate, and its step, as those of `control`."""

    start: Callable[[], Any]
    hear: Callable[[Any, Faults], Any]
    step: Callable[[Any, float, Sample | None], tuple[Any, Command]]


def fault_tolerant(p: Ftc) -> Law:
    """The controller with the domain of the faulty damper."""
    return Law(partial(control.start, p), partial(control.hear, p), partial(control.step, p))


def nominal(p: Ftc) -> Law:
    """The same with the domain of the healthy damper, whatever the faults."""
    return fault_tolerant(replace(p, rules=replace(p.rules, adapt=False)))


def passive(duty: float) -> Law:
    """A constant duty."""
    command = _plain(duty)
    return Law(lambda: None, _deaf, lambda state, _t, _sample: (state, command))


def two_states(p: Skyhook) -> Law:
    """Skyhook (3.81)."""

    def step(
        state: skyhook.State, t: float, sample: Sample | None
    ) -> tuple[skyhook.State, Command]:
        if sample is None:
            return state, _plain(p.u_min)
        seen = skyhook.Sample(t, sample.sprung_acceleration, sample.velocity)
        if not skyhook.usable(seen):
            return state, _plain(p.u_min)
        state, command = skyhook.step(p, state, seen)
        return state, _plain(command.duty)

    return Law(lambda: skyhook.START, _deaf, step)


def _plain(duty: float) -> Command:
    """A duty of a controller that asks for no force."""
    return Command(duty, Mode.NOMINAL, "", math.nan, math.nan, math.nan, HEALTHY)


def _deaf(state: Any, _faults: Faults) -> Any:
    """Fault estimates change nothing."""
    return state
