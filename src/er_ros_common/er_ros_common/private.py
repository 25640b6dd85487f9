"""What rclpy has no public name for, all of it here; made for the versions in `MADE_FOR`.

An error class of rcl, parameters that were given but not declared, the label of a lifecycle node's state, the answer
to a manager whose transition the state does not have, and a log line without the look-up of who wrote it.
"""

from __future__ import annotations

from typing import Any, Final

from lifecycle_msgs.srv import ChangeState
from rclpy._rclpy_pybind11 import RCLError, UnknownROSArgsError
from rclpy.impl.implementation_singleton import rclpy_implementation
from rclpy.lifecycle import LifecycleNode
from rclpy.logging import LoggingSeverity
from rclpy.node import Node
from rclpy.parameter import Parameter

__all__ = [
    "MADE_FOR",
    "RCLError",
    "SteadyLifecycleNode",
    "UnknownROSArgsError",
    "overrides",
    "write",
]
MADE_FOR: Final = (7, 1)
"""Version of rclpy, of Jazzy: a test looks at every name again where it is another one."""


class SteadyLifecycleNode(LifecycleNode):
    """A lifecycle node that survives a manager's mistake, and can say in which state it is."""

    @property
    def state_label(self) -> str:
        """Name of the state: unconfigured, inactive, active, finalized."""
        return str(self._state_machine.current_state[1])

    def _LifecycleNodeMixin__on_change_state(
        self, asked: ChangeState.Request, answer: ChangeState.Response
    ) -> ChangeState.Response:
        """Answer a manager; a transition that this state does not have ends rclpy's own node with a traceback."""
        try:
            return super()._LifecycleNodeMixin__on_change_state(asked, answer)  # type: ignore[misc]
        except RCLError:
            answer.success = False
            return answer


def overrides(node: Node) -> dict[str, Parameter[Any]]:
    """What the command line, files and the constructor give, declared or not."""
    found: dict[str, Parameter[Any]] = node._parameter_overrides
    return found


def write(node: Node, severity: LoggingSeverity, text: str) -> None:
    """A line in the node's log; rclpy's own logger looks up file and line of the caller, which takes 4 ms."""
    logger = node.get_logger()
    if logger.is_enabled_for(severity):
        put = rclpy_implementation.rclpy_logging_rcutils_log
        put(severity, logger.name, text, "", __name__, 0)
