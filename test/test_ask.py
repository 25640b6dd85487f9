"""Parameters of a running node, set by a program that is no part of the graph."""

from __future__ import annotations

from collections.abc import Iterator
from threading import Thread

import pytest

pytest.importorskip("rclpy")

import rclpy
from er_models.errors import ErError
from rcl_interfaces.msg import SetParametersResult
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.parameter import Parameter

from er_bringup import ros_ask
from test.graph_help import own_domain


@pytest.fixture
def node(monkeypatch: pytest.MonkeyPatch) -> Iterator[Node]:
    """A node that takes any number but 13."""
    with own_domain() as env:
        monkeypatch.setenv("ROS_DOMAIN_ID", env["ROS_DOMAIN_ID"])
        context = rclpy.Context()
        rclpy.init(args=[], context=context)
        made = rclpy.create_node("plant", context=context)
        made.declare_parameter("number", 1)
        made.add_on_set_parameters_callback(unlucky)
        executor = SingleThreadedExecutor(context=context)
        executor.add_node(made)
        thread = Thread(target=executor.spin)
        thread.start()
        yield made
        executor.shutdown()
        thread.join()
        rclpy.try_shutdown(context=context)


def unlucky(asked: list[Parameter]) -> SetParametersResult:
    bad = any(each.value == 13 for each in asked)
    return SetParametersResult(successful=not bad, reason="an unlucky one" if bad else "")


def test_a_node_takes_them_or_says_why_not(node: Node, monkeypatch: pytest.MonkeyPatch) -> None:
    ros_ask.set_parameters("/plant", number=7)
    assert node.get_parameter("number").value == 7
    with pytest.raises(ErError, match="/plant: an unlucky one"):
        ros_ask.set_parameters("/plant", number=13)
    assert node.get_parameter("number").value == 7
    monkeypatch.setattr(ros_ask, "ANSWER", 0.3)
    with pytest.raises(ErError, match="/nobody: does not answer"):
        ros_ask.set_parameters("/nobody", number=7)
