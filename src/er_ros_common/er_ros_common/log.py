"""Lines in a node's log, by the call beneath rclpy's logger.

That one looks up file and line of whoever calls it, which takes 4 ms, a loop at 200 Hz nearly whole.
"""

from __future__ import annotations

from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.logging import LoggingSeverity
from rclpy.node import Node


def info(node: Node, text: str) -> None:
    """Something worth knowing."""
    _log(node, LoggingSeverity.INFO, text)


def warning(node: Node, text: str) -> None:
    """Something that still works but needs attention."""
    _log(node, LoggingSeverity.WARN, text)


def _log(node: Node, severity: LoggingSeverity, text: str) -> None:
    logger = node.get_logger()
    if logger.is_enabled_for(severity):
        write = rclpy_implementation.rclpy_logging_rcutils_log
        write(severity, logger.name, text, "", __name__, 0)
