"""Every node has all that it needs: a step of "Add a node" (CONTRIBUTING.md) that was forgotten fails by name."""

from __future__ import annotations

import re
import runpy
from importlib import import_module
from typing import Any

import pytest
import setuptools
import yaml

pytest.importorskip("rclpy")

from er_bringup.arguments import ARGUMENTS
from er_bringup.programs import (
    ADAPTERS,
    ANSWERING,
    CONTROLLERS,
    EVERY,
    JOINT,
)
from er_bringup.ros_checks import CONTRACT
from er_common.common_parameters import FramedParameters
from er_common.parameter_table import specs
from er_common.program import CONTROLLER, OBSERVER
from er_common.topics import ESTIMATED
from er_model_lab.nodes.selection import KNOWN
from er_model_lab.programs import RECORDER
from er_ros_common.core_node import node_of
from er_ros_common.spin import Executable

from er_ros_common import entry
from test import replay_golden
from test.conftest import ROOT
from test.graph_help import NODES, PROGRAMS

BY_HAND = dict.fromkeys(
    (JOINT.name, *(each.name for each in ADAPTERS)),
    "started beside a vehicle stack (docs/vehicle.md)",
)
"""Nodes that the graph of `er up` does not hold."""
WITHOUT_FILE = {RECORDER.name: "all of it is given per run", **BY_HAND}
"""Nodes without a parameter file of their own."""
EACH = pytest.mark.parametrize("name", sorted(NODES))


def scripts(monkeypatch: pytest.MonkeyPatch) -> dict[str, str]:
    """Console scripts of every setup.py, run as the build runs it: name to what is called."""
    found: dict[str, str] = {}

    def told(**given: Any) -> None:
        for each in given.get("entry_points", {}).get("console_scripts", ()):
            name, _, target = each.partition(" = ")
            assert name not in found, each
            found[name] = target

    monkeypatch.setattr(setuptools, "setup", told)
    for path in sorted((ROOT / "src").glob("*/setup.py")):
        monkeypatch.chdir(path.parent)
        runpy.run_path(str(path))
    return found


def documented() -> set[tuple[str, str]]:
    """Package and executable of every row of the table in docs/nodes.md."""
    found = set()
    text = (ROOT / "docs/nodes.md").read_text(encoding="utf-8")
    for cell in re.findall(r"^\| (`er_[^|]*)\|", text, re.M):
        package, _, first = re.findall(r"`([^`]*)`", cell)[0].partition(" ")
        found |= {(package, name) for name in (first, *re.findall(r"`([^`]*)`", cell)[1:])}
    return found


def node(name: str) -> Executable:
    """What a node is to `composed`."""
    program = NODES[name]
    found = node_of(program) if program.core else import_module(program.path).NODE
    assert isinstance(found, Executable)
    return found


def test_every_program_has_its_script_and_every_script_its_program(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    expected = {p.name: f"{p.package}.executables:{p.name}" for p in EVERY}
    assert len(expected) == len(EVERY)
    assert scripts(monkeypatch) == expected | {"er-lab": "er_model_lab.cli.app:main"}


@pytest.mark.parametrize("name", sorted(PROGRAMS))
def test_the_script_starts_the_program_named_like_it(name: str, monkeypatch: Any) -> None:
    began: list[str] = []
    monkeypatch.setattr("signal.signal", lambda *_: None)
    monkeypatch.setattr(entry, "run", lambda program: began.append(program.name))
    executables = import_module(f"{PROGRAMS[name].package}.executables")
    getattr(executables, name)()
    assert began == [name]
    with pytest.raises(KeyError, match="none_of_them"):
        executables.none_of_them()


@EACH
def test_the_card_tells_of_this_node(name: str) -> None:
    card = node(name).card
    assert card.program is NODES[name]
    assert len(card.program.text) > 10
    assert card.parameters is not None
    assert issubclass(card.parameters, FramedParameters) or not card.program.core


@EACH
def test_a_row_of_the_documentation_names_it(name: str) -> None:
    assert (NODES[name].package, name) in documented(), "docs/nodes.md, first table"


@pytest.mark.parametrize("name", sorted(NODES.keys() - WITHOUT_FILE.keys()))
def test_its_parameter_file_holds_parameters_it_has(name: str) -> None:
    path = ROOT / f"config/nodes/{name}.yaml"
    assert path.is_file(), path
    given = yaml.safe_load(path.read_text(encoding="utf-8"))["/**"]["ros__parameters"]
    parameters = node(name).card.parameters
    assert parameters is not None
    assert set(given) <= {spec.name for spec in specs(parameters)}


@pytest.mark.parametrize("name", sorted(name for name, each in NODES.items() if each.core))
def test_the_answers_of_a_core_are_golden(name: str) -> None:
    golden = yaml.safe_load(replay_golden.FILE.read_text(encoding="utf-8"))
    assert name in golden["values"], "./er exec python -m test.replay_golden --reason '...'"


@pytest.mark.parametrize("name", sorted(NODES.keys() - BY_HAND.keys()))
def test_the_graph_can_hold_it(name: str) -> None:
    program, card = NODES[name], node(name).card
    assert program.says is None or program.says in card.publishes
    assert program.says is None or program.says in CONTRACT
    assert {*program.listens, *program.uses} <= set(card.subscribes)


@pytest.mark.parametrize("program", ANSWERING, ids=lambda program: program.name)
def test_a_node_has_every_parameter_that_the_graph_gives_it(program: Any) -> None:
    given = {"model_file": program.model, "gains_file": bool(program.gains), "rate": program.rate}
    known = {spec.name for spec in specs(node(program.name).card.parameters)}  # type: ignore[arg-type]
    assert {name for name, is_given in given.items() if is_given} == known & given.keys()


@pytest.mark.parametrize("program", ANSWERING, ids=lambda program: program.name)
def test_every_answering_node_can_be_asked_for(program: Any) -> None:
    arguments = {argument.name: argument for argument in ARGUMENTS}
    assert (
        program.kind in (OBSERVER, CONTROLLER) or arguments[program.name].meaning == program.asked
    )
    assert set(arguments["controller"].choices) == {*CONTROLLERS, "none"}


@pytest.mark.parametrize("program", ANSWERING, ids=lambda program: program.name)
def test_the_recorder_takes_what_it_says(program: Any) -> None:
    names = [topic.name for topic in program.said if topic not in KNOWN]
    assert all(name.startswith(ESTIMATED) for name in names), "er_model_lab/nodes/selection.py"
