"""Lines in a node's log, in time for a loop at 200 Hz."""

from __future__ import annotations

from rclpy.logging import LoggingSeverity
from rclpy.node import Node

from er_ros_common.private import write

LEVELS = (LoggingSeverity.INFO, LoggingSeverity.WARN, LoggingSeverity.ERROR)
"""Of the log, by those of diagnostics."""


def info(node: Node, text: str) -> None:
    """Something worth knowing."""
    write(node, LoggingSeverity.INFO, text)


def warning(node: Node, text: str) -> None:
    """Something that still works but needs attention."""
    write(node, LoggingSeverity.WARN, text)


def at_level(node: Node, level: int, text: str) -> None:
    """As bad as a level of diagnostics says: 0 OK, 1 WARN, 2 ERROR."""
    write(node, LEVELS[level], text)
