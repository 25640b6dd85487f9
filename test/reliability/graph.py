"""A running graph of processes, and what it does to its topics, for the runs that need real time."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from pathlib import Path
from time import monotonic
from typing import Any

import rclpy
from er_ros_common.clock import from_stamp
from er_ros_common.spin import make_executor

from er_common import topics
from er_damper_msgs.msg import PwmDuty
from er_ros_common import dds, qos, realtime
from test.graph_help import CONFIG, VEHICLE, Graph, Running, own_domain, plant_arguments

NODES = ("plant", "unified_observer", "skyhook_controller")
COMPILED = 300.0
"""Time [s] in which a graph runs that must compile first, all its nodes on one busy core."""
NUMBERS = {
    topics.PWM_APPLIED.name: ("duty",),
    topics.PWM_COMMAND.name: ("duty",),
    topics.estimated_force("unified").name: ("force", "force_sd", "test_ratio"),
}


class Listener:
    """Hears what a graph puts out: when, what is impossible in it, and what the duty was.

    lost: numbers missing, by topic; gaps: when they were missed [s]; refused: samples that were too old when a node
    had them, by node.
    """

    def __init__(self, domain: int) -> None:
        dds.settle()
        rclpy.init(args=[], domain_id=domain)
        self.node = rclpy.create_node("listener")
        self.executor = make_executor(self.node)
        self.executor.add_node(self.node)
        self.last = dict.fromkeys(NUMBERS, -math.inf)
        self.count = dict.fromkeys(NUMBERS, 0)
        self.seq = dict.fromkeys(NUMBERS, 0)
        self.lost = dict.fromkeys(NUMBERS, 0)
        self.gaps: list[float] = []
        self.impossible: list[str] = []
        self.ages: list[float] = []
        self.nominal, self.good = -math.inf, -math.inf
        for topic in (topics.PWM_APPLIED, topics.PWM_COMMAND, topics.estimated_force("unified")):
            self.node.create_subscription(topic.type, topic.name, self._heard(topic), 100)
        self.refused = dict.fromkeys(NODES, 0)
        for name in NODES:
            kind, asked = topics.STATUS.type, qos.profile(topics.STATUS.subscriber)
            self.node.create_subscription(kind, f"{name}/status", self._status(name), asked)

    def _status(self, name: str) -> Callable[[Any], None]:
        def call(message: Any) -> None:
            self.refused[name] = int(message.stale)

        return call

    def _heard(self, topic: topics.Topic) -> Callable[[Any], None]:
        def call(message: Any) -> None:
            now = monotonic()
            self.last[topic.name] = now
            self.count[topic.name] += 1
            if message.seq > self.seq[topic.name] > 0:
                missing = message.seq - self.seq[topic.name] - 1
                self.lost[topic.name] += missing
                self.gaps += [now] * missing
            self.seq[topic.name] = message.seq
            for field in NUMBERS[topic.name]:
                if not math.isfinite(getattr(message, field)):
                    self.impossible.append(f"{topic.name} {field} {getattr(message, field)}")
            if topic is topics.PWM_APPLIED:
                self._duty(message, now)
            elif topic is topics.estimated_force("unified") and message.valid:
                self.good = now

        return call

    def _duty(self, message: PwmDuty, now: float) -> None:
        if not 0.0 <= message.duty <= 0.3:
            self.impossible.append(f"duty {message.duty}")
        if message.source == PwmDuty.SOURCE_NOMINAL:
            self.nominal = now
        clock = int(self.node.get_clock().now().nanoseconds)
        self.ages.append(1e-9 * (clock - from_stamp(message.header.stamp)))

    def strangers(self) -> str:
        """Who else publishes here, in words: another graph in the same domain spoils every count."""
        each = {name: self.node.count_publishers(name) for name in NUMBERS}
        return "".join(f"; {n} nodes publish {name}" for name, n in each.items() if n > 1)

    def until(self, there: Callable[[], bool], seconds: float) -> float:
        """Listen until something is true; how long it took [s], inf where it did not come."""
        began = monotonic()
        while not there():
            if monotonic() - began > seconds:
                return math.inf
            self.executor.spin_once(timeout_sec=0.01)
        return monotonic() - began

    def listen(self, seconds: float) -> None:
        """Listen for so long."""
        self.until(lambda: False, seconds)

    def close(self) -> None:
        """Leave the graph; what an executor still knows of would stay in it as long as this process."""
        self.executor.shutdown()
        self.node.destroy_node()
        rclpy.try_shutdown()


def arguments(name: str, priority: int = 0) -> list[str]:
    """Command line of a node of the closed loop."""
    own = [] if name == "plant" else ["--params-file", str(CONFIG / f"nodes/{name}.yaml")]
    more = {
        "plant": ("duration:=0.0", "duty_source:='topic'", "enable_fault_injection:=true"),
        "unified_observer": (f"model_file:={VEHICLE}", f"gains_file:={CONFIG / 'gains/unified.yaml'}"),
    }  # fmt: skip
    given = (*more.get(name, ()), f"priority:={priority}")
    words = [word for each in given for word in ("-p", each)]
    return plant_arguments(*words) if name == "plant" else ["--ros-args", *own, *words]


@contextmanager
def running(
    folder: Path, priority: int = 0
) -> Iterator[tuple[Graph, dict[str, Running], Listener]]:
    """The closed loop as processes, in a domain of its own, once it runs."""
    with own_domain() as env, Graph(env, folder) as graph:
        listener = Listener(int(env["ROS_DOMAIN_ID"]))
        try:
            nodes = {name: graph.start(name, *arguments(name, priority)) for name in NODES}
            assert math.isfinite(listener.until(lambda: well(listener), COMPILED)), "it never ran"
            if priority:  # who measures must not be held up either
                assert realtime.ask("listener", priority) == "", "no real-time priority here"
            yield graph, nodes, listener
        finally:
            realtime.give_back("listener")
            listener.close()


def well(listener: Listener) -> bool:
    """Whether the loop is closed and the observer sure, within the last tenth of a second."""
    now = monotonic()
    return now - listener.nominal < 0.1 and now - listener.good < 0.1
