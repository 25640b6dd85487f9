"""The access policy of SROS2, in XML: an enclave for every node, with what its card says that it publishes and hears.

Who is in none of them can publish no duty and no sensor, and ask nothing of a node. The enclave `operator` is for
people's commands (`er doctor`, `ros2 param`): it hears everything and asks every service, but publishes nothing of a
corner.

    ./er exec python -m er_bringup.integration.ros_sros2 NAMESPACE ...    # several: the corners of one car
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from sys import argv
from typing import Final
from xml.etree import ElementTree as ET

from er_common.parameter_table import specs
from er_ftc_controller.programs import BODY
from er_model_lab.programs import MONITOR, RECORDER
from er_plant_sim.programs import CAR, EMULATOR, WIRE_KEY
from er_ros_common.help import Card

from er_bringup.programs import COMPOSED, EVERY
from er_bringup.ros_composed import part
from er_common import topics

VERSION: Final = "0.2.0"
"""Of the format of policies that ROS 2 Jazzy reads."""
SAID: Final = ("~/transition_event", topics.DIAGNOSTICS.name, "/parameter_events", "/rosout")
"""What every node publishes beside what its card tells."""
NO_NODES: Final = (COMPOSED, EMULATOR, WIRE_KEY)
OF_ALL_CORNERS: Final = (CAR, BODY, RECORDER)
"""Nodes in the namespace above, where there are several corners."""
ACTIONS: Final = {MONITOR: ("~/diagnose",)}
OPERATOR: Final = "operator"
COMMANDS: Final = ("*doctor/*", "*doctor_looking/*", "*inject/*", "*_ros2cli*/*")
"""Services of the nodes of people's commands."""


def cards() -> tuple[Card, ...]:
    """Those of all nodes."""
    names = (f"{each.package}/{each.name}" for each in EVERY if each not in NO_NODES)
    return tuple(part([name]).executable.card for name in names)


def policy(namespaces: Sequence[str]) -> str:
    """The policy of the nodes in these namespaces, as XML; several are the corners of one car."""
    root = ET.Element("policy", version=VERSION)
    enclaves, known = ET.SubElement(root, "enclaves"), cards()
    above = [card for card in known if card.program in OF_ALL_CORNERS]
    if len(namespaces) > 1:
        known = tuple(card for card in known if card not in above)
        _nodes(enclaves, namespaces[0].rpartition("/")[0], above)
    for namespace in namespaces:
        _nodes(enclaves, namespace, known)
    _people(_enclave(enclaves, f"/{OPERATOR}"))
    ET.indent(root)
    return f'<?xml version="1.0" encoding="UTF-8"?>\n{ET.tostring(root, encoding="unicode")}\n'


def _nodes(enclaves: ET.Element, namespace: str, known: Sequence[Card]) -> None:
    """An enclave for each node of a namespace, and one for all that share a process."""
    base = f"/{namespace.strip('/')}"
    each = {card.program.name: [card] for card in known}
    each[COMPOSED.name] = [card for card in known if card.program is not RECORDER]
    for name, inside in each.items():
        profiles = _enclave(enclaves, f"{base.rstrip('/')}/{name}")
        for card in inside:
            _node(profiles, base, card)


def _enclave(enclaves: ET.Element, path: str) -> ET.Element:
    return ET.SubElement(ET.SubElement(enclaves, "enclave", path=path), "profiles")


def _node(profiles: ET.Element, base: str, card: Card) -> None:
    """What one node may do."""
    profile = ET.SubElement(profiles, "profile", ns=base, node=card.program.name)
    heard = [topics.CLOCK.name, *(topic.name for topic in card.subscribes)]
    asked: tuple[str, ...] = ()
    if card.program is RECORDER:  # it keeps everything, and the nodes' parameters
        heard, asked = ["/*"], ("/*/get_parameters", "/*/list_parameters")
    elif card.parameters and "wait_for_nodes" in [spec.name for spec in specs(card.parameters)]:
        heard += ["/*/status", "/*/recorded"]
    _may(profile, "topic", "publish", [*SAID, *(topic.name for topic in card.publishes)])
    _may(profile, "topic", "subscribe", heard)
    _may(profile, "service", "reply", ["~/*"])
    _may(profile, "service", "request", asked)
    _may(profile, "action", "execute", ACTIONS.get(card.program, ()))


def _people(profiles: ET.Element) -> None:
    profile = ET.SubElement(profiles, "profile", ns="/", node=OPERATOR)
    _may(profile, "topic", "publish", ("/parameter_events", "/rosout"))
    _may(profile, "topic", "subscribe", ("/*",))
    _may(profile, "service", "reply", COMMANDS)
    _may(profile, "service", "request", ("/*",))
    _may(profile, "action", "call", ("/*",))


def _may(profile: ET.Element, kind: str, what: str, names: Iterable[str]) -> None:
    """Allow something for these names, each once, those of the node's own among them."""
    once = dict.fromkeys(name.replace("~", str(profile.get("node"))) for name in names)
    if once:
        allowed = ET.SubElement(profile, f"{kind}s", {what: "ALLOW"})
        for name in once:
            ET.SubElement(allowed, kind).text = name


if __name__ == "__main__":
    print(policy(argv[1:] or [""]), end="")  # noqa: T201
