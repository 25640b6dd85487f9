"""What `er doctor` makes of what it saw: problems, each with a cure. Messages and topics, no node and no clock."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from er_common.topics import Topic
from er_ros_common.graph_check import Endpoint, Ends, Problem, check_topic

from er_bringup.programs import ESTIMATES
from er_common import topics
from er_damper_msgs.msg import NodeStatus

NEEDED = topics.SENSORS
"""Topics without which a graph measures nothing."""
CONTRACT = (*topics.MEASUREMENTS, *ESTIMATES)
"""Topics that are looked at."""
OF_RIGS = (topics.FORCE, topics.ROAD)
"""Of those, what only a rig or a simulation knows: a car's own sensors need not have them."""
TOLERANCE = 0.1
"""Share by which a rate may differ from what it should be."""
STALE = 0.02
"""Age on arrival beyond which a node drops a sample [s]."""
OLD_SHARE = 0.01
"""Share of old samples that is worth a line."""


@dataclass(frozen=True)
class Heard:
    """One topic of the contract: its ends, and what was heard on it.

    span: from the first to the last arrival [s]; ages: on arrival [s]; zero: stamps that are not
    set; invalid: messages that their sender calls not valid; non_finite: others with NaN or infinite numbers;
    jumps: of the stamps, by more than half a second [s].
    """

    topic: Topic
    name: str
    publishers: tuple[Endpoint, ...]
    subscribers: tuple[Endpoint, ...]
    count: int = 0
    span: float = 0.0
    ages: tuple[float, ...] = ()
    lost: int = 0
    zero: int = 0
    invalid: int = 0
    non_finite: int = 0
    jumps: tuple[float, ...] = ()

    @property
    def rate(self) -> float:
        """Messages per second; 0 with fewer than two."""
        return (self.count - 1) / self.span if self.count > 1 and self.span > 0.0 else 0.0


@dataclass(frozen=True)
class SeenNode:
    """One node: its parameters (None: it did not answer) and the last status it sent."""

    name: str
    parameters: Mapping[str, Any] | None = None
    status: int | None = None
    mode: str = ""
    reason: str = ""


@dataclass(frozen=True)
class Observation:
    """All that was seen of one namespace in this time [s].

    clocks: publishers of each topic of simulated time; said: what the nodes say in /diagnostics: name of the
    entry, level, text.
    """

    namespace: str
    seconds: float
    heard: tuple[Heard, ...] = ()
    nodes: tuple[SeenNode, ...] = ()
    clocks: Mapping[str, int] = field(default_factory=dict)
    said: tuple[tuple[str, int, str], ...] = ()


def namespaces(names: Sequence[str]) -> list[str]:
    """Namespaces ('' is the root) in which a topic of the contract is, of full topic names."""
    ends = [f"/{topic.name}" for topic in CONTRACT]
    return sorted({name.removesuffix(end) for name in names for end in ends if name.endswith(end)})


def clocks(ends: Mapping[str, Ends], namespace: str) -> dict[str, int]:
    """How many publish each topic of simulated time that nodes of a namespace ('' is the root) publish or listen to."""
    own = f"{namespace}/"
    return {
        name: len(publishers)
        for name, (publishers, subscribers) in ends.items()
        if any(end.node.startswith(own) for end in (*publishers, *subscribers))
    }


def plant_of(seen: Observation) -> Mapping[str, Any]:
    """Parameters of the plant, or of the bridge to a rig; empty where there is none or it does not answer."""
    return next((p for n in seen.nodes if "rate" in (p := n.parameters or {})), {})


def real_time(plant: Mapping[str, Any]) -> bool:
    """Whether stamps are of the system clock, so that messages have an age."""
    return str(plant.get("mode", "realtime")) == "realtime"


def problems(seen: Observation) -> list[Problem]:
    """Everything that is wrong, most important first."""
    found = [*_nothing(seen), *_missing(seen), *_ends(seen)]
    plant = plant_of(seen)
    for heard in seen.heard:
        found += _flow(heard, plant)
    return [*found, *_nodes(seen), *_time(seen), *_said(seen)]


def _nothing(seen: Observation) -> Iterator[Problem]:
    if not seen.nodes and not any(h.publishers for h in seen.heard):
        text = "no node and no topic of this project is there"
        cure = "start one (./er up); the same ROS_DOMAIN_ID and ROS_AUTOMATIC_DISCOVERY_RANGE?"
        yield Problem(seen.namespace or "/", "empty graph", text, cure)


def _missing(seen: Observation) -> Iterator[Problem]:
    if not seen.nodes and not any(h.publishers for h in seen.heard):
        return
    there = {h.topic.name: h for h in seen.heard if h.publishers}
    ours, acceleration = {n.name for n in seen.nodes}, there.get(topics.ACCELERATION.name)
    of_a_car = acceleration and not any(end.node in ours for end in acceleration.publishers)
    for topic in NEEDED:
        if topic.name not in there and not (of_a_car and topic in OF_RIGS):
            name = f"{seen.namespace}/{topic.name}"
            cure = "start the plant or the bridge to the rig, or remap its topic"
            yield Problem(name, "missing topic", "nobody publishes it", cure)
    asked = any((n.parameters or {}).get("duty_source") == "topic" for n in seen.nodes)
    if asked and topics.PWM_COMMAND.name not in there:
        name = f"{seen.namespace}/{topics.PWM_COMMAND.name}"
        text = "the plant takes its duty from it and nobody publishes it: safe duty"
        yield Problem(name, "missing topic", text, "start a controller, or use duty:=program")


