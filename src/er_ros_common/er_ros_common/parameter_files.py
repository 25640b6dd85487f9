"""What ROS does not say about parameter files: where a value is from, that a file was not for us.

Without these checks a file for another node name is ignored in silence, a mixed list such as
``[1.0, 2]`` ends the process before the node exists, and a nested list is a message from the
inside of the YAML parser. No ROS here.
"""

from __future__ import annotations

import re
from collections.abc import Callable, Iterator, Mapping, Sequence
from itertools import zip_longest
from pathlib import Path

import yaml
from er_models.errors import InputError

BODY = "ros__parameters"
COMMAND_LINE = "command line"


def origins(argv: Sequence[str], full_name: str) -> dict[str, str]:
    """Where each parameter of a node was given: name to file or command line; later ones win.

    Raises:
        InputError: a file is missing, is no parameter file, or has nothing for this node.
    """
    found: dict[str, str] = {}
    for flag, value in _ros_arguments(argv):
        if flag == "--params-file":
            found.update(dict.fromkeys(_for_node(Path(value), full_name), value))
        elif own := _own(flag, value, full_name):
            found[own[0]] = COMMAND_LINE
    return found


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
        root = yaml.compose(path.read_text(encoding="utf-8"))
        assert isinstance(root, yaml.MappingNode)
        for pattern, body in _bodies(root, ""):
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


def _for_node(path: Path, full_name: str) -> set[str]:
    """Names a file gives to the node."""
    root = yaml.compose(path.read_text(encoding="utf-8"))
    assert isinstance(root, yaml.MappingNode)
    patterns = [pattern for pattern, _ in _bodies(root, "")]
    bodies = [body for pattern, body in _bodies(root, "") if matches(pattern, full_name)]
    if not bodies:
        found = ", ".join(sorted(set(patterns)))
        raise InputError(
            path, found, f"parameters for {full_name} (or /** for any node)", "another node's"
        )
    names: set[str] = set()
    for body in bodies:
        names.update(_flat(body, ""))
    return names


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
