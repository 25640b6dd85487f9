"""Asks every node of the graph for its parameters, without waiting for anybody."""

from __future__ import annotations

from collections.abc import Callable
from time import monotonic
from typing import Any

from rcl_interfaces.srv import GetParameters, ListParameters
from rclpy.client import Client
from rclpy.node import Node
from rclpy.parameter import parameter_value_to_python

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
    """First the names, then the values, of the parameters of one node."""

    def __init__(self, node: Node, full: str, found: dict[str, dict[str, Any]]) -> None:
        self.full, self.found = full, found
        self.first, self.sent = monotonic(), 0.0
        # clients live as long as the node: destroying one under the events executor is not safe
        self.names: Client = node.create_client(ListParameters, f"{full}/list_parameters")
        self.values: Client = node.create_client(GetParameters, f"{full}/get_parameters")

    def look(self) -> None:
        """Ask once somebody is there to answer, and again as long as no answer came."""
        now = monotonic()
        late = self.full in self.found or now - self.first > GIVE_UP
        if late or now - self.sent < AGAIN or not self.names.service_is_ready():
            return
        self.sent = now
        self.names.call_async(ListParameters.Request()).add_done_callback(self._on_names)

    def _on_names(self, answer: Any) -> None:
        names = list(answer.result().result.names)
        asked = self.values.call_async(GetParameters.Request(names=names))
        asked.add_done_callback(lambda future: self._on_values(names, future))

    def _on_values(self, names: list[str], answer: Any) -> None:
        values = (parameter_value_to_python(value) for value in answer.result().values)
        plain = {
            name: list(value)
            if hasattr(value, "__iter__") and not isinstance(value, str)
            else value
            for name, value in zip(names, values, strict=True)
        }
        self.found[self.full] = {
            k: v for k, v in plain.items() if not k.startswith("qos_overrides")
        }
