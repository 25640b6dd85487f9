"""What the doctor makes of a graph: each fault named with a cure, and none in a healthy one."""

from __future__ import annotations

import io
from dataclasses import replace
from typing import Any

import pytest

pytest.importorskip("rclpy")

from er_bringup.doctor import document, rows, show
from er_bringup.ros_checks import (
    NEEDED,
    Heard,
    Observation,
    SeenNode,
    clocks,
    namespaces,
    problems,
)
from er_common.topics import Topic
from er_ros_common.graph_check import UNNAMED, Endpoint
from rich.console import Console

from er_bringup import ros_listen
from er_common import topics
from er_damper_msgs.msg import NodeStatus

PLANT = {
    "mode": "realtime",
    "rate": 200.0,
    "rate_factor": 1.0,
    "duty_source": "topic",
    "use_sim_time": False,
}


def end(node: str, topic: Topic, *, reliable: bool = True, latched: bool = False) -> Endpoint:
    """A publisher or subscription of the right type."""
    return Endpoint(node, topic.type_name, reliable, latched)


def heard(topic: Topic, **other: Any) -> Heard:
    """A topic as it should be for three seconds."""
    good = Heard(
        topic=topic,
        name=f"/{topic.name}",
        publishers=(end("/plant", topic),),
        subscribers=(end("/recorder", topic),),
        count=601,
        span=3.0,
        ages=(0.001,) * 601,
    )
    return replace(good, **other)


def healthy(**other: Any) -> Observation:
    """A graph without a fault."""
    nodes = (
        SeenNode("/plant", PLANT, NodeStatus.STATUS_OK, "running"),
        SeenNode("/skyhook_controller", {"use_sim_time": False, "max_age": 0.05}, 0, "running"),
    )
    each = tuple(heard(topic) for topic in (*NEEDED, topics.PWM_COMMAND))
    return replace(Observation("", 3.0, each, nodes), **other)


def with_topic(changed: Heard) -> Observation:
    """The healthy graph with one topic changed."""
    return healthy(heard=tuple(changed if h.name == changed.name else h for h in healthy().heard))


def kinds(seen: Observation) -> list[tuple[str, str]]:
    """Where and what."""
    found = problems(seen)
    assert all(p.text and p.cure for p in found)
    return [(p.topic, p.kind) for p in found]


def test_a_healthy_graph_has_no_problem() -> None:
    assert kinds(healthy()) == []


def test_an_empty_graph_is_one_problem() -> None:
    assert kinds(Observation("/fl", 3.0)) == [("/fl", "empty graph")]


FORCE = topics.FORCE
TWO = (end("/plant", FORCE), end("/rig", FORCE))


@pytest.mark.parametrize(
    ("other", "kind"),
    [
        ({"publishers": TWO}, "two publishers"),
        ({"publishers": (Endpoint("/plant", "std_msgs/msg/Float64", True, False),)}, "other type"),
        ({"subscribers": (Endpoint("/x", "std_msgs/msg/Float64", False, False),)}, "other type"),
        ({"publishers": (end("/plant", FORCE, reliable=False),)}, "incompatible QoS"),
        ({"subscribers": (end("/x", FORCE, latched=True),)}, "incompatible QoS"),
        ({"count": 0, "span": 0.0, "ages": ()}, "silent"),
        ({"count": 300}, "rate"),
        ({"count": 1200}, "rate"),
        ({"ages": (0.001,) * 500 + (0.05,) * 101}, "stale stamps"),
        ({"ages": (-0.2,) * 601}, "future stamps"),
        ({"zero": 3}, "zero stamps"),
        ({"lost": 3}, "lost messages"),
        ({"jumps": (-60.0,)}, "time jump"),
        ({"non_finite": 3}, "not a number"),
        ({"invalid": 3}, "not valid"),
    ],
)
def test_a_sick_topic_is_named(other: dict[str, Any], kind: str) -> None:
    assert kinds(with_topic(heard(FORCE, **other))) == [("/sensors/force", kind)]


