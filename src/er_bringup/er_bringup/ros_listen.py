"""Listens to a running graph for `er doctor`; what is heard is judged in `ros_checks`."""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from time import monotonic, sleep, time_ns
from typing import Any

import rclpy
from er_common.stamps import StampLimits
from er_common.topics import Topic
from er_ros_common.builders import tick_of
from er_ros_common.graph_check import UNNAMED, Ends, compatible, endpoints
from er_ros_common.parameter_reader import ParameterReader
from er_ros_common.spin import make_executor
from rclpy.node import Node
from rclpy.task import Future
from rclpy.utilities import try_shutdown

from er_bringup.ros_checks import CONTRACT, Heard, Observation, SeenNode, clocks, namespaces
from er_common import topics
from er_damper_msgs.msg import NodeStatus
from er_ros_common import environment

DEPTH = 500
DISCOVERY, SETTLE = 8.0, 1.0
"""Longest wait until the graph is known, and for how long nothing new must have come up until it is [s]."""
ANSWERS = 3.0
"""Longest wait for parameters and names that nodes have not sent by the end of listening [s]."""
LOOK = 0.25
STATUS_ENDING = "/status"
TASKS = ("input rate", "stamps", "values", "timing")
"""Diagnostics of the nodes that this command cannot know by itself."""
LIMITS = StampLimits()


@dataclass
class _Log:
    """Messages of one topic."""

    topic: Topic
    name: str
    arrivals: list[float] = field(default_factory=list)
    ages: list[float] = field(default_factory=list)
    seq: int = 0
    lost: int = 0
    zero: int = 0
    invalid: int = 0
    non_finite: int = 0
    stamp: int = 0
    jumps: list[float] = field(default_factory=list)
    numbers: tuple[str, ...] = ()

    def __post_init__(self) -> None:
        self.numbers = self.topic.numbers

    def on_message(self, message: Any) -> None:
        """Note one message."""
        stamp, seq = tick_of(message)
        self.arrivals.append(monotonic())
        if stamp == 0:
            self.zero += 1
        else:
            self.ages.append(1e-9 * (time_ns() - stamp))
        step = 1e-9 * (stamp - self.stamp)
        if self.stamp and stamp and not -LIMITS.back <= step <= LIMITS.back:
            self.jumps.append(step)
        self.stamp = stamp
        if seq > self.seq > 0:
            self.lost += seq - self.seq - 1
        self.seq = seq
        self.invalid += not message.valid
        numbers = (getattr(message, name) for name in self.numbers)
        self.non_finite += message.valid and not all(map(math.isfinite, numbers))

    def clear(self) -> None:
        """Forget what came before the measurement."""
        self.arrivals.clear()
        self.ages.clear()
        self.jumps.clear()
        self.seq = self.lost = self.zero = self.invalid = self.non_finite = self.stamp = 0


def observe(namespace: str | None, seconds: float) -> list[Observation]:
    """What goes on in a namespace ('' is the root) during this time [s]; starts and ends rclpy.

    None: in each namespace that holds a graph, one after the other; in the root where none is found.
    """
    environment.settle()
    rclpy.init(args=[])
    try:
        spaces = _graphs() if namespace is None else [namespace]
        seen = []
        for space in spaces:
            node = Node("doctor", namespace=space, enable_rosout=False)
            listener = _Listener(node, space, known=namespace is None)
            seen.append(listener.observe(seconds))
            listener.executor.remove_node(node)
            listener.executor.shutdown(timeout_sec=0.0)
            node.destroy_node()
        return seen
    finally:
        try_shutdown()


def _graphs() -> list[str]:
    """Namespaces in which a topic of the contract is, once nothing new comes up; the root where there is none."""
    node = Node("doctor_looking", enable_rosout=False)
    began = changed = monotonic()
    ends: dict[str, int] = {}
    while (at := monotonic()) - began < DISCOVERY and not (ends and at - changed >= SETTLE):
        sleep(LOOK)
        names = [name for name, _ in node.get_topic_names_and_types() if namespaces([name])]
        before, ends = ends, {name: node.count_publishers(name) for name in names}
        if ends != before:
            changed = monotonic()
    node.destroy_node()
    return namespaces(list(ends)) or [""]