def _ends(seen: Observation) -> Iterator[Problem]:
    for heard in seen.heard:
        yield from check_topic(heard.topic, heard.name, heard.publishers, heard.subscribers)


def _flow(heard: Heard, plant: Mapping[str, Any]) -> Iterator[Problem]:
    """Problems of the messages of one topic; nothing where nobody publishes."""
    if not heard.publishers:
        return
    sender = heard.publishers[0].node
    if heard.count == 0:
        text = f"{sender} offers it, but nothing came"
        yield Problem(
            heard.name, "silent", text, f"is {sender} running, or waiting? see its status"
        )
        return
    yield from _rate(heard, plant)
    real = real_time(plant)
    old = sum(age > STALE for age in heard.ages)
    if real and old > OLD_SHARE * heard.count:
        worst = 1e3 * max(heard.ages)
        limit = f"older than {1e3 * STALE:.0f} ms, at most {worst:.0f} ms"
        text = f"{old} of {heard.count} stamps {limit}"
        cure = "the machine is too slow or its load too high; or the sender's clock is off"
        yield Problem(heard.name, "stale stamps", text, cure)
    if real and any(age < -0.005 for age in heard.ages):
        text = f"stamps up to {-1e3 * min(heard.ages):.0f} ms ahead of this machine's clock"
        yield Problem(heard.name, "future stamps", text, "synchronise the clocks (chrony, ptp)")
    if heard.jumps:
        text = f"the stamps jumped {len(heard.jumps)} times, by {heard.jumps[0]:.3g} s first"
        cure = "a bag that loops, or a clock that was set? nodes start afresh at each jump"
        yield Problem(heard.name, "time jump", text, cure)
    if heard.zero:
        text = f"{heard.zero} of {heard.count} messages without a stamp"
        yield Problem(heard.name, "zero stamps", text, f"set header.stamp in {sender}")
    yield from _values(heard)
    if heard.lost:
        text = f"{heard.lost} messages missing in seq, {heard.count} came"
        yield Problem(
            heard.name, "lost messages", text, "load too high? see the rates and the CPU"
        )


def _values(heard: Heard) -> Iterator[Problem]:
    """Problems of the values of one topic; estimates say by themselves when they are not valid."""
    sender = heard.publishers[0].node
    if heard.non_finite:
        text = f"{heard.non_finite} of {heard.count} messages with NaN or infinite numbers"
        yield Problem(heard.name, "not a number", text, f"what does {sender} compute?")
    if heard.invalid and heard.topic in topics.MEASUREMENTS:
        text = f"{heard.invalid} of {heard.count} messages are called not valid by {sender}"
        yield Problem(heard.name, "not valid", text, f"is the sensor well? see {sender}")


def _rate(heard: Heard, plant: Mapping[str, Any]) -> Iterator[Problem]:
    factor = float(plant.get("rate_factor", 1.0))
    if factor == 0.0:
        return
    nominal = float(plant.get("rate", heard.topic.rate))
    expected = (
        nominal * factor if heard.topic.rate == topics.ACCELERATION.rate else heard.topic.rate
    )
    slower_allowed = heard.topic is topics.FAULT
    too_fast = heard.rate > (1.0 + TOLERANCE) * expected
    too_slow = heard.rate < (1.0 - TOLERANCE) * expected and not slower_allowed
    if too_fast or too_slow:
        text = f"{heard.rate:.1f} Hz instead of {expected:g} Hz"
        cure = "CPU too slow?" if too_slow else "is a second publisher or a bag playing?"
        yield Problem(heard.name, "rate", text, cure)


def _nodes(seen: Observation) -> Iterator[Problem]:
    for node in seen.nodes:
        if node.parameters is None:
            text = "does not answer when asked for its parameters"
            yield Problem(node.name, "no answer", text, "is it stopped or overloaded? restart it")
        bad = node.status not in (None, NodeStatus.STATUS_OK, NodeStatus.STATUS_INITIALIZING)
        if bad:
            cure = "the reason says what it needs"
            yield Problem(node.name, "status", f"{node.mode}: {node.reason}", cure)


def _said(seen: Observation) -> Iterator[Problem]:
    """What nodes say of their inputs and their computing times."""
    for name, level, text in seen.said:
        if level:
            node, _, task = name.rpartition(": ")
            yield Problem(f"/{node.lstrip('/')}", task, text, "see the topic it names")


def _time(seen: Observation) -> Iterator[Problem]:
    simulated = [n.name for n in seen.nodes if (n.parameters or {}).get("use_sim_time")]
    plants = [n for n in seen.nodes if (n.parameters or {}).get("mode") == "sim_time"]
    for name, count in (seen.clocks or {topics.CLOCK.name: 0}).items():
        if simulated and not count:
            text = f"{', '.join(simulated)} wait for {name} and nobody publishes it"
            cure = "plant with mode:=sim_time, or use_sim_time false"
            yield Problem(name, "no clock", text, cure)
        if count > 1:
            text = f"{count} nodes publish it"
            yield Problem(name, "two publishers", text, "stop all but one")
    asked = [(n.name, n.parameters) for n in seen.nodes if n.parameters]
    system = [name for name, p in asked if p.get("max_age") and not p.get("use_sim_time")]
    if plants and system:
        text = f"{', '.join(system)} compare simulated stamps with the system clock"
        yield Problem(
            system[0], "mixed time", text, "use_sim_time:=true and max_age:=0.0 for them"
        )