def test_a_few_old_stamps_are_no_news() -> None:
    assert kinds(with_topic(heard(FORCE, ages=(0.001,) * 598 + (0.05,) * 3))) == []


def test_what_nodes_say_of_their_inputs_is_said_here_too() -> None:
    said = (
        ("/plant: stamps", 1, "/pwm/command: 3 messages too old"),
        ("/plant: timing", 0, "in time"),
    )
    assert kinds(healthy(said=said)) == [("/plant", "stamps")]


@pytest.mark.parametrize("topic", [*NEEDED, topics.PWM_COMMAND])
def test_a_missing_topic_is_named(topic: Topic) -> None:
    gone = heard(topic, publishers=(), count=0, span=0.0, ages=())
    assert kinds(with_topic(gone)) == [(f"/{topic.name}", "missing topic")]


def test_nobody_needs_commands_when_the_program_says_the_duty() -> None:
    gone = heard(topics.PWM_COMMAND, publishers=(), count=0, span=0.0, ages=())
    plant = SeenNode("/plant", PLANT | {"duty_source": "program"}, 0, "running")
    assert kinds(replace(with_topic(gone), nodes=(plant,))) == []


def test_rates_follow_the_plants_own() -> None:
    plant = SeenNode("/plant", PLANT | {"rate": 400.0}, 0, "running")
    assert len(kinds(healthy(nodes=(plant,)))) == len(healthy().heard)
    twice = tuple(replace(h, count=1201) for h in healthy().heard)
    assert kinds(healthy(nodes=(plant,), heard=twice)) == []


def test_a_bridges_rate_is_that_of_its_rig() -> None:
    bridge = SeenNode("/hardware_bridge", {"rate": 100.0, "address": "udp://rig"}, 0, "running")
    half = tuple(replace(h, count=301) for h in healthy().heard)
    assert kinds(healthy(nodes=(bridge,), heard=half)) == []
    assert len(kinds(healthy(nodes=(bridge,)))) == len(healthy().heard)


def test_a_node_that_is_not_well_or_does_not_answer() -> None:
    sick = SeenNode("/observer", {}, NodeStatus.STATUS_LOST, "silent", "no sample")
    deaf = SeenNode("/plant", None, NodeStatus.STATUS_OK, "running")
    found = kinds(healthy(nodes=(sick, deaf)))
    assert ("/observer", "status") in found
    assert ("/plant", "no answer") in found


@pytest.mark.parametrize(("count", "kind"), [(0, "no clock"), (2, "two publishers")])
def test_simulated_time_needs_one_clock(count: int, kind: str) -> None:
    plant = SeenNode("/plant", PLANT | {"mode": "sim_time"}, 0, "running")
    listener = SeenNode("/observer", {"use_sim_time": True, "max_age": 0.0}, 0, "running")
    for name in ("/clock", "/front_left/clock"):
        there = {name: count, "/other/clock": 1}
        assert (name, kind) in kinds(healthy(nodes=(plant, listener), clocks=there))
        assert kinds(healthy(nodes=(plant, listener), clocks={name: 1})) == []
    assert ("/clock", "no clock") in kinds(healthy(nodes=(plant, listener)))


def test_the_clock_of_a_corner_is_the_one_that_its_nodes_have() -> None:
    def ends(said: str, *heard: str) -> tuple[list[Endpoint], list[Endpoint]]:
        return [end(said, topics.CLOCK)], [end(name, topics.CLOCK) for name in heard]

    found = {"/a/clock": ends("/a/plant", "/a/observer"), "/ab/clock": ends("/ab/plant")}
    shared = {"/clock": ends("/vehicle", "/a/observer", "/ab/observer")}
    assert clocks(found, "/a") == {"/a/clock": 1}
    assert clocks(found, "") == {"/a/clock": 1, "/ab/clock": 1}
    assert clocks(shared, "/ab") == {"/clock": 1}
    assert clocks(shared, "/c") == {}


