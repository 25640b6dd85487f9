"""What ROS 2 says nothing about: other types, incompatible ends, two publishers of a topic.

With Fast DDS a topic of two types, or a subscription that asks for more than the publisher offers,
is silent: no data and no error. The check is pure; `endpoints` turns what the graph reports into
its input.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

from er_common.topics import Topic
from rclpy.duration import Duration
from rclpy.node import Node
from rclpy.publisher import Publisher
from rclpy.qos import (
    DurabilityPolicy,
    HistoryPolicy,
    LivelinessPolicy,
    QoSProfile,
    ReliabilityPolicy,
)
from rclpy.subscription import Subscription
from rclpy.topic_endpoint_info import TopicEndpointInfo

UNNAMED = "a node not named yet"
"""Who an end belongs to until its name comes, a little later than the end itself."""
NOT_KNOWN = ("_NODE_NAMESPACE_UNKNOWN_", "_NODE_NAME_UNKNOWN_")
"""What ROS 2 says until then of namespace and node."""

LONGEST = 2**62
"""Limits of time from here on are none [ns]; the middleware's own for that is a second or so short of 2^63."""


@dataclass(frozen=True, slots=True)
class Endpoint:
    """One publisher or subscription as the graph shows it.

    deadline: longest time between two messages, lease: between two signs of life, offered or asked for [s]; manual:
    whether each topic gives such signs by itself.
    """

    node: str
    type_name: str
    reliable: bool
    latched: bool
    deadline: float = math.inf
    lease: float = math.inf
    manual: bool = False


@dataclass(frozen=True, slots=True)
class Problem:
    """One thing wrong with a topic, and what to do about it."""

    topic: str
    kind: str
    text: str
    cure: str


def check_topic(
    topic: Topic,
    name: str,
    publishers: Sequence[Endpoint],
    subscribers: Sequence[Endpoint],
    *,
    single: bool = True,
) -> list[Problem]:
    """Problems of one topic with the given full name; single: more than one publisher is wrong."""
    found = [_other_type(topic, name, end) for end in (*publishers, *subscribers)]
    found += [
        _too_demanding(name, sender, taker)
        for sender in publishers
        for taker in subscribers
        if not _heard_otherwise(name, sender, taker, subscribers)
    ]
    if single and len(publishers) > 1:
        who = ", ".join(sorted(end.node for end in publishers))
        found.append(
            Problem(
                name,
                "two publishers",
                f"{len(publishers)} nodes publish it: {who}",
                "stop all but one",
            )
        )
    return [problem for problem in found if problem is not None]


Ends: TypeAlias = tuple[list[Endpoint], list[Endpoint]]
"""Publishers and subscriptions of a topic."""


def endpoints(node: Node, name: str) -> Ends:
    """Publishers and subscriptions of a topic that this node knows of."""
    publishers = [_endpoint(info) for info in node.get_publishers_info_by_topic(name)]
    subscribers = [_endpoint(info) for info in node.get_subscriptions_info_by_topic(name)]
    return publishers, subscribers


def compatible(publishers: Sequence[TopicEndpointInfo], depth: int) -> QoSProfile:
    """What a listener asks for to hear every publisher, as reliably as all of them offer."""
    each = [info.qos_profile for info in publishers]
    reliable = all(p.reliability == ReliabilityPolicy.RELIABLE for p in each)
    latched = bool(each) and all(p.durability == DurabilityPolicy.TRANSIENT_LOCAL for p in each)
    return QoSProfile(
        history=HistoryPolicy.KEEP_LAST,
        depth=depth,
        reliability=ReliabilityPolicy.RELIABLE if reliable else ReliabilityPolicy.BEST_EFFORT,
        durability=DurabilityPolicy.TRANSIENT_LOCAL if latched else DurabilityPolicy.VOLATILE,
    )


