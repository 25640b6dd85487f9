"""Parameters of a node: what nothing would follow is refused."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from pathlib import Path

import pytest
from er_models.errors import InputError

pytest.importorskip("rclpy")

import rclpy
from er_ros_common.parameters import declare, param
from rclpy.context import Context
from rclpy.node import Node
from rclpy.parameter import Parameter


@dataclass(frozen=True, kw_only=True)
class Parameters:
    """One of its own."""

    gain: float = param(1.0, text="a gain")


@pytest.fixture
def made() -> Iterator[Callable[[str], Parameters]]:
    """Gives a parameter to a node that declares its table."""
    context = Context()
    rclpy.init(args=[], context=context)

    def declared(name: str) -> Parameters:
        node = Node(
            "probe",
            context=context,
            parameter_overrides=[Parameter(name, value=1)],
            start_parameter_services=False,
            enable_rosout=False,
        )
        try:
            return declare(node, Parameters, argv=[])
        finally:
            node.destroy_node()

    yield declared
    rclpy.shutdown(context=context)


@pytest.mark.parametrize("topic", ["/pwm/command", "/clock_of_ours", "/fl/sensors/force"])
def test_the_quality_of_a_topic_cannot_be_overridden(
    made: Callable[[str], Parameters], topic: str
) -> None:
    name = f"qos_overrides.{topic}.publisher.depth"
    with pytest.raises(InputError, match=rf"command line: {name}: expected no override.*found 1"):
        made(name)


@pytest.mark.parametrize("topic", ["/parameter_events", "/clock", "/rosout"])
def test_overrides_of_what_ros_itself_has_are_nobodys_mistake(
    made: Callable[[str], Parameters], topic: str
) -> None:
    assert made(f"qos_overrides.{topic}.subscription.depth") == Parameters(gain=1.0)


@pytest.mark.parametrize(
    ("node", "namespace", "own"),
    [("", "/fl", True), ("probe:", "/", True), ("probe:", "/fl", False), ("other:", "/", False)],
)
def test_a_parameter_of_the_command_line_is_given_to_the_nodes_that_ros_gives_it_to(
    node: str, namespace: str, own: bool, tmp_path: Path
) -> None:
    file = tmp_path / "p.yaml"
    file.write_text("/**:\n  ros__parameters:\n    gain: 2.0\n", encoding="utf-8")
    argv = ["--ros-args", "--params-file", str(file), "-p", f"{node}gain:={{}}"]
    context = Context()
    rclpy.init(args=[], context=context)

    def gain(text: str) -> float:
        each = [word.format(text) for word in argv]
        made = Node(
            "probe",
            context=context,
            namespace=namespace,
            cli_args=each,
            use_global_arguments=False,
            start_parameter_services=False,
            enable_rosout=False,
        )
        try:
            return declare(made, Parameters, argv=each).gain
        finally:
            made.destroy_node()

    try:
        # of the type of the file's: ROS' own doing
        assert gain("3.0") == (3.0 if own else 2.0)
        if own:
            with pytest.raises(InputError, match="command line: gain"):
                gain("high")
        else:
            assert gain("high") == 2.0
    finally:
        rclpy.shutdown(context=context)


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("/**:\n  ros__parameters: {gain: 2.0, wheel_base: 2.7, camera: {fps: 30}}\n", ""),
        ("/**:\n  ros__parameters: {gian: 2.0}\n", r"gian: expected .*did you mean gain\?"),
        ("/fl/probe:\n  ros__parameters: {wheel_base: 2.7}\n", "wheel_base: expected .*known: gain"),
    ],
)  # fmt: skip
def test_keys_of_others_are_left_alone_and_misspelt_ones_refused(
    text: str, words: str, tmp_path: Path
) -> None:
    file = tmp_path / "p.yaml"
    file.write_text(text, encoding="utf-8")
    argv = ["--ros-args", "-r", "__ns:=/fl", "--params-file", str(file), "-p", "door:=1"]
    context = Context()
    rclpy.init(args=[], context=context)
    node = Node(
        "probe",
        context=context,
        cli_args=argv,
        use_global_arguments=False,
        start_parameter_services=False,
        enable_rosout=False,
    )
    try:
        if words:
            with pytest.raises(InputError, match=words):
                declare(node, Parameters, argv=argv)
        else:
            assert declare(node, Parameters, argv=argv) == Parameters(gain=2.0)
    finally:
        node.destroy_node()
        rclpy.shutdown(context=context)
