"""Listens to a running graph for the page: ``python -m er_model_lab.ros_live NAMESPACE``, started by `live.link`.

Messages are taken as bytes, all that have come some times a second: no callback runs at 200 Hz, and of a message only
the few numbers of a row are read. What is heard goes out as lines of JSON; what is asked comes in as such.
"""

from __future__ import annotations

import json
import os
import struct
import sys
from collections.abc import Callable, Iterator
from threading import Thread
from time import monotonic, sleep
from typing import Any

import rclpy
from er_common.topics import Topic
from er_ros_common.spin import guarded
from er_ros_common.stopping import Stopped
from rcl_interfaces.srv import GetParameters, SetParametersAtomically
from rclpy.client import Client
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.serialization import deserialize_message
from rclpy.signals import SignalHandlerOptions
from rclpy.subscription import Subscription

from er_common import quality, topics
from er_damper_msgs.msg import NodeStatus
from er_damper_msgs.srv import UseModel
from er_model_lab.live.join import COLUMNS, Join
from er_model_lab.programs import MONITOR
from er_ros_common import qos

PERIOD = 0.25
"""How often what has come is taken [s]."""
PATIENCE = 5.0
"""How long a monitor is looked for that is asked to go by a model [s]."""
SILENCE = 1.0
"""Time without a sample after which that is said [s]."""
NICE = 5
PLACE = {name: k for k, name in enumerate(COLUMNS)}
Values = tuple[float, ...]
Read = tuple[int, int, Values]
"""Of a message: stamp [ns], sequence number, and values."""
Word = dict[str, Any]


