"""What ROS 2 is silent about: other types, incompatible ends, two publishers."""

from __future__ import annotations

import math
from dataclasses import replace
from typing import Any

import pytest

pytest.importorskip("rclpy")

from er_ros_common.graph_check import UNNAMED, Endpoint, check_topic, endpoints, watch
from rclpy.duration import Duration, Infinite
from rclpy.qos import LivelinessPolicy, QoSProfile
from rclpy.topic_endpoint_info import TopicEndpointInfo

from er_common import topics
from er_ros_common import qos

NAME = "/sensors/force"
TYPE = topics.FORCE.type_name


def end(
    *, reliable: bool = True, latched: bool = False, kind: str = TYPE, **limits: float
) -> Endpoint:
    """One end of the topic."""
    manual = bool(limits.pop("manual", False))
    return Endpoint("/somebody", kind, reliable, latched, manual=manual, **limits)


@pytest.mark.parametrize(
    ("sender", "taker", "fits"),
    [
        (end(), end(), True),
        (end(), end(reliable=False), True),
        (end(reliable=False), end(reliable=False), True),
        (end(reliable=False), end(), False),
        (end(latched=True), end(), True),
        (end(), end(latched=True), False),
        (end(), end(deadline=0.05), False),
        (end(deadline=0.1), end(deadline=0.05), False),
        (end(deadline=0.05), end(deadline=0.05), True),
        (end(deadline=0.05), end(), True),
        (end(), end(lease=0.1), False),
        (end(lease=0.1), end(lease=0.2), True),
        (end(lease=0.1), end(lease=0.2, manual=True), False),
        (end(lease=0.1, manual=True), end(lease=0.2), True),
    ],
)
def test_a_listener_must_not_ask_for_more_than_is_offered(
    sender: Endpoint, taker: Endpoint, *, fits: bool
) -> None:
    found = check_topic(topics.FORCE, NAME, [sender], [taker])
    assert [p.kind for p in found] == ([] if fits else ["incompatible QoS"])


def test_a_node_that_hears_a_sender_otherwise_asks_for_nothing_too_much() -> None:
    sender, shy, strict = end(reliable=False), end(reliable=False), end()
    assert check_topic(topics.FORCE, NAME, [sender], [strict, shy]) == []
    other = replace(shy, node="/other")
    assert len(check_topic(topics.FORCE, NAME, [sender], [strict, other])) == 1
    nameless = [replace(each, node=UNNAMED) for each in (strict, shy)]
    assert len(check_topic(topics.FORCE, NAME, [sender], nameless)) == 1


def test_other_types_are_found_on_both_ends() -> None:
    other = end(kind="std_msgs/msg/Float64")
    found = check_topic(topics.FORCE, NAME, [other], [other])
    assert [p.kind for p in found] == ["other type"] * 2
    assert "std_msgs/msg/Float64" in found[0].text


@pytest.mark.parametrize(("single", "count"), [(True, 1), (False, 0)])
def test_two_publishers_count_where_there_must_be_one(*, single: bool, count: int) -> None:
    assert len(check_topic(topics.FORCE, NAME, [end(), end()], [], single=single)) == count


def test_an_end_whose_node_is_not_known_yet_is_told_in_words() -> None:
    """An end may be found before its node's name; also that of another DDS program, which has none."""

    class Found:
        def get_publishers_info_by_topic(self, _: str) -> list[TopicEndpointInfo]:
            names = {
                "node_name": "_NODE_NAME_UNKNOWN_",
                "node_namespace": "_NODE_NAMESPACE_UNKNOWN_",
            }
            profile = qos.profile(topics.FORCE.publisher)
            return [
                TopicEndpointInfo(**names, topic_type="std_msgs/msg/Float64", qos_profile=profile)
            ]

        def get_subscriptions_info_by_topic(self, _: str) -> list[TopicEndpointInfo]:
            return []

    senders, takers = endpoints(Found(), NAME)
    assert ([end.node for end in senders], takers) == ([UNNAMED], [])
    (problem,) = check_topic(topics.FORCE, NAME, senders, takers)
    assert problem.text == f"{UNNAMED} uses std_msgs/msg/Float64, expected {TYPE}"


def test_a_running_graph_is_read(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setenv("ROS_DOMAIN_ID", "9")
    import rclpy
    from rclpy.context import Context
    from rclpy.node import Node
    from std_msgs.msg import Float64

    context = Context()
    rclpy.init(args=[], context=context)
    try:
        node = Node("probe", context=context, namespace="fl", enable_rosout=False)
        publisher = qos.profile(topics.FORCE.publisher)
        node.create_publisher(topics.FORCE.type, topics.FORCE.name, publisher)
        node.create_subscription(Float64, topics.ROAD.name, print, 10)
        senders, takers = endpoints(node, "/fl/sensors/force")
        assert senders == [Endpoint("/fl/probe", TYPE, reliable=True, latched=False)]
        assert takers == []
        found = watch(node, [topics.FORCE, topics.ROAD])
        assert [(p.topic, p.kind) for p in found] == [("/fl/sensors/road", "other type")]
        node.destroy_node()
    finally:
        rclpy.shutdown(context=context)


def test_limits_of_time_are_read_from_the_graph() -> None:
    """What is not limited is the longest time there is, or, where nothing was said of it, 0."""

    class Found:
        def get_publishers_info_by_topic(self, _: str) -> list[TopicEndpointInfo]:
            return [_info(QoSProfile(depth=1))]

        def get_subscriptions_info_by_topic(self, _: str) -> list[TopicEndpointInfo]:
            asked = QoSProfile(
                depth=1,
                deadline=Duration(seconds=0.05),
                liveliness=LivelinessPolicy.MANUAL_BY_TOPIC,
                liveliness_lease_duration=Duration(seconds=0.1),
            )
            none = QoSProfile(depth=1, deadline=Infinite, liveliness_lease_duration=Infinite)
            return [_info(asked), _info(none)]

    found: Any = Found()
    (sender,), (asked, none) = endpoints(found, NAME)
    assert (asked.deadline, asked.lease, asked.manual) == (0.05, 0.1, True)
    assert (sender.deadline, none.deadline, none.lease) == (math.inf,) * 3
    problem, *more = check_topic(topics.FORCE, NAME, [sender], [asked, none])
    assert not more
    assert "/taker" in problem.text
    assert "deadline of 0.05 s" in problem.text


def _info(profile: QoSProfile) -> TopicEndpointInfo:
    return TopicEndpointInfo(
        node_name="taker", node_namespace="/", topic_type=TYPE, qos_profile=profile
    )
