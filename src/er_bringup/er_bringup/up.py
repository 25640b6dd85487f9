"""``er up``: starts the graph without ros2 launch, with the same arguments and command lines.

It ends with the plant, or with the first node that fails, or on Ctrl-C; a node that a signal ended is said at once,
and the others go on, as a supervisor may start it again. The recorder is stopped last, so that a recording holds how
everything ended. Why it ended is its last line but those of the nodes. The exit status is the worst of all nodes.
"""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Callable, Mapping, Sequence, Set
from pathlib import Path
from time import monotonic, sleep
from types import FrameType
from typing import IO

from ament_index_python.packages import (
    PackageNotFoundError,
    get_package_prefix,
    get_package_share_directory,
)
from er_model_lab.programs import RECORDER
from er_models.errors import ErError, InputError
from er_ros_common.spin import show

from er_bringup.arguments import table
from er_bringup.given import complete, parse
from er_bringup.graph import NodeSpec, ends_all, nodes
from er_bringup.processes import KILLED, POLL, RESPAWN, Child, say, stop, worst

USAGE = f"""usage: er up [KEY:=VALUE ...]

Starts plant, observers, controller and recorder as processes; ends with the plant or on Ctrl-C.

{table()}"""
STOPS = (signal.SIGINT, signal.SIGTERM, signal.SIGHUP)


def configuration() -> Path:
    """Folder of models, programs, gains and parameter files."""
    try:
        return Path(get_package_share_directory("er_bringup")) / "config"
    except PackageNotFoundError:
        return Path(os.path.realpath(__file__)).parents[1] / "config"


def executable(spec: NodeSpec) -> str:
    """Path of a node's program.

    Raises:
        InputError: The package is not installed, or has no such program.
    """
    try:
        folder = Path(get_package_prefix(spec.package)) / "lib" / spec.package
    except PackageNotFoundError:
        raise InputError(spec.package, "", "an installed package", "none") from None
    path = folder / spec.executable
    if not path.is_file():
        raise InputError(path, "", "a program", "no file")
    return str(path)


def argv(spec: NodeSpec) -> list[str]:
    """The whole command line of a node."""
    return [executable(spec), *spec.arguments(), *spec.place()]


def run(
    given: Mapping[str, str],
    out: IO[str] | None = None,
    stopping: Callable[[], str] = str,
) -> dict[str, int]:
    """Run the graph until it ends or `stopping` says so; returns the exit status of every node.

    Args:
        given: arguments, complete or not.
        out: where the nodes' lines go; None: standard output.
        stopping: asked again and again; a reason ends the graph.

    Raises:
        InputError: An argument, a file or a package is wrong; nothing was started then.
    """
    out = out or sys.stdout
    given = complete(given)
    specs = nodes(given, configuration())
    commands = {spec.label: argv(spec) for spec in specs}
    again = {*commands} - {RECORDER.name} if given["respawn"] == "true" else set()
    due: dict[str, float] = {}
    children: list[Child] = []
    try:
        children += (Child(label, command, out) for label, command in commands.items())
        last = {spec.label for spec in specs if ends_all(spec)}
        known: frozenset[str] = frozenset()
        while not (reason := stopping() or over(_statuses(children, again), last)):
            known = _tell_killed(_statuses(children), known, out)
            _start_again(children, due, {label: commands[label] for label in again}, out)
            sleep(POLL)
        say(f"[er up] {reason}: everything is stopped", out)
    finally:
        stop([child for child in children if child.label != RECORDER.name])
        stop([child for child in children if child.label == RECORDER.name])
    return {child.label: child.status or 0 for child in children}


def _statuses(children: Sequence[Child], again: Set[str] = frozenset()) -> dict[str, int | None]:
    """Exit statuses; None while it runs, or is to be started again."""
    each = {child.label: child.status for child in children}
    return {label: None if label in again and status else status for label, status in each.items()}


def _start_again(
    children: list[Child],
    due: dict[str, float],
    commands: Mapping[str, Sequence[str]],
    out: IO[str],
) -> None:
    """Start those of these commands again that ended badly; due: when that is for those that wait for it [s]."""
    now = monotonic()
    for place, child in enumerate(children):
        if child.label not in commands or not child.status:
            continue
        if now >= due.setdefault(child.label, now + RESPAWN):
            del due[child.label]
            child.finish()
            say(f"[er up] {child.label} is started again", out)
            children[place] = Child(child.label, commands[child.label], out)


def _tell_killed(
    statuses: Mapping[str, int | None], known: frozenset[str], out: IO[str]
) -> frozenset[str]:
    """Say which processes a signal has ended since the last look; all that it ended so far."""
    now = frozenset(label for label, status in statuses.items() if status and status >= KILLED)
    for label in sorted(now - known):
        say(f"[er up] {label} {_how(statuses[label] or 0)}: the others go on without it", out)
    return now


def over(statuses: Mapping[str, int | None], last: Set[str]) -> str:
    """Why the graph is over, "" while it is not; a node that was killed may be replaced.

    Args:
        statuses: exit status of each process, None while it runs.
        last: processes without which there is no graph, the plants of all corners.
    """
    ended = {label: status for label, status in statuses.items() if status is not None}
    failed = {label: status for label, status in ended.items() if 0 < status < KILLED}
    if failed:
        return _words(failed)
    if last and last <= ended.keys():
        return _words({label: ended[label] for label in last})
    return "everybody has ended" if len(ended) == len(statuses) else ""


def _words(ended: Mapping[str, int]) -> str:
    """Which processes ended, and how where that was not well."""
    return ", ".join(f"{label} {_how(status)}" for label, status in sorted(ended.items()))


def _how(status: int) -> str:
    """How a process ended, from its exit status."""
    if status < KILLED:
        return f"ended with exit status {status}" if status else "ended"
    number = status - KILLED
    known = {each.value: each.name for each in signal.Signals}
    return f"was ended by {known.get(number, f'signal {number}')}"


def main() -> None:
    """Entry point of the command."""
    given = sys.argv[1:]
    if any(word in ("-h", "--help", "--show-args", "-s") for word in given):
        show(USAGE)
        sys.exit(0)
    told: list[str] = []

    def tell(number: int, _: FrameType | None) -> None:
        told.append(f"{signal.Signals(number).name} came")

    for number in STOPS:
        signal.signal(number, tell)
    try:
        statuses = run(parse(given), stopping=lambda: "".join(told[:1]))
    except ErError as error:
        sys.stderr.write(f"er up: {error}\n")
        sys.exit(error.exit_status)
    for label, status in statuses.items():
        if status:
            sys.stderr.write(f"er up: {label} {_how(status)}\n")
    sys.exit(worst(statuses))


if __name__ == "__main__":
    main()
