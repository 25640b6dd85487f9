"""Parameters that several nodes have, in the same words and within the same bounds."""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

from er_ros_common.parameter_table import param


def oldest_sample() -> Any:
    """Field `max_age`: samples older than this are not used [s]."""
    text = "oldest sample that is used; 0: any (simulated time)"
    return param(0.02, unit="s", low=0.0, high=1.0, text=text)


STANDSTILL = 10.0
"""Silence that counts as `timeout` where the samples keep a pace of their own: until then somebody is held up [s]."""


def away(nanoseconds: int, timeout: float, max_age: float) -> float:
    """How long samples have stayed away, as it counts against `timeout` [s]; nanoseconds: on the steady clock."""
    seconds = 1e-9 * nanoseconds
    return seconds if max_age else seconds * timeout / STANDSTILL


def awaited_listeners() -> Any:
    """Field `listeners`: how many must have found the output before the node is ready."""
    return param(0, low=0, high=100, text="subscribers of its output to find before it is ready")


def injection_allowed() -> Any:
    """Field `enable_fault_injection`: whether the service does anything."""
    return param(False, text="let ~/inject_fault spoil sensors and commands, for tests")


@dataclass(frozen=True, kw_only=True)
class NodeParameters:
    """What every node has; the table of a node inherits it."""

    autostart: bool = param(True, text="configure and activate by itself; false: a manager does")
    executor: str = param(
        "events", choices=("events", "single"), text="what runs callbacks; single costs more"
    )