def offered(asked: QoSProfile, publishers: Sequence[TopicEndpointInfo]) -> bool:
    """Whether every publisher offers the reliability and durability that a listener asks for."""
    each = [info.qos_profile for info in publishers]
    reliable = all(p.reliability == ReliabilityPolicy.RELIABLE for p in each)
    latched = all(p.durability == DurabilityPolicy.TRANSIENT_LOCAL for p in each)
    return (reliable or asked.reliability == ReliabilityPolicy.BEST_EFFORT) and (
        latched or asked.durability == DurabilityPolicy.VOLATILE
    )


def connected(
    inputs: Sequence[Subscription], outputs: Sequence[tuple[Publisher, int]] = ()
) -> bool:
    """Whether every input has a publisher and every output as many subscribers as it should."""
    heard = all(end.get_publisher_count() > 0 for end in inputs)
    return heard and all(end.get_subscription_count() >= count for end, count in outputs)


def watch(
    node: Node, topics: Sequence[Topic], look: Callable[[Node, str], Ends] = endpoints
) -> list[Problem]:
    """Problems of the topics a node takes part in, by relative name: for its diagnostics."""
    found: list[Problem] = []
    for topic in topics:
        name = node.resolve_topic_name(topic.name)
        found += check_topic(topic, name, *look(node, name))
    return found


def _endpoint(info: TopicEndpointInfo) -> Endpoint:
    profile = info.qos_profile
    named = (info.node_namespace, info.node_name) != NOT_KNOWN
    return Endpoint(
        node=f"{info.node_namespace.rstrip('/')}/{info.node_name}" if named else UNNAMED,
        type_name=info.topic_type,
        reliable=profile.reliability == ReliabilityPolicy.RELIABLE,
        latched=profile.durability == DurabilityPolicy.TRANSIENT_LOCAL,
        deadline=_seconds(profile.deadline),
        lease=_seconds(profile.liveliness_lease_duration),
        manual=profile.liveliness == LivelinessPolicy.MANUAL_BY_TOPIC,
    )


def _seconds(limit: Duration) -> float:
    """A limit [s]; none is the longest time there is, or where it was left open, 0."""
    whole = int(limit.nanoseconds)
    return 1e-9 * whole if 0 < whole < LONGEST else math.inf


def _other_type(topic: Topic, name: str, end: Endpoint) -> Problem | None:
    if end.type_name == topic.type_name:
        return None
    text = f"{end.node} uses {end.type_name}, expected {topic.type_name}"
    return Problem(
        name,
        "other type",
        text,
        f"remap the topic of {end.node}, or build it against the same messages",
    )


def _heard_otherwise(
    name: str, sender: Endpoint, taker: Endpoint, subscribers: Sequence[Endpoint]
) -> bool:
    """Whether the taker's node has another subscription that asks for no more than the sender offers.

    Who sets limits of time wants to be told of their breach, which that other one does not do.
    """
    if not taker.deadline == taker.lease == math.inf:
        return False
    own = [end for end in subscribers if end.node == taker.node != UNNAMED and end is not taker]
    return any(_too_demanding(name, sender, end) is None for end in own)


def _too_demanding(name: str, sender: Endpoint, taker: Endpoint) -> Problem | None:
    late = taker.deadline < sender.deadline
    lifeless = (taker.manual and not sender.manual) or taker.lease < sender.lease
    kind = "liveliness by topic" if taker.manual else "liveliness"
    for lacking, word in (
        (taker.reliable and not sender.reliable, "reliable"),
        (taker.latched and not sender.latched, "transient local"),
        (late, f"a deadline of {taker.deadline:g} s"),
        (lifeless, f"{kind} with a lease of {taker.lease:g} s"),
    ):
        if lacking:
            text = f"{taker.node} asks for {word}, {sender.node} does not offer it: no data flows"
            return Problem(
                name, "incompatible QoS", text, f"offer {word} in {sender.node}, or ask for less"
            )
    return None
