"""What a node computes, apart from the node: messages in, messages out, with a state in between.

A core reads its files when it is made and never again, knows no clock, and is told when things came. So a recording
that is played to it gives, bit for bit, what the node said.
"""

from __future__ import annotations

from typing import Any, NamedTuple, Protocol

from er_common.common_parameters import Listening
from er_common.stamps import Checks, StampLimits, Verdict, check_input

from er_ros_common.builders import Tick, tick_of
from er_ros_common.topics import Topic

Said = tuple[Topic, Any]
"""A message to be published, and where."""


by_place = tuple.__new__
"""Makes a named tuple from all its fields in order, at a quarter of the time of its own constructor or `_replace`."""


class When(NamedTuple):
    """When something came: on the steady clock [ns], and on the node's own [ns], None where ages mean nothing."""

    steady: int
    system: int | None


class Core(Protocol):
    """Inputs, outputs, and the steps between."""

    @property
    def p(self) -> Listening:
        """Its parameters."""

    @property
    def inputs(self) -> tuple[Topic, ...]:
        """What it listens to."""

    @property
    def optional(self) -> tuple[Topic, ...]:
        """Those of them whose absence is no fault."""

    @property
    def limits(self) -> tuple[StampLimits, ...]:
        """When the stamp of each input is refused."""

    @property
    def outputs(self) -> tuple[Topic, ...]:
        """What it may say something on."""

    @property
    def model_id(self) -> str:
        """Digest of the model, empty where there is none."""

    @property
    def gains_id(self) -> str:
        """Digest of the gains, empty where there are none."""

    def start(self) -> Any:
        """State before any message."""

    def on_message(
        self, state: Any, topic: Topic, message: Any, when: When
    ) -> tuple[Any, list[Said]]:
        """The state after a message, and what is to be published for it."""

    def on_time(self, state: Any, when: When) -> tuple[Any, list[Said]]:
        """The same where only time has gone on; called often, says something where inputs stay away."""


class Judging(Protocol):
    """What of a core tells good stamps from bad ones."""

    @property
    def p(self) -> Listening:
        """Its parameters."""

    @property
    def inputs(self) -> tuple[Topic, ...]:
        """What it listens to."""

    @property
    def limits(self) -> tuple[StampLimits, ...]:
        """When the stamp of each input is refused."""


def judged(
    core: Judging, checks: Checks, topic: Topic, message: Any, when: When
) -> tuple[Checks, Verdict, Tick]:
    """The stamp of a message of one of the inputs, judged before anything is kept of it."""
    tick = tick_of(message)
    arrival, which = when.system if core.p.max_age else None, core.inputs.index(topic)
    checks, verdict = check_input(core.limits, checks, which, *tick, arrival)
    return checks, verdict, tick
