"""Parameters that several nodes have, in the same words and within the same bounds."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any, Protocol

from er_models.constants import SAMPLE_RATE

from er_common.parameter_table import param, tuning
from er_common.stamps import SECOND


def oldest_sample() -> Any:
    """Field `max_age`: samples older than this are not used [s]."""
    text = "oldest sample that is used; 0: any (simulated time)"
    return param(0.02, unit="s", low=0.0, high=1.0, text=text)


def sample_rate() -> Any:
    """Field `rate`: samples per second that what the node computes with is made for [Hz]."""
    text = "samples per second, those of the plant or the rig"
    return param(SAMPLE_RATE, unit="Hz", low=10.0, high=2000.0, text=text)


STANDSTILL = 10.0
"""Silence that counts as `timeout` where the samples keep a pace of their own: until then somebody is held up [s]."""


class Listening(Protocol):
    """What a node with inputs is told of their silence."""

    @property
    def timeout(self) -> float:
        """Silence after which the inputs count as dead [s]."""

    @property
    def max_age(self) -> float:
        """Oldest sample that is used [s]; 0: any, as the samples keep a pace of their own."""

    @property
    def pace(self) -> float:
        """That pace against the steady clock; 0: not known."""


def silence(p: Listening, nanoseconds: int) -> float:
    """How long inputs have been silent, as it counts against the timeout [s]; nanoseconds: on the steady clock."""
    seconds = 1e-9 * nanoseconds
    return seconds if p.max_age else seconds * (p.pace or p.timeout / STANDSTILL)


def deaf_after(p: Listening) -> float:
    """Silence on the steady clock after which inputs count as dead [s]."""
    return p.timeout / silence(p, SECOND)


def leaving_out() -> Any:
    """Field `leave_out`: whether a model with more effects than a law can hold is taken without them."""
    text = "whether effects of the model that its law cannot hold are left out; false: such a model is refused"
    return tuning(False, text=text)


def awaited_listeners() -> Any:
    """Field `listeners`: how many must have found the output before the node is ready."""
    return param(0, low=0, high=100, text="subscribers of its output to find before it is ready")


def injection_allowed() -> Any:
    """Field `enable_fault_injection`: whether the service does anything."""
    return param(False, text="let ~/inject_fault spoil sensors and commands, for tests")


@dataclass(frozen=True, kw_only=True)
class NodeParameters:
    """What every node has; the table of a node inherits it."""

    autostart: bool = param(
        True, fixed=True, text="configure and activate by itself; false: a manager does"
    )
    executor: str = param(
        "events",
        choices=("events", "single"),
        fixed=True,
        text="what runs callbacks; single costs more",
    )
    priority: int = param(
        0,
        low=0,
        high=99,
        text="real-time priority (SCHED_FIFO) while it acts; 0: none is asked for",
    )
    pace: float = param(
        0.0,
        low=0.0,
        high=1.0,
        text="pace of simulated time that silence is measured in; 0: none, as in lockstep",
    )


@dataclass(frozen=True, kw_only=True)
class FramedParameters(NodeParameters):
    """What a node has whose messages are of a corner, whatever it computes them from."""

    frame_id: str = param("damper", text="header.frame_id of what it says of the corner")
