"""What a node computes, apart from the node: messages in, messages out, with a state in between.

A core reads its files when it is made and never again, knows no clock, and is told when things came. So a recording
that is played to it gives, bit for bit, what the node said.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from importlib import import_module
from typing import Any, NamedTuple

from er_common.common_parameters import Listening
from er_common.program import Program
from er_common.quality import Quality
from er_common.stamps import Checks, StampLimits, Verdict, check_input
from er_common.topics import Topic

from er_ros_common.builders import Tick, tick_of
from er_ros_common.health import Report

Said = tuple[Topic, Any]
"""A message to be published, and where."""


by_place = tuple.__new__
"""Makes a named tuple from all its fields in order, at a quarter of the time of its own constructor or `_replace`."""


class When(NamedTuple):
    """When something came: on the steady clock [ns], and on the node's own [ns], None where ages mean nothing."""

    steady: int
    system: int | None


class Core:
    """Inputs, outputs, and the steps between; below the first four what many cores have nothing to do for.

    p: its parameters. inputs: what it listens to; optional: those whose absence is no fault; limits: when the stamp of
    each is refused. outputs: what it may say something on. model_id, gains_id: digests, empty where there is none.
    """

    p: Listening
    inputs: tuple[Topic, ...]
    optional: tuple[Topic, ...] = ()
    limits: tuple[StampLimits, ...]
    outputs: tuple[Topic, ...]
    model_id: str = ""
    gains_id: str = ""

    def tuned(self, _: Any) -> Core:
        """The same core with other dynamic parameters; see `taken_over`. Raises `ErError` as its maker."""
        raise NotImplementedError

    def taken_over(self, state: Any, _before: Any) -> Any:
        """A state of the core before as the beginning of this one."""
        return state

    def goes_by(self, _state: Any) -> str:
        """Its model, and from which sample on, for the log; for cores whose model may change."""
        return ""

    def start(self) -> Any:
        """State before any message."""
        raise NotImplementedError

    def on_message(
        self, state: Any, topic: Topic, message: Any, when: When
    ) -> tuple[Any, list[Said]]:
        """The state after a message, and what is to be published for it."""
        raise NotImplementedError

    def on_time(self, state: Any, when: When) -> tuple[Any, list[Said]]:
        """The same where only time has gone on; called often, says something where inputs stay away."""
        raise NotImplementedError

    def report(self, state: Any) -> Report:
        """Health; without a mode where nothing has come yet: then the node says whom it waits for."""
        raise NotImplementedError

    def urgent(self, _before: Any, _after: Any) -> bool:
        """Whether the health is to be said at once, as something has changed between two states."""
        return False

    def notes(self) -> list[Said]:
        """What is said once, when the files are read."""
        return []

    def last_words(self, _state: Any, _when: When) -> list[Said]:
        """What is left behind when the node ends."""
        return []


class Shell(NamedTuple):
    """How a core is made, and what the node around it has to know before there is one.

    parameters: their dataclass, of which `make` makes the core; raises `ErError` where that cannot be.
    hears, says: topics for the help. period: how often the silence of the inputs is looked at [s]; patience: how long
    the core has nothing to say of it, where that is less than until they count as dead [s]. asked: quality of the
    subscriptions, None: that of each topic. whole: inputs of no use without all of their parts. around: module whose
    `AROUND` is the class of the node around it, where that does more than carry messages.
    """

    parameters: type[Any]
    make: Callable[[Any], Core]
    hears: tuple[Topic, ...]
    says: tuple[Topic, ...]
    period: float = 0.01
    patience: float = math.inf
    asked: Quality | None = None
    whole: tuple[Topic, ...] = ()
    around: str = ""


def shell_of(program: Program) -> Shell:
    """The row of a program in the `CORES` of its module."""
    found: Shell = import_module(program.path).CORES[program]
    return found


def judged(
    core: Core, checks: Checks, topic: Topic, message: Any, when: When
) -> tuple[Checks, Verdict, Tick]:
    """The stamp of a message of one of the inputs, judged before anything is kept of it."""
    tick = tick_of(message)
    arrival, which = when.system if core.p.max_age else None, core.inputs.index(topic)
    checks, verdict = check_input(core.limits, checks, which, *tick, arrival)
    return checks, verdict, tick