def test_simulated_stamps_against_the_system_clock_are_found() -> None:
    plant = SeenNode("/plant", PLANT | {"mode": "sim_time"}, 0, "running")
    listener = SeenNode("/observer", {"use_sim_time": False, "max_age": 0.02}, 0, "running")
    found = kinds(healthy(nodes=(plant, listener), clocks={"/clock": 1}))
    assert found == [("/observer", "mixed time")]


def test_the_document_holds_what_the_table_shows() -> None:
    seen = with_topic(heard(FORCE, lost=3))
    made = document(seen, problems(seen))
    assert made["healthy"] is False
    assert len(rows(seen)) == len(seen.heard)
    (problem,) = made["problems"]  # type: ignore[misc]
    assert problem["kind"] == "lost messages"


def test_simulated_stamps_have_no_age() -> None:
    seen = healthy(nodes=(SeenNode("/plant", {**PLANT, "mode": "sim_time"}, 0, "running"),))
    assert {row[4] for row in rows(healthy())} == {"1.0"}
    assert {row[4] for row in rows(seen)} == {"-"}


def test_graphs_are_found_by_the_topics_of_the_contract() -> None:
    names = ["/car/left/sensors/force", "/car/left/pwm/applied", "/sensors/road", "/other/force"]
    assert namespaces(names) == ["", "/car/left"]
    assert namespaces(["/rosout", "/x/parameter_events"]) == []


def test_the_table_fits_a_terminal_with_whole_names() -> None:
    space = "/vehicle/suspension/front_left"
    each = tuple(
        replace(h, name=f"{space}{h.name}", publishers=(end(f"{space}/plant", h.topic),))
        for h in healthy().heard
    )
    out = io.StringIO()
    seen = healthy(namespace=space, heard=each)
    show(seen, problems(seen), Console(file=out, width=80))
    assert space in out.getvalue()
    assert "sensors/acceleration" in out.getvalue()
    assert "\N{HORIZONTAL ELLIPSIS}" not in out.getvalue()


def test_a_car_with_sensors_of_its_own_has_no_force_sensor_and_no_road() -> None:
    """Nor is it told so, where the accelerations are not ours; what every corner needs still is."""

    def foreign(gone: tuple[Topic, ...]) -> Observation:
        each = []
        for h in healthy().heard:
            own = h.topic is topics.PWM_COMMAND
            sender = () if h.topic in gone else (end("/ctrl" if own else "/chassis", h.topic),)
            each.append(replace(h, publishers=sender))
        return healthy(heard=tuple(each), nodes=healthy().nodes[1:])

    assert kinds(foreign((topics.FORCE, topics.ROAD))) == []
    found = kinds(foreign((topics.FORCE, topics.ROAD, topics.DEFLECTION)))
    assert found == [("/sensors/deflection", "missing topic")]


@pytest.mark.parametrize(("after", "said"), [(3, "/late"), (10**9, UNNAMED)])
def test_ends_whose_name_comes_late_are_waited_for_a_while(
    after: int, said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A process that starts beside the doctor: its ends are known before its name."""
    listener: Any = ros_listen._Listener.__new__(ros_listen._Listener)
    clock, looks = [0.0], []
    monkeypatch.setattr(ros_listen, "monotonic", lambda: clock[0])

    def turned(seconds: float) -> None:
        clock[0] += seconds

    def heard(log: str) -> Heard:
        looks.append(log)
        node = "/late" if len(looks) > after else UNNAMED
        return Heard(topics.ROAD, log, (end(node, topics.ROAD),), ())

    listener.logs, listener._turn, listener._heard = {"road": "/sensors/road"}, turned, heard
    (found,) = listener._all_named()
    assert found.publishers[0].node == said
    assert clock[0] <= ros_listen.ANSWERS + ros_listen.LOOK