def _numbers(layout: str, pick: Callable[[tuple[Any, ...]], Values]) -> Callable[[bytes], Read]:
    """Reads messages with a header and a sequence number; layout: what follows, as `struct`.

    Fields lie as CDR has them, each at a multiple of its size, counted from behind the four bytes of its own head.
    """
    head, body = struct.Struct("<iII"), struct.Struct(f"<Q{layout}")

    def read(data: bytes) -> Read:
        seconds, nanoseconds, length = head.unpack_from(data, 4)
        number, *rest = body.unpack_from(data, 4 + -(-(12 + length) // 8) * 8)
        return seconds * 1_000_000_000 + nanoseconds, number, pick(tuple(rest))

    return read


NAN = float("nan")
FORCE = _numbers("d16xB?", lambda m: (m[0],) if m[2] else (NAN,))
READERS: dict[Topic, tuple[str, Callable[[bytes], Read]]] = {
    topics.ACCELERATION: (
        "sprung_acceleration", _numbers("2dB?", lambda m: m[:2] if m[3] else (NAN, NAN)),
    ),
    topics.DEFLECTION: (
        "deflection",
        _numbers("2d?B?", lambda m: (m[0], m[1] if m[2] else NAN) if m[4] else (NAN, NAN)),
    ),
    topics.PWM_APPLIED: ("duty", _numbers("dQB?B?", lambda m: m[:1] if m[-1] else (NAN,))),
    topics.FORCE: ("damper_force", FORCE),
    topics.MODEL_RESIDUAL: ("left", _numbers("3dB?", lambda m: m[:4] if m[4] else (NAN,))),
}  # fmt: skip
"""Topics that are heard: the first column of a row that a message fills, and what reads it."""


class Listener:
    """The ends in the graph, and what has come of it."""

    def __init__(self, node: Node, asking: Node, say: Callable[[Word], None]) -> None:
        """node: whose subscriptions nobody spins; asking: whose services an executor answers."""
        self.node, self.asking, self.say = node, asking, say
        self.setters: dict[str, Client] = {}
        self.join, self.again, self.last, self.alone = Join(), 0, monotonic(), False
        self.ends = [(self._hear(topic), *READERS[topic]) for topic in READERS]
        status = topics.STATUS.name.replace("~", MONITOR.name)
        self.status = node.create_subscription(
            NodeStatus, status, _nothing, qos.profile(topics.STATUS.subscriber), raw=True
        )
        self.use = asking.create_client(UseModel, f"{MONITOR.name}/use_model")
        self.get = asking.create_client(GetParameters, f"{MONITOR.name}/get_parameters")
        self.executor, self.asked = SingleThreadedExecutor(), False
        self.wishes: list[tuple[Word, float]] = []
        self.executor.add_node(asking)

    def _hear(self, topic: Topic) -> Subscription:
        return self.node.create_subscription(
            topic.type, topic.name, _nothing, qos.profile(quality.FOLLOWER), raw=True
        )

    def look(self) -> None:
        """Take what has come, and say it."""
        for end, column, read in self.ends:
            for data in _taken(end):
                stamp, number, values = read(data)
                self.join.add(stamp, PLACE[column], values, number)
        rows = self.join.ready()
        if self.join.again != self.again:
            self.again = self.join.again
            self.say({"again": self.again})
        if rows:
            self.say({"rows": rows})
            self.last = monotonic()
        if (alone := monotonic() - self.last > SILENCE) != self.alone:
            self.alone = alone
            self.say({"alone": alone})
        for data in _taken(self.status):
            self._status(deserialize_message(data, NodeStatus))
        wishes, self.wishes = self.wishes, []
        for wish, until in wishes:
            self._serve(wish, until)
        self.executor.spin_once(timeout_sec=0.0)

    def _status(self, m: NodeStatus) -> None:
        self.say({"status": {"mode": m.mode, "reason": m.reason, "model_id": m.model_id}})
        if not self.asked and self.get.service_is_ready():
            self.asked = True
            request = GetParameters.Request(names=["model_file"])
            self._ask(self.get, request, lambda a: {"model": a.values[0].string_value})

    def do(self, wish: Word) -> None:
        """Do what is asked."""
        self.wishes.append((wish, monotonic() + PATIENCE))

    def _serve(self, wish: Word, until: float) -> None:
        """Ask for what was wished; who has just been started may take a while to be found."""
        if "run" in wish:
            self._drive(wish, until)
            return
        path = str(wish["use"])
        if not self.use.service_is_ready():
            if monotonic() < until:
                self.wishes.append((wish, until))
                return
            reason = f"no {MONITOR.name} in the namespace: ./er up model_monitor:=true"
            self.say({"used": {"accepted": False, "reason": reason, "model": path}})
            return
        along = self.observers() if wish["observers"] else []
        self._ask(
            self.use, UseModel.Request(model=path, along=along),
            lambda a: {"used": {"accepted": a.accepted, "reason": a.reason, "model": path}},
        )  # fmt: skip

    def _drive(self, wish: Word, until: float) -> None:
        """Ask the node that applies the duty to drive a program in the middle of its drive."""
        path, found = str(wish["run"]), self.drivers()
        answer: Word = {
            "accepted": False,
            "run": path,
            "node": found[0] if len(found) == 1 else "",
        }
        if not answer["node"]:
            words = ", ".join(found) or "none"
            answer["reason"] = (
                f"expected one node that says {topics.PWM_APPLIED.name}, found {words}"
            )
            self.say({"ran": answer})
            return
        client = self._setter(found[0])
        if not client.service_is_ready():
            if monotonic() < until:
                self.wishes.append((wish, until))
                return
            self.say({"ran": {**answer, "reason": "does not answer"}})
            return
        request = SetParametersAtomically.Request(
            parameters=[Parameter("planned_file", value=path).to_parameter_msg()]
        )
        self._ask(
            client, request,
            lambda a: {"ran": {**answer, "accepted": a.result.successful, "reason": a.result.reason}},
        )  # fmt: skip

    def _setter(self, node: str) -> Client:
        if node not in self.setters:
            service = f"{node}/set_parameters_atomically"
            self.setters[node] = self.asking.create_client(SetParametersAtomically, service)
        return self.setters[node]

    def drivers(self) -> list[str]:
        """Full names of the nodes that say which duty acts: a plant, or what stands in its place."""
        ends = self.node.get_publishers_info_by_topic(topics.PWM_APPLIED.name)
        return sorted({f"{e.node_namespace.rstrip('/')}/{e.node_name}" for e in ends})

    def observers(self) -> list[str]:
        """The nodes of the namespace that say an estimated force."""
        begin = self.node.resolve_topic_name(topics.estimated_force("x").name).removesuffix("x")
        said = (
            name for name, _ in self.node.get_topic_names_and_types() if name.startswith(begin)
        )
        ends = (end for name in said for end in self.node.get_publishers_info_by_topic(name))
        return sorted({end.node_name for end in ends})

    def _ask(self, client: Any, request: Any, word: Callable[[Any], Word]) -> None:
        client.call_async(request).add_done_callback(lambda done: self.say(word(done.result())))


def _nothing(_: bytes) -> None:
    """No callback: messages are taken."""


def _taken(end: Subscription) -> Iterator[bytes]:
    """All that has come."""
    with end.handle:
        while (found := end.handle.take_message(end.msg_type, True)) is not None:
            yield found[0]


def _listen(namespace: str, stopped: Stopped) -> None:
    wishes: list[Word] = []
    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    node, asking = (
        Node(name, namespace=namespace, enable_rosout=False, start_parameter_services=False)
        for name in ("lab_page", "lab_page_asks")
    )
    over: list[bool] = []

    def read() -> None:
        for line in sys.stdin:
            wishes.append(json.loads(line))
        over.append(True)

    Thread(target=read, daemon=True).start()
    listener = Listener(node, asking, _say)
    try:
        while not (over or stopped.signal):
            began = monotonic()
            while wishes:
                listener.do(wishes.pop(0))
            listener.look()
            sleep(max(began + PERIOD - monotonic(), 0.01))
    except BrokenPipeError:  # nobody is left to be told
        os._exit(0)
    finally:
        listener.executor.shutdown(timeout_sec=0.0)
        node.destroy_node()
        asking.destroy_node()


def _say(word: Word) -> None:
    sys.stdout.write(f"{json.dumps(word)}\n")
    sys.stdout.flush()


def main() -> None:
    """Listen until standard input ends."""
    os.nice(NICE)
    sys.exit(guarded("er lab open", [], lambda stopped: _listen(sys.argv[1], stopped)))


if __name__ == "__main__":
    main()
