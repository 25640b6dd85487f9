"""Every node has all that it needs: a step of "Add a node" (CONTRIBUTING.md) that was forgotten fails by name."""

from __future__ import annotations

import ast
import re
from importlib import import_module
from typing import Any

import pytest
import yaml

pytest.importorskip("rclpy")

from er_bringup.arguments import ARGUMENTS
from er_bringup.cores import cores
from er_bringup.roles import Role
from er_bringup.ros_checks import CONTRACT
from er_common.parameter_table import specs
from er_ros_common.core_node import CoreNode
from er_ros_common.spin import Executable

from er_bringup import roles
from test import replay_golden
from test.conftest import ROOT
from test.graph_help import NODES

PROGRAMS = {
    "composed": "holds nodes",
    "device_emulator": "behaves like a rig: no part of the ROS graph",
}
"""Console scripts made as nodes are that are none."""
COMMANDS = {"er-lab"}
"""Console scripts of people, with a module of their own."""
BY_HAND = {"ros2_control_joint": "started beside a vehicle stack (docs/vehicle.md)"}
"""Nodes that the graph of `er up` does not hold."""
WITHOUT_FILE = {"recorder": "all of it is given per run", **BY_HAND}
"""Nodes without a parameter file of their own."""


def scripts() -> dict[str, tuple[str, str]]:
    """Console scripts of every setup.py: name to its package and what is called."""
    found: dict[str, tuple[str, str]] = {}
    for path in sorted((ROOT / "src").glob("*/setup.py")):
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            text = node.value if isinstance(node, ast.Constant) else None
            match = (
                re.fullmatch(r"([\w-]+) = ([\w.]+:\w+)", text) if isinstance(text, str) else None
            )
            if match:
                found[match[1]] = (path.parent.name, match[2])
    return found


def documented() -> set[tuple[str, str]]:
    """Package and executable of every row of the table in docs/nodes.md."""
    found = set()
    text = (ROOT / "docs/nodes.md").read_text(encoding="utf-8")
    for cell in re.findall(r"^\| (`er_[^|]*)\|", text, re.M):
        package, _, first = re.findall(r"`([^`]*)`", cell)[0].partition(" ")
        found |= {(package, name) for name in (first, *re.findall(r"`([^`]*)`", cell)[1:])}
    return found


def graph_roles() -> list[Role]:
    """What `er up` and the launch file can start."""
    kinds = (*roles.CONTROLLERS.values(), *roles.OBSERVERS.values())
    return [roles.PLANT, roles.BRIDGE, roles.RECORDER, roles.FAULTS, *kinds]


def node(name: str) -> Executable:
    """What the module of a node offers to `composed`."""
    found = import_module(NODES[name]).NODE
    assert isinstance(found, Executable)
    return found


SCRIPTS = scripts()
EACH = pytest.mark.parametrize("name", sorted(NODES))


def test_a_program_is_a_node_or_says_what_else_it_is() -> None:
    assert set(SCRIPTS) == set(NODES) | set(PROGRAMS) | COMMANDS


@EACH
def test_the_script_starts_the_node_named_like_it(name: str, monkeypatch: Any) -> None:
    package, target = SCRIPTS[name]
    assert target == f"{package}.executables:{name}"
    began: list[str] = []
    module = import_module(NODES[name])
    monkeypatch.setattr("signal.signal", lambda *_: None)
    monkeypatch.setattr(module, "main", lambda: began.append(name))
    getattr(import_module(f"{package}.executables"), name)()
    assert began == [name]


@EACH
def test_the_card_tells_of_this_node(name: str) -> None:
    card = node(name).card
    assert (card.package, card.executable) == (SCRIPTS[name][0], name)
    assert len(card.text) > 10
    assert card.parameters is not None


@EACH
def test_a_row_of_the_documentation_names_it(name: str) -> None:
    assert (SCRIPTS[name][0], name) in documented(), "docs/nodes.md, first table"


@pytest.mark.parametrize("name", sorted(NODES.keys() - WITHOUT_FILE.keys()))
def test_its_parameter_file_holds_parameters_it_has(name: str) -> None:
    path = ROOT / f"config/nodes/{name}.yaml"
    assert path.is_file(), path
    given = yaml.safe_load(path.read_text(encoding="utf-8"))["/**"]["ros__parameters"]
    parameters = node(name).card.parameters
    assert parameters is not None
    assert set(given) <= {spec.name for spec in specs(parameters)}


@EACH
def test_the_core_of_a_shell_is_known_to_replay_and_its_answers_are_golden(name: str) -> None:
    made: Any = node(name).make
    kind = getattr(made, "func", made)
    if not (isinstance(kind, type) and issubclass(kind, CoreNode)):
        return
    assert name in cores(), "CORES of its ros_*.py, MODULES of er_bringup/cores.py"
    assert cores()[name][0] is node(name).card.parameters
    golden = yaml.safe_load(replay_golden.FILE.read_text(encoding="utf-8"))
    assert name in golden["values"], "./er exec python -m test.replay_golden --reason '...'"


@pytest.mark.parametrize("name", sorted(NODES.keys() - BY_HAND.keys()))
def test_the_graph_can_hold_it(name: str) -> None:
    (role,) = (r for r in graph_roles() if r.executable == name)
    assert role.package == SCRIPTS[name][0]
    said = [topic.name for topic in node(name).card.publishes]
    assert not role.says or role.says in said
    assert not role.says or role.says in {topic.name for topic in CONTRACT}, "topics.ESTIMATES"
    heard = {topic.name for topic in node(name).card.subscribes}
    assert {roles.PUBLISHED[key] for key in role.listens} <= heard


def test_every_controller_can_be_asked_for() -> None:
    (asked,) = (a for a in ARGUMENTS if a.name == "controller")
    assert set(asked.choices) == {*roles.CONTROLLERS, "none"}
