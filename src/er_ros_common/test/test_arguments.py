"""Command lines of nodes: what is written is what the node gets, in its type."""

from __future__ import annotations

import math

import pytest

pytest.importorskip("rclpy")

import rclpy
from er_ros_common.arguments import ros_arguments, written
from rclpy.context import Context
from rclpy.node import Node

VALUES = {
    "text": "run 1",
    "number_as_text": "12",
    "truth_as_text": "true",
    "quote": "it's",
    "path": "/data/a:=b",
    "empty": "",
    "whole_float": 1.0,
    "tiny": 1e-05,
    "huge": 1e22,
    "negative": -2,
    "yes": True,
    "texts": ["a", "b c"],
    "counts": [1, 2, 3],
    "weights": [1.0, 2.5],
}


def given(arguments: list[str]) -> dict[str, object]:
    """Parameters a node started with these arguments has."""
    context = Context()
    rclpy.init(args=arguments, context=context)
    try:
        node = Node(
            "probe",
            context=context,
            automatically_declare_parameters_from_overrides=True,
            start_parameter_services=False,
            enable_rosout=False,
        )
        names = [name for name in VALUES if node.has_parameter(name)]
        found = {name: node.get_parameter(name).value for name in names}
        node.destroy_node()
    finally:
        rclpy.shutdown(context=context)
    return {k: list(v) if hasattr(v, "tolist") else v for k, v in found.items()}


def test_every_value_arrives_as_it_was_meant() -> None:
    found = given(ros_arguments(parameters=VALUES))
    assert found == VALUES
    assert {k: type(v) for k, v in found.items()} == {k: type(v) for k, v in VALUES.items()}


def test_names_and_files_come_in_an_order_in_which_single_parameters_win() -> None:
    line = ros_arguments(parameters={"a": 1}, files=["f.yaml"], name="n", namespace="/fl/")
    assert line == [
        "--ros-args", "-r", "__ns:=/fl", "-r", "__node:=n",
        "--params-file", "f.yaml", "-p", "a:=1",
    ]  # fmt: skip


def test_nothing_to_say_is_nothing() -> None:
    assert ros_arguments() == []


@pytest.mark.parametrize("value", [math.pi, 1e-9, -1e300, 0.1 + 0.2])
def test_no_digit_of_a_number_is_lost(value: float) -> None:
    assert float(written(value)) == value
    assert "." in written(value)
