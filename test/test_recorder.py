"""The recorder's ends: whoever publishes is heard, however much the publisher offers."""

from __future__ import annotations

from collections.abc import Iterator
from pathlib import Path
from time import monotonic
from typing import Any

import pytest

pytest.importorskip("rclpy")

import rclpy
from er_model_lab.nodes.recorder import Recorder
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node

from er_common import topics
from er_ros_common import builders, qos
from test.graph_help import own_domain


@pytest.fixture
def ros() -> Iterator[SingleThreadedExecutor]:
    """ROS in this process, in a domain of its own."""
    with own_domain() as env:
        rclpy.init(args=[], domain_id=int(env["ROS_DOMAIN_ID"]))
        yield SingleThreadedExecutor()
        rclpy.try_shutdown()


def test_a_best_effort_sensor_that_comes_after_the_recorder_is_recorded(
    ros: SingleThreadedExecutor, tmp_path: Path
) -> None:
    recorder = Recorder(["--ros-args", "-p", f"out:={tmp_path / 'bag'}"])
    ros.add_node(recorder)
    recorder.start()
    force, sensors = topics.FORCE, Node("sensors")
    sent = 0

    def recorded(end: Any) -> None:
        """Publish there until one of these messages is recorded."""
        nonlocal sent
        before, limit = sent, monotonic() + 10.0
        while recorder.heard[f"/{force.name}"].count.last <= before:
            assert monotonic() < limit, "it was not recorded"
            sent += 1
            end.publish(builders.damper_force(builders.Tick(sent, sent), 1.0))
            ros.spin_once(timeout_sec=0.01)

    strong = sensors.create_publisher(force.type, force.name, qos.profile(force.publisher))
    recorded(strong)
    weak = sensors.create_publisher(force.type, force.name, qos.profile(force.subscriber))
    for end in (weak, strong, weak):
        recorded(end)
    assert recorder.heard[f"/{force.name}"].count.received <= sent
    recorder.on_stop()
    for node in (recorder, sensors):
        node.destroy_node()


def test_an_estimated_force_that_was_told_of_is_heard_before_anybody_says_it(
    ros: SingleThreadedExecutor, tmp_path: Path
) -> None:
    told = "sources:=[sensors/force, force/mine]"
    recorder = Recorder(["--ros-args", "-p", f"out:={tmp_path / 'bag'}", "-p", told])
    ros.add_node(recorder)
    recorder.start()
    assert recorder.taken["/force/mine"] == topics.FORCE.type_name
    assert recorder.taken["/sensors/force"] == topics.FORCE.type_name
    assert "/force/another" not in recorder.taken
    recorder.on_stop()
    recorder.destroy_node()
