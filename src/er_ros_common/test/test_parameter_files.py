"""Parameter files: what ROS ignores or dies of is said in one line; values are traced."""

from __future__ import annotations

from pathlib import Path

import pytest
from er_models.errors import InputError
from er_ros_common.parameter_files import (
    check_files,
    check_names,
    dropped,
    matches,
    origins,
    read_value,
    shared,
    unused,
)


def argv(path: Path) -> list[str]:
    """Command line that passes a parameter file."""
    return ["--ros-args", "-r", "__ns:=/fl", "--params-file", str(path)]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("", "expected /\\*\\* or a node's name, then ros__parameters, found none"),
        ("/**:\n  rate: 1.0\n", "then ros__parameters, found none"),
        ("/**: [\n", "line 2: expected YAML"),
        ("/**:\n  ros__parameters:\n    g: [1.0, 2]\n", "g: expected entries of one type"),
        (
            "/**:\n  ros__parameters:\n    a:\n      g: [[1.0], [2.0]]\n",
            "a.g: expected a flat list",
        ),
        ("/**:\n  ros__parameters:\n    g: ['1', 2]\n", "found integer and text"),
    ],
)
def test_file_that_would_end_the_process_is_refused(
    tmp_path: Path, text: str, message: str
) -> None:
    path = tmp_path / "p.yaml"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=message) as caught:
        check_files(argv(path))
    assert str(caught.value).startswith(str(path))


def test_missing_file_is_named(tmp_path: Path) -> None:
    with pytest.raises(InputError, match=r"none\.yaml: expected a readable parameter file"):
        check_files(argv(tmp_path / "none.yaml"))


@pytest.mark.parametrize("entries", ["1.0, 2.5, 1e-3, .5, -2.0", "1, -2, 0x10", "a, 'b', \"c\""])
def test_lists_of_one_type_pass(tmp_path: Path, entries: str) -> None:
    path = tmp_path / "p.yaml"
    path.write_text(f"/**:\n  ros__parameters:\n    g: [{entries}]\n", encoding="utf-8")
    check_files(argv(path))


def test_values_are_traced_and_the_later_one_wins(tmp_path: Path) -> None:
    path = tmp_path / "p.yaml"
    text = "/**:\n  ros__parameters:\n    rate: 1.0\n    noise: {force: 0.1}\n    seed: 3\n"
    path.write_text(text, encoding="utf-8")
    found = origins([*argv(path), "-p", "rate:=2.0"], "/fl/plant")
    assert found == {"rate": "command line", "noise.force": str(path), "seed": str(path)}


def test_a_file_for_other_nodes_is_left_alone_and_told(tmp_path: Path) -> None:
    path = tmp_path / "p.yaml"
    path.write_text("observer:\n  ros__parameters:\n    rate: 1.0\n", encoding="utf-8")
    assert origins(argv(path), "/fl/plant") == {}
    (line,) = unused(argv(path), "/fl/plant")
    assert line == f"{path}: nothing in it is for /fl/plant, only for /observer"
    assert unused(argv(path), "/observer") == []


def test_a_file_for_a_name_that_is_nearly_the_nodes_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "p.yaml"
    path.write_text("/fl/plnat:\n  ros__parameters:\n    rate: 1.0\n", encoding="utf-8")
    words = r"p\.yaml: /fl/plnat: expected parameters for /fl/plant \(or /\*\* for any node\)"
    with pytest.raises(InputError, match=words):
        origins(argv(path), "/fl/plant")


def test_what_is_given_to_many_is_told_from_what_is_given_to_the_node(tmp_path: Path) -> None:
    path = tmp_path / "p.yaml"
    path.write_text(
        "/**:\n  ros__parameters: {a: 1, b: 2}\n/**/plant:\n  ros__parameters: {b: 3, c: 4}\n"
        "/other:\n  ros__parameters: {d: 5}\n",
        encoding="utf-8",
    )
    single = ["-p", "e:=1", "-p", "plant:f:=1", "-p", "other:g:=1"]
    assert shared([*argv(path), *single], "/fl/plant") == {"a", "e"}


