"""Parameters of a node: what nothing would follow is refused."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass

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
