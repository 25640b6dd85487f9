"""``composed``: any set of nodes in one process, with one executor and one thread.

    er_bringup composed PACKAGE/EXECUTABLE [--ros-args ...] -- PACKAGE/EXECUTABLE [--ros-args ...] -- [--ros-args ...]

Each node has a command line of its own, as if it were a process of its own; what follows the last `--` without a
node, as a launch file puts it there, is for all of them. One that ends, or that fails, ends all.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from importlib import import_module
from typing import NamedTuple

import rclpy
from er_models.errors import ErError
from er_ros_common.core_node import node_of
from er_ros_common.spin import Executable, guarded, live, show
from er_ros_common.stopping import Stopped
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.utilities import remove_ros_args

from er_bringup.programs import COMPOSED

BETWEEN = "--"
"""Stands between the command lines of two nodes."""


class Part(NamedTuple):
    """One node: its program and its own command line."""

    name: str
    executable: Executable
    argv: tuple[str, ...]


def split(argv: Sequence[str]) -> tuple[list[list[str]], list[str]]:
    """The command line of each node, its name first, and what is for all of them."""
    groups: list[list[str]] = [[]]
    for word in argv:
        if word == BETWEEN:
            groups.append([])
        else:
            groups[-1].append(word)
    common = groups.pop() if groups[-1][:1] == ["--ros-args"] else []
    return [[*group, *common] for group in groups if group], common


def part(group: Sequence[str]) -> Part:
    """One node of the command line.

    Raises:
        ErError: No such node, or an argument that is none of ROS.
    """
    name, *argv = group
    package, _, executable = name.partition("/")
    try:
        programs = {p.name: p for p in import_module(f"{package}.programs").PROGRAMS}
        program = programs[executable]
        found = node_of(program) if program.core else import_module(program.path).NODE
    except (ModuleNotFoundError, AttributeError, KeyError, ValueError):
        expected = "PACKAGE/EXECUTABLE of a node, er_plant_sim/plant for instance"
        raise ErError(f"expected {expected}, found '{name}'") from None
    plain = remove_ros_args(["", *argv])[1:]
    if plain:
        raise ErError(f"{name}: unknown argument '{plain[0]}'; ROS arguments follow --ros-args")
    return Part(name, found, tuple(argv))


def _run(argv: Sequence[str], stopped: Stopped) -> None:
    with stopped.making():  # importing many nodes takes long: nobody who wants an end waits for it
        groups, common = split(argv)
        parts = [part(group) for group in groups]
    if not parts:
        raise ErError("expected at least one node, see --help")
    rclpy.init(args=common, signal_handler_options=SignalHandlerOptions.NO)

    def made() -> list[Node]:
        nodes: list[Node] = []
        for each in parts:
            nodes.append(each.executable.make(each.argv))
        return nodes

    live(made, stopped)


def main() -> None:
    """Entry point of the executable."""
    argv = sys.argv[1:]
    if any(word in ("-h", "--help") for word in argv):
        show(__doc__ or "")
        sys.exit(0)
    sys.exit(guarded(COMPOSED.name, argv, lambda stopped: _run(argv, stopped)))


if __name__ == "__main__":
    main()