@pytest.mark.parametrize(
    ("pattern", "meant"),
    [
        ("/**", ""),
        ("/**/plant", ""),
        ("/camera", ""),
        ("/car/observer", ""),
        ("/plant", "/fl/plant"),
        ("/fl/plnat", "/fl/plant"),
        ("/fl/obsrver", "/fl/plant"),
    ],
)
def test_a_file_for_a_graph_names_its_nodes(tmp_path: Path, pattern: str, meant: str) -> None:
    path = tmp_path / "p.yaml"
    path.write_text(f"{pattern}:\n  ros__parameters: {{a: 1}}\n", encoding="utf-8")
    given = (str(path), ["/fl/plant"], ["plant", "observer"])
    if not meant:
        check_names(*given)
        return
    with pytest.raises(InputError, match=rf"{pattern}: expected a node .* mean {meant}\?"):
        check_names(*given)


def test_arguments_after_the_ros_ones_are_not_read(tmp_path: Path) -> None:
    check_files(["--ros-args", "-p", "a:=1", "--", "--params-file", str(tmp_path / "none.yaml")])


@pytest.mark.parametrize(
    ("pattern", "full_name", "applies"),
    [
        ("/**", "/plant", True),
        ("/**", "/a/b/plant", True),
        ("/**/plant", "/a/b/plant", True),
        ("/**/plant", "/a/b/planter", False),
        ("/*/plant", "/a/plant", True),
        ("/*/plant", "/a/b/plant", False),
        ("/plant", "/plant", True),
        ("/plant", "/a/plant", False),
        ("/a.b", "/axb", False),
    ],
)
def test_node_name_patterns(pattern: str, full_name: str, applies: bool) -> None:
    assert matches(pattern, full_name) is applies


@pytest.mark.parametrize(
    ("written", "file_has", "meant"),
    [
        ("high", 0.1, "high"),
        ("0", 0.1, 0),
        ("1e-3", 1, 1e-3),
        ("'0.2'", 0.2, "0.2"),
        ("true", 1, True),
        (".nan", 1, None),
    ],
)
def test_the_command_line_wins_over_a_file_of_another_type(
    written: str, file_has: object, meant: object
) -> None:
    argv = ["--ros-args", "--params-file", "f.yaml", "-p", f"a:={written}"]
    (found,) = dropped(argv, {"a": file_has}, "/plant").values()
    assert found == meant or (meant is None and found != found)


def test_a_parameter_of_the_same_type_or_before_the_file_is_ros_own_business() -> None:
    argv = ["--ros-args", "--params-file", "f.yaml", "-p", "a:=0.3", "-p", "b:=[1, 2]"]
    assert dropped(argv, {"a": 0.3, "b": [1, 2]}, "/plant") == {}
    argv = ["--ros-args", "-p", "a:=x", "--params-file", "f.yaml"]
    assert dropped(argv, {"a": 0.1}, "/plant") == {}


@pytest.mark.parametrize(
    ("node", "full_name", "own"),
    [("", "/fl/plant", True), ("plant:", "/plant", True), ("plant:", "/fl/plant", False),
     ("skyhook_controller:", "/plant", False)],
)  # fmt: skip
def test_a_parameter_for_another_node_of_the_command_line_is_left_alone(
    node: str, full_name: str, own: bool
) -> None:
    argv = ["--ros-args", "-p", f"{node}a:=3"]
    assert origins(argv, full_name) == ({"a": "command line"} if own else {})
    assert dropped(argv, {"a": 0.1}, full_name) == ({"a": 3} if own else {})


@pytest.mark.parametrize(
    ("written", "read"),
    [
        ("1e-3", 1e-3),
        ("0x10", 16),
        ("yes", True),
        ("'1e-3'", "1e-3"),
        ("udp://rig:1", "udp://rig:1"),
        ("[1e-3, 2.0]", [1e-3, 2.0]),
        ("[a, b]", ["a", "b"]),
        ("", None),
    ],
)
def test_a_value_is_read_as_ros_reads_it(written: str, read: object) -> None:
    assert read_value(written, "--set a") == read


@pytest.mark.parametrize("written", ["[1", "'", "08", "*a"])
def test_what_cannot_be_read_is_one_line(written: str) -> None:
    with pytest.raises(InputError, match="--set a: expected a value as YAML"):
        read_value(written, "--set a")
