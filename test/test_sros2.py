"""The access policy of SROS2: of the format's grammar, and allowing each node what it does and no more."""

from __future__ import annotations

import re
from fnmatch import fnmatchcase
from pathlib import Path
from typing import Any
from xml.etree import ElementTree as ET

import pytest

pytest.importorskip("rclpy")

import rclpy
from er_bringup.given import CAR as CORNERS
from er_bringup.integration.names import BASE
from er_bringup.integration.ros_sros2 import OPERATOR, cards, policy
from er_bringup.programs import ADAPTERS, CONTROLLERS, EVERY
from er_bringup.ros_composed import part
from er_common.topics import PWM_COMMAND, SENSORS
from er_models.errors import ErError
from er_ros_common.help import Card

from test.graph_help import own_domain

GRAMMAR = {
    "policy": ({"version"}, {"enclaves"}),
    "enclaves": (set(), {"enclave"}),
    "enclave": ({"path"}, {"profiles"}),
    "profiles": (set(), {"profile"}),
    "profile": ({"ns", "node"}, {"topics", "services", "actions"}),
    "topics": ({"publish", "subscribe"}, {"topic"}),
    "services": ({"reply", "request"}, {"service"}),
    "actions": ({"call", "execute"}, {"action"}),
    **{leaf: (set(), set()) for leaf in ("topic", "service", "action")},
}
"""Elements of the format 0.2.0, in our own words: their attributes, and what they hold, at least one of it."""
MEASURING = ("plant", "hardware_bridge", *(each.name for each in ADAPTERS))
ABOVE = ("/diagnostics", "/parameter_events", "/rosout", "/clock")
"""Topics that are no namespace's."""
POLICIES = {"root": [""], "car": [f"{BASE}/{corner}" for corner in CORNERS]}


@pytest.fixture(scope="module", params=POLICIES)
def made(request: pytest.FixtureRequest) -> ET.Element:
    """The policy of one corner, or of a car."""
    return ET.fromstring(policy(POLICIES[request.param]).encode())


def test_the_policy_is_of_the_formats_grammar(made: ET.Element) -> None:
    assert (made.tag, made.get("version")) == ("policy", "0.2.0")
    for each in made.iter():
        attributes, children = GRAMMAR[each.tag]
        assert set(each.attrib) <= attributes, ET.tostring(each)
        assert {child.tag for child in each} <= children
        assert bool(len(each)) == bool(children)
        if "topic" in children or "service" in children or "action" in children:
            assert list(each.attrib.values()) == ["ALLOW"]
        else:
            assert set(each.attrib) == attributes
        if not children:
            assert re.fullmatch(r"/?[\w*]+(/[\w*]+)*", each.text or ""), each.text
    paths = [enclave.get("path") for enclave in made.iter("enclave")]
    assert len({*paths}) == len(paths)


def test_the_policy_is_valid_under_the_schema_of_sros2(made: ET.Element) -> None:
    etree = pytest.importorskip("lxml.etree")
    sros2 = pytest.importorskip("sros2", reason="no sros2 here")
    schema = Path(sros2.__file__).parent / "policy/schemas/policy.xsd"
    etree.XMLSchema(etree.parse(str(schema))).assertValid(etree.fromstring(ET.tostring(made)))


def allowed(profile: ET.Element, kind: str, what: str, name: str) -> bool:
    """Whether a profile allows something for a name of the graph."""
    ns = str(profile.get("ns")).rstrip("/")
    for names in profile.findall(f"{kind}s[@{what}='ALLOW']"):
        for each in names:
            text = str(each.text)
            if fnmatchcase(name, text if text.startswith("/") else f"{ns}/{text}"):
                return True
    return False


def profile(made: ET.Element, node: str) -> ET.Element:
    """The profile of a node in the enclave of its own."""
    for enclave in made.iter("enclave"):
        if (
            str(enclave.get("path")).endswith(f"/{node}")
            and len(found := enclave.findall("*/profile")) == 1
        ):
            return found[0]
    raise AssertionError(f"{node} has no enclave")


def full(profile: ET.Element, name: str) -> str:
    """A topic of a node, as the graph calls it."""
    ns = str(profile.get("ns")).rstrip("/")
    text = name.replace("~", f"{ns}/{profile.get('node')}")
    return text if text.startswith("/") else f"{ns}/{text}"


@pytest.mark.parametrize("card", cards(), ids=lambda card: card.program.name)
def test_a_node_may_do_what_its_card_says(made: ET.Element, card: Card) -> None:
    own = profile(made, card.program.name)
    for what, ends in (("publish", card.publishes), ("subscribe", card.subscribes)):
        for topic in ends:
            assert allowed(own, "topic", what, full(own, topic.name)), topic.name


def test_what_every_node_has_beside_its_card_is_allowed(made: ET.Element) -> None:
    """Of nodes as they are made, with the ends that ROS and all of ours give them."""
    with own_domain() as env:
        rclpy.init(args=[], domain_id=int(env["ROS_DOMAIN_ID"]))
        try:
            for name in ("er_bringup/imu_adapter", "er_bringup/ros2_control_joint"):
                node: Any = part([name]).executable.make(
                    ["--ros-args", "-p", "use_sim_time:=true"]
                )
                own = profile(made, node.get_name())
                ends = {
                    ("topic", "publish"): [each.topic_name for each in node.publishers],
                    ("topic", "subscribe"): [each.topic_name for each in node.subscriptions],
                    ("service", "reply"): [each.service_name for each in node.services],
                }
                node.destroy_node()
                assert len(ends["topic", "publish"]) >= 3
                assert len(ends["service", "reply"]) > 6
                ns = str(own.get("ns")).rstrip("/")
                for (kind, what), found in ends.items():
                    for end in found:
                        there = end if end in ABOVE else f"{ns}{end}"
                        assert allowed(own, kind, what, there), (what, there)
        finally:
            rclpy.try_shutdown()


def test_only_who_should_command_or_measure_may(made: ET.Element) -> None:
    commanding = {each.name for each in CONTROLLERS.values()} | {
        "body_controller",
        "ros2_control_joint",
    }
    for own in made.iter("profile"):
        node = str(own.get("node"))
        assert allowed(own, "topic", "publish", full(own, PWM_COMMAND.name)) <= (
            node in commanding
        )
        for topic in SENSORS:
            measuring = node in MEASURING
            assert allowed(own, "topic", "publish", full(own, topic.name)) <= measuring
        sets = allowed(own, "service", "request", "/plant/set_parameters")
        assert sets == (node == OPERATOR)


def test_every_program_that_is_a_node_has_its_enclave(made: ET.Element) -> None:
    nodes = set()
    for each in EVERY:
        try:
            nodes.add(part([f"{each.package}/{each.name}"]).executable.card.program.name)
        except ErError:
            continue
    found = {str(enclave.get("path")).rpartition("/")[2] for enclave in made.iter("enclave")}
    assert found == nodes | {OPERATOR, "composed"}