class _Listener:
    """Subscribes to whatever the contract names and is there."""

    def __init__(self, node: Node, namespace: str, *, known: bool = False) -> None:
        self.node, self.known = node, known
        self.namespace = f"/{namespace.strip('/')}" if namespace.strip("/") else ""
        self.logs = {t.name: _Log(t, f"{self.namespace}/{t.name}") for t in CONTRACT}
        self.subscribed: set[str] = set()
        self.status: dict[str, NodeStatus] = {}
        self.said: dict[str, tuple[int, str]] = {}
        self.diagnosed = False
        self.parameters = ParameterReader(node, self._inside)
        self.executor = make_executor(node)
        self.executor.add_node(node)

    def _inside(self, full: str) -> bool:
        return full.startswith(f"{self.namespace}/")

    def observe(self, seconds: float) -> Observation:
        """Find the graph, then listen."""
        if not self.known:
            self._discover()
        self._turn(LOOK)
        for log in self.logs.values():
            log.clear()
        self._turn(seconds)
        heard = self._all_named()
        self._wait_for_answers()
        said = tuple((name, *rest) for name, rest in sorted(self.said.items()))
        nodes, times = tuple(self._nodes()), clocks(self._clocks(), self.namespace)
        return Observation(self.namespace, seconds, heard, nodes, times, said)

    def _clocks(self) -> dict[str, Ends]:
        """Ends of every topic of simulated time: each of several plants has its own."""
        known = self.node.get_topic_names_and_types()
        names = [name for name, kinds in known if topics.CLOCK.type_name in kinds]
        return {name: endpoints(self.node, name) for name in names}

    def _all_named(self) -> tuple[Heard, ...]:
        """What was heard, once every end has a name: of a process that has just come the ends are known before it."""
        until = monotonic() + ANSWERS
        while True:
            heard = tuple(self._heard(log) for log in self.logs.values())
            ends = [end for each in heard for end in (*each.publishers, *each.subscribers)]
            if all(end.node != UNNAMED for end in ends) or monotonic() >= until:
                return heard
            self._turn(LOOK)

    def _wait_for_answers(self) -> None:
        """Give nodes that were asked for their parameters late some time to answer."""
        until = monotonic() + ANSWERS
        while not self.status.keys() <= self.parameters.found.keys() and monotonic() < until:
            self._turn(LOOK)

    def _discover(self) -> None:
        """Wait until nothing new comes up: a busy machine finds a graph piece by piece."""
        began = changed = monotonic()
        ends = self._ends()
        while (at := monotonic()) - began < DISCOVERY:
            if any(ends) and at - changed >= SETTLE:
                return
            self._turn(LOOK)
            before, ends = ends, self._ends()
            if ends != before:
                changed = monotonic()

    def _ends(self) -> list[int]:
        """How many publishers each topic is known to have."""
        return [self.node.count_publishers(log.name) for log in self.logs.values()]

    def _turn(self, seconds: float) -> None:
        """Handle messages for this time, looking for new topics now and then."""
        until = monotonic() + seconds
        while (left := until - monotonic()) > 0.0:
            self._look()
            self.executor.spin_until_future_complete(Future(), timeout_sec=min(LOOK, left))

    def _look(self) -> None:
        self.parameters.look()
        for log in self.logs.values():
            self._subscribe(log.name, log.topic, log.on_message)
        for name, kinds in self.node.get_topic_names_and_types():
            ours = self._inside(name) and name.endswith(STATUS_ENDING)
            if ours and topics.STATUS.type_name in kinds:
                self._subscribe(name, topics.STATUS, self._on_status)

        if not self.diagnosed:
            self.diagnosed = True
            there = topics.DIAGNOSTICS
            self.node.create_subscription(there.type, there.name, self._on_diagnostics, DEPTH)

    def _on_diagnostics(self, message: Any) -> None:
        """Keep what our nodes say of their inputs; state and graph are looked at here."""
        for entry in message.status:
            node, _, task = entry.name.rpartition(": ")
            if self._inside(f"/{node.lstrip('/')}") and task in TASKS:
                self.said[entry.name] = (entry.level[0], entry.message)

    def _subscribe(self, name: str, topic: Topic, heard: Any) -> None:
        """Subscribe once somebody publishes the right type."""
        publishers = self.node.get_publishers_info_by_topic(name)
        right = [info for info in publishers if info.topic_type == topic.type_name]
        if right and name not in self.subscribed:
            self.subscribed.add(name)
            self.node.create_subscription(topic.type, name, heard, compatible(right, DEPTH))

    def _on_status(self, message: NodeStatus) -> None:
        self.status[message.node] = message

    def _heard(self, log: _Log) -> Heard:
        publishers, subscribers = endpoints(self.node, log.name)
        own = self.node.get_fully_qualified_name()
        others = [end for end in subscribers if end.node != own]
        span = log.arrivals[-1] - log.arrivals[0] if log.arrivals else 0.0
        return Heard(
            topic=log.topic,
            name=log.name,
            publishers=tuple(publishers),
            subscribers=tuple(others),
            count=len(log.arrivals),
            span=span,
            ages=tuple(log.ages),
            lost=log.lost,
            zero=log.zero,
            invalid=log.invalid,
            non_finite=log.non_finite,
            jumps=tuple(log.jumps),
        )

    def _nodes(self) -> list[SeenNode]:
        """Nodes of this project: those that send a status."""
        found = []
        for name, said in sorted(self.status.items()):
            parameters = self.parameters.found.get(name)
            found.append(SeenNode(name, parameters, int(said.status), said.mode, said.reason))
        return found
