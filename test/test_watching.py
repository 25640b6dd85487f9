"""What ROS 2 is silent about, as a node says it in /diagnostics: within two seconds, with topic, node and cure."""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator
from functools import partial
from itertools import count
from time import monotonic
from typing import Any

import pytest

pytest.importorskip("rclpy")

import rclpy
from diagnostic_msgs.msg import DiagnosticArray
from er_ftc_controller.programs import SKYHOOK
from er_ros_common.core_node import CoreNode
from er_ros_common.graph_check import endpoints
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from std_msgs.msg import Float64

from er_common import topics
from er_damper_msgs.msg import NodeStatus
from er_ros_common import builders, qos
from test.graph_help import own_domain, skyhook_arguments

WITHIN = 2.0
Entries = dict[str, tuple[int, str]]


@pytest.fixture
def graph() -> Iterator[tuple[Callable[..., str], Node]]:
    """A controller, and somebody from elsewhere who spoils its graph; asks for an entry of /diagnostics."""
    with own_domain() as env:
        domain = int(env["ROS_DOMAIN_ID"])
        rclpy.init(args=[], domain_id=domain)
        # within one context rclpy refuses a second type, with words that mislead
        away = rclpy.Context()
        rclpy.init(args=[], context=away, domain_id=domain)
        node, other = CoreNode(SKYHOOK, skyhook_arguments()), Node("intruder", context=away)
        node.start()
        listener = rclpy.create_node("listener")
        said: Entries = {}

        def heard(message: DiagnosticArray) -> None:
            said.update({s.name: (s.level[0], s.message) for s in message.status})

        def counted(message: NodeStatus) -> None:
            said["non_finite"] = (0, "counted" if message.non_finite else "none")

        listener.create_subscription(DiagnosticArray, "/diagnostics", heard, 10)
        listener.create_subscription(NodeStatus, "/skyhook_controller/status", counted, 10)
        executor = SingleThreadedExecutor()
        for each in (node, listener):
            executor.add_node(each)

        def named(topic: str) -> bool:
            """Whether the graph knows the intruder's end by name, which comes after the end itself."""
            return any(
                end.node == "/intruder" for ends in endpoints(listener, topic) for end in ends
            )

        def says(entry: str, words: str, seen: str | Callable[[], Any] | None = None) -> str:
            """Text of the entry once it has the words; at most `WITHIN` after it could be seen.

            seen: tells whether it could, and is asked again and again, so that one message that it sends
            and the wire loses is not the end of it; or the topic the intruder spoils.
            """
            since, begun = None if seen else monotonic(), monotonic()
            seen = partial(named, seen) if isinstance(seen, str) else seen
            while words not in said.get(entry, (0, ""))[1]:
                executor.spin_once(timeout_sec=0.02)
                if seen is not None and seen() and since is None:
                    since = monotonic()
                assert monotonic() - (since or begun) < (WITHIN if since else 10.0), said
            return said[entry][1]

        yield says, other
        node.on_stop()
        for each in (node, listener, other):
            each.destroy_node()
        rclpy.try_shutdown()
        away.try_shutdown()


def test_another_type_on_a_topic_is_named(graph: tuple[Callable[..., str], Node]) -> None:
    says, other = graph
    name = topics.DEFLECTION.name
    other.create_publisher(Float64, name, 10)
    words = f"{name}: /intruder uses std_msgs/msg/Float64"
    text = says("skyhook_controller: graph", words, name)
    assert "remap the topic" in text


def test_a_qos_that_carries_nothing_is_named(graph: tuple[Callable[..., str], Node]) -> None:
    says, other = graph
    there = topics.PWM_COMMAND
    other.create_subscription(there.type, there.name, print, qos.profile(topics.STATUS.subscriber))
    words = f"{there.name}: /intruder asks for transient local"
    text = says("skyhook_controller: graph", words, there.name)
    assert "offer transient local in /skyhook_controller" in text


def test_a_second_controller_is_named(graph: tuple[Callable[..., str], Node]) -> None:
    says, other = graph
    there = topics.PWM_COMMAND
    other.create_publisher(there.type, there.name, qos.profile(there.publisher))
    words = "2 nodes publish it: /intruder, /skyhook_controller: stop all but one"
    assert there.name in says("skyhook_controller: graph", words, there.name)


def test_a_missing_input_and_a_stamp_that_is_not_set_are_named(
    graph: tuple[Callable[..., str], Node],
) -> None:
    says, other = graph
    text = says("skyhook_controller: input rate", "nothing came for 1.")
    assert "/sensors/acceleration: nothing came" in text
    assert "start its publisher" in text
    there = topics.ACCELERATION
    end = other.create_publisher(there.type, there.name, qos.profile(there.publisher))
    message = builders.suspension_acceleration(builders.Tick(0, 1), 0.0, 0.0)

    def send() -> bool:
        end.publish(message)
        return end.get_subscription_count() > 0

    text = says("skyhook_controller: stamps", "without a stamp", send)
    assert text.startswith("/sensors/acceleration: ")
    assert "set header.stamp" in text


def test_a_sensor_that_says_no_number_or_is_not_valid_is_named(
    graph: tuple[Callable[..., str], Node],
) -> None:
    says, other = graph
    there = topics.ACCELERATION
    end = other.create_publisher(there.type, there.name, qos.profile(there.publisher))

    seqs = count(1)

    def send() -> bool:
        """One of the two in turn: the queue of a sensor holds the newest message only."""
        now, k = other.get_clock().now().nanoseconds, next(seqs)
        message = builders.suspension_acceleration(builders.Tick(now, k), 0.0, 0.0)
        message.unsprung, message.valid = math.nan, bool(k % 2)
        end.publish(message)
        return end.get_subscription_count() > 0

    text = says("skyhook_controller: values", "with NaN or infinite numbers", send)
    assert re.search(r"/sensors/acceleration: \d+ messages with NaN or infinite numbers", text)
    text = says("skyhook_controller: values", "calls not valid", send)
    assert re.search(
        r"/sensors/acceleration: \d+ messages that their sender calls not valid", text
    )
    assert says("non_finite", "counted")


def test_a_deflection_without_the_velocity_that_the_law_needs_is_named(
    graph: tuple[Callable[..., str], Node],
) -> None:
    says, other = graph
    there = topics.DEFLECTION
    end = other.create_publisher(there.type, there.name, qos.profile(there.publisher))

    def send() -> bool:
        now = other.get_clock().now().nanoseconds
        end.publish(builders.suspension_deflection(builders.Tick(now, 1), 0.01))
        return end.get_subscription_count() > 0

    text = says("skyhook_controller: values", "messages without velocity", send)
    assert re.match(r"/sensors/deflection: \d+ ", text)
