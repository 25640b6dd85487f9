"""What ROS does not say about parameter files: where a value is from, that a file was not for us.

Without these checks a file for another node name is ignored in silence, a mixed list such as
``[1.0, 2]`` ends the process before the node exists, and a nested list is a message from the
inside of the YAML parser. No ROS here.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from difflib import get_close_matches
from itertools import zip_longest
from pathlib import Path

import yaml
from er_models.errors import InputError

BODY = "ros__parameters"
COMMAND_LINE = "command line"
MISSPELT = 0.75
"""Similarity (difflib's ratio) from which a name is taken for another one misspelt: one letter in four."""


def origins(argv: Sequence[str], full_name: str) -> dict[str, str]:
    """Where each parameter of a node was given: name to file or command line; later ones win.

    Raises:
        InputError: a file is missing, is no parameter file, or names a node nearly like this one.
    """
    return {name: where for name, where, _ in _each_given(argv, full_name)}


def shared(argv: Sequence[str], full_name: str) -> set[str]:
    """Parameters that a node was given as one of many: below ``/**`` in a file, or by a plain ``-p NAME:=VALUE``.

    A launch file's SetParameter is such a plain one, so that what no node of ours has may be another's. What is
    given to the node by its name, too, is not among them; raises as `origins` does.
    """
    each = [*_each_given(argv, full_name)]
    return {name for name, _, wild in each if wild} - {n for n, _, wild in each if not wild}


def unused(argv: Sequence[str], full_name: str) -> list[str]:
    """One line for each parameter file that has nothing for a node, as when it is for all nodes of a vehicle."""
    files = [Path(value) for flag, value in _ros_arguments(argv) if flag == "--params-file"]
    named = {file: [pattern for pattern, _ in _bodies(_root(file), "")] for file in files}
    return [
        f"{file}: nothing in it is for {full_name}, only for {', '.join(sorted({*patterns}))}"
        for file, patterns in named.items()
        if not any(matches(pattern, full_name) for pattern in patterns)
    ]


def _each_given(argv: Sequence[str], full_name: str) -> Iterator[tuple[str, str, bool]]:
    """Each parameter that a node was given: its name, where, and whether it was to many."""
    for flag, value in _ros_arguments(argv):
        if flag == "--params-file":
            for pattern, body in _for_node(Path(value), full_name):
                wild = pattern.rpartition("/")[2].startswith("*")
                yield from ((name, value, wild) for name in _flat(body, ""))
        elif own := _own(flag, value, full_name):
            yield own[0], COMMAND_LINE, ":" not in value.partition(":=")[0]


def dropped(argv: Sequence[str], given: Mapping[str, object], full_name: str) -> dict[str, object]:
    """Parameters of a node on the command line that ROS drops in silence, with the value that was meant.

    Where a file gives a parameter in one type and the command line in another (0.1 there, 0 here),
    ROS keeps both and rclpy takes the file's.
    """
    written: dict[str, str] = {}
    for flag, value in _ros_arguments(argv):
        if flag == "--params-file":
            written.clear()
        elif own := _own(flag, value, full_name):
            written.update([own])
    meant = {name: _meant(text) for name, text in written.items() if name in given}
    return {
        name: value
        for name, value in meant.items()
        if value is not None and _kind_of_value(value) != _kind_of_value(given[name])
    }


def read_value(text: str, where: str) -> object:
    """What was written for a parameter, a list among it, as ROS reads it: 1e-3 is a number.

    Raises:
        InputError: It cannot be read; where: what gave it.
    """
    try:
        node = yaml.compose(text)
        if isinstance(node, yaml.ScalarNode):
            return _scalar(node)
        if isinstance(node, yaml.SequenceNode):
            flat = all(isinstance(entry, yaml.ScalarNode) for entry in node.value)
            return [_scalar(entry) for entry in node.value] if flat else yaml.safe_load(text)
        return yaml.safe_load(text)
    except (yaml.YAMLError, ValueError):
        raise InputError(where, "", "a value as YAML writes it", f"'{text}'") from None


def _meant(text: str) -> object:
    """What was written for a parameter, as ROS reads it; None for lists, which keep their type."""
    node = yaml.compose(text)
    return _scalar(node) if isinstance(node, yaml.ScalarNode) else None


def _scalar(node: yaml.ScalarNode) -> object:
    """A single value as ROS reads it."""
    convert: dict[str, Callable[[str], object]] = {
        "integer": lambda t: int(t, 0),
        "decimal": _decimal,
        "text": str,
    }
    return convert.get(_kind(node), yaml.safe_load)(node.value)


def _decimal(text: str) -> float:
    """A decimal as YAML writes it: with a dot before nan and inf."""
    return float(re.sub(r"\.(nan|inf)", r"\1", text, flags=re.IGNORECASE))


def _kind_of_value(value: object) -> str:
    """Type of a value, in the same words."""
    kinds = {bool: "true/false", int: "integer", float: "decimal", str: "text"}
    return kinds.get(type(value), "list")


def given_in(files: Sequence[str], full_name: str, name: str) -> object:
    """Value of a parameter of a node in parameter files, of which the last wins; None where none gives it.

    Raises:
        InputError: a file is missing or is no parameter file.
    """
    found: object = None
    for path in map(Path, files):
        _check_file(path)
        for pattern, body in _bodies(_root(path), ""):
            if matches(pattern, full_name):
                values = [value for key, value in body.value if key.value == name]
                found = _meant(values[-1].value) if values else found
    return found


def check_files(argv: Sequence[str]) -> None:
    """Refuse parameter files that ROS would end the process over, with a line that says where.

    Raises:
        InputError: missing or unreadable file, nested or mixed list, no ``ros__parameters``.
    """
    for flag, value in _ros_arguments(argv):
        if flag == "--params-file":
            _check_file(Path(value))


def check_names(path: str, named: Sequence[str], known: Sequence[str]) -> None:
    """Refuse a file for nodes of a graph that names one of them in another namespace, or nearly as one of ours.

    named: full names of the nodes that there are; known: names of all programs of ours.

    Raises:
        InputError: it cannot be read, or there is such a name.
    """
    _check_file(Path(path))
    for pattern, _ in _bodies(_root(Path(path)), ""):
        last = pattern.rpartition("/")[2]
        near = get_close_matches(last, known, n=1, cutoff=MISSPELT)
        absent = last in known and not any(name.endswith(f"/{last}") for name in named)
        if near and not absent and not any(matches(pattern, name) for name in named):
            (meant,) = get_close_matches(pattern, named, n=1, cutoff=0.0)
            raise InputError(path, pattern, f"a node of the graph (did you mean {meant}?)", "none")


def _ros_arguments(argv: Sequence[str]) -> Iterator[tuple[str, str]]:
    """Pairs of flag and value between ``--ros-args`` and ``--``."""
    inside = False
    for flag, value in zip_longest(argv, argv[1:], fillvalue=""):
        if flag in ("--ros-args", "--"):
            inside = flag == "--ros-args"
        elif inside and flag.startswith("-"):
            yield flag, value


def _own(flag: str, value: str, full_name: str) -> tuple[str, str] | None:
    """Name and text of a parameter of the command line; None where it is another node's, NODE:NAME:=TEXT."""
    if flag not in ("-p", "--param"):
        return None
    place, _, text = value.partition(":=")
    node, colon, name = place.rpartition(":")
    return (name, text) if not colon or matches(node, full_name) else None


def _check_file(path: Path) -> None:
    try:
        root = yaml.compose(path.read_text(encoding="utf-8"))
    except OSError as error:
        raise InputError(path, "", "a readable parameter file", error.strerror) from None
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        line = getattr(getattr(error, "problem_mark", None), "line", 0) + 1
        raise InputError(path, f"line {line}", "YAML", getattr(error, "problem", None)) from None
    if not isinstance(root, yaml.MappingNode) or not list(_bodies(root, "")):
        raise InputError(path, BODY, "/** or a node's name, then ros__parameters", "none")
    for _, body in _bodies(root, ""):
        _check_lists(path, body, "")


def _bodies(node: yaml.MappingNode, prefix: str) -> Iterator[tuple[str, yaml.MappingNode]]:
    """Node-name patterns and the mapping below their ``ros__parameters``."""
    for key, value in node.value:
        if key.value == BODY and isinstance(value, yaml.MappingNode):
            yield prefix or "/", value
        elif isinstance(value, yaml.MappingNode) and key.value != BODY:
            yield from _bodies(value, f"{prefix}/{key.value.strip('/')}")


def _check_lists(path: Path, body: yaml.MappingNode, prefix: str) -> None:
    for key, value in body.value:
        name = f"{prefix}{key.value}"
        if isinstance(value, yaml.MappingNode):
            _check_lists(path, value, f"{name}.")
        elif isinstance(value, yaml.SequenceNode):
            if any(not isinstance(entry, yaml.ScalarNode) for entry in value.value):
                raise InputError(
                    path, name, "a flat list (a matrix row by row)", "a list in a list"
                )
            kinds = sorted({_kind(entry) for entry in value.value})
            if len(kinds) > 1:
                expected = "entries of one type (2.0, not 2, among decimals)"
                raise InputError(path, name, expected, " and ".join(kinds))


def _kind(entry: yaml.ScalarNode) -> str:
    """Type of a list entry as ROS reads it: 1e-3 is a number, which it is not in YAML 1.1."""
    if entry.style in ("'", '"'):
        return "text"
    if re.fullmatch(r"[-+]?(0x[0-9a-fA-F]+|\d+)", entry.value):
        return "integer"
    if re.fullmatch(r"[-+]?(\d+\.\d*|\.?\d+)([eE][-+]?\d+)?|[-+]?\.(inf|nan)", entry.value, re.I):
        return "decimal"
    return (
        "true/false"
        if entry.value.lower() in ("true", "false", "yes", "no", "on", "off")
        else "text"
    )


def _root(path: Path) -> yaml.MappingNode:
    """Content of a parameter file that was checked."""
    root = yaml.compose(path.read_text(encoding="utf-8"))
    assert isinstance(root, yaml.MappingNode)
    return root


def _for_node(path: Path, full_name: str) -> list[tuple[str, yaml.MappingNode]]:
    """What a file gives to a node, by pattern; a name that is nearly the node's is a mistake, others are others'."""
    each = [*_bodies(_root(path), "")]
    found = [(pattern, body) for pattern, body in each if matches(pattern, full_name)]
    names = {pattern.rpartition("/")[2]: pattern for pattern, _ in each}
    own = full_name.rpartition("/")[2]
    near = get_close_matches(own, names, n=1, cutoff=MISSPELT)
    if not found and near and near[0] != own:
        expected = f"parameters for {full_name} (or /** for any node)"
        raise InputError(path, names[near[0]], expected, "a name that no node has")
    return found


def _flat(body: yaml.MappingNode, prefix: str) -> Iterator[str]:
    for key, value in body.value:
        if isinstance(value, yaml.MappingNode):
            yield from _flat(value, f"{prefix}{key.value}.")
        else:
            yield f"{prefix}{key.value}"


def matches(pattern: str, full_name: str) -> bool:
    """Whether a node-name pattern applies: ``*`` is one part of the name, ``**`` any number."""
    parts = [p for p in pattern.split("/") if p]
    wild: Mapping[str, str] = {"**": r"(/[^/]+)*", "*": r"/[^/]+"}
    expression = "".join(wild.get(p, "/" + re.escape(p)) for p in parts)
    return re.fullmatch(expression, full_name) is not None
