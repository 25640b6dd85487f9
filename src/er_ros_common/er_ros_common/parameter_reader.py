"""Asks every node of the graph for its parameters, without waiting for anybody."""

from __future__ import annotations

from collections.abc import Callable
from time import monotonic
from typing import Any

from rcl_interfaces.msg import ParameterValue
from rcl_interfaces.srv import GetParameters, ListParameters
from rclpy.client import Client
from rclpy.node import Node
from rclpy.parameter import parameter_value_to_python

from er_ros_common import log

AGAIN = 1.0
"""Time after which a question is asked again [s]: an answer is lost where its sender has not yet
found whom to send it to."""
GIVE_UP = 30.0
"""Time after which a node that does not answer is no longer asked [s]."""


class ParameterReader:
    """Parameters by full node name, as far as they were answered; `look` now and then."""

    def __init__(self, node: Node, wanted: Callable[[str], bool]) -> None:
        self.node, self.wanted = node, wanted
        self.found: dict[str, dict[str, Any]] = {}
        self._asked: dict[str, _Question] = {}

    def look(self) -> None:
        """Ask the nodes that appeared since the last look."""
        own = self.node.get_fully_qualified_name()
        for name, namespace in self.node.get_node_names_and_namespaces():
            full = f"{namespace.rstrip('/')}/{name}"
            if full != own and full not in self._asked and self.wanted(full):
                self._asked[full] = _Question(self.node, full, self.found)
        for question in self._asked.values():
            question.look()


class _Question:
    """First the names, then the values, of the parameters of one node.

    A node of rclpy answers with no value at all where one of those asked for has none: such a group is asked again in
    halves, one after the other, since a service keeps no more than ten requests.
    """

    def __init__(self, node: Node, full: str, found: dict[str, dict[str, Any]]) -> None:
        self.node, self.full, self.found = node, full, found
        self.first, self.sent = monotonic(), 0.0
        self.groups: list[list[str]] | None = None
        # clients live as long as the node: destroying one under the events executor is not safe
        self.names: Client = node.create_client(ListParameters, f"{full}/list_parameters")
        self.values: Client = node.create_client(GetParameters, f"{full}/get_parameters")

    def look(self) -> None:
        """Ask once somebody is there to answer, and again as long as no answer came."""
        now = monotonic()
        late = self.groups == [] or now - self.first > GIVE_UP
        if late or now - self.sent < AGAIN or not self.names.service_is_ready():
            return
        self._ask()

    def _ask(self) -> None:
        """What is to be asked next."""
        self.sent = monotonic()
        if self.groups is None:
            self.names.call_async(ListParameters.Request()).add_done_callback(
                self._sure(self._on_names)
            )
        elif self.groups:
            group = self.groups[0]
            self.values.call_async(GetParameters.Request(names=group)).add_done_callback(
                self._sure(lambda answer: self._on_values(group, answer))
            )

    def _sure(self, take: Callable[[Any], None]) -> Callable[[Any], None]:
        """An answer's callback that raises nothing: what it raises ends the events executor with a SIGSEGV."""

        def call(future: Any) -> None:
            try:
                take(future.result())
            except Exception as error:  # whatever another node's answer provokes
                self.groups = []
                why = " ".join(str(error).split())
                log.warning(self.node, f"parameters of {self.full} cannot be read: {why}")

        return call

    def _on_names(self, answer: Any) -> None:
        if self.groups is None:
            self.groups = [list(answer.result.names)]
            self._ask()

    def _on_values(self, group: list[str], answer: Any) -> None:
        if not self.groups or self.groups[0] is not group:
            # the same was answered before
            return
        values = list(answer.values)
        half = len(group) // 2
        self.groups.pop(0)
        if len(values) == len(group):
            self._keep(dict(zip(group, values, strict=True)))
        elif half:
            self.groups[:0] = [group[:half], group[half:]]
        if not self.groups:
            self._keep({})
        self._ask()

    def _keep(self, values: dict[str, ParameterValue]) -> None:
        own = self.found.setdefault(self.full, {})
        own.update({k: plain(v) for k, v in values.items() if not k.startswith("qos_overrides")})


def plain(value: ParameterValue) -> Any:
    """A parameter's value as JSON knows it; None where it has none, or one of a type that does not exist."""
    try:
        found = parameter_value_to_python(value)
    except RuntimeError:
        return None
    if isinstance(found, list):
        return [each[0] if isinstance(each, bytes) else each for each in found]
    return found
