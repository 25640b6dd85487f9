"""The doctor on running graphs with faults that ROS 2 itself is silent about."""

from __future__ import annotations

import json
import subprocess
import sys
from pathlib import Path

import pytest

pytest.importorskip("rclpy")

from test.graph_help import Graph, own_domain, plant_arguments

pytestmark = pytest.mark.alone

INTRUDER = """
import rclpy
from std_msgs.msg import Float64
from er_common import topics
from er_ros_common import qos
rclpy.init()
node = rclpy.create_node("intruder")
road = node.create_publisher(topics.ROAD.type, topics.ROAD.name, qos.profile(topics.ROAD.publisher))
force = node.create_subscription(Float64, topics.FORCE.name, print, 10)
there = topics.DEFLECTION
latched = node.create_subscription(there.type, there.name, print, qos.profile(topics.STATUS.subscriber))
print("up", flush=True)
rclpy.spin(node)
"""


def test_faults_of_a_running_graph_are_named(tmp_path: Path) -> None:
    report = tmp_path / "doctor.json"
    with own_domain() as env, Graph(env, tmp_path) as graph:
        plant = graph.start("plant", *plant_arguments("-p", "duration:=0.0"))
        plant.wait_for("[plant]: running")
        intruder = subprocess.Popen(
            [sys.executable, "-c", INTRUDER],
            env=env,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
        )
        try:
            assert intruder.stdout is not None
            assert intruder.stdout.readline() == b"up\n"
            status, text = graph.run("doctor", "--seconds", "2", "--json", str(report))
        finally:
            intruder.kill()
            intruder.wait()
    assert status == 1, text
    found = {(p["topic"], p["kind"]): p for p in json.loads(report.read_text())["problems"]}
    assert "/intruder" in found[("/sensors/road", "two publishers")]["text"]
    assert "std_msgs/msg/Float64" in found[("/sensors/force", "other type")]["text"]
    assert "transient local" in found[("/sensors/deflection", "incompatible QoS")]["text"]
    assert all(p["cure"] for p in found.values())


def test_graphs_below_namespaces_are_found_each_with_its_own_nodes_only(tmp_path: Path) -> None:
    report = tmp_path / "doctor.json"
    with own_domain() as env, Graph(env, tmp_path) as graph:
        plants = [
            graph.start("plant", *plant_arguments("-p", "duration:=0.0", "-r", f"__ns:=/car/{c}"))
            for c in ("left", "right")
        ]
        for plant in plants:
            plant.wait_for("plant]: running")
        _, text = graph.run("doctor", "--seconds", "1", "--json", str(report))
    graphs = json.loads(report.read_text())["graphs"]
    assert [g["namespace"] for g in graphs] == ["/car/left", "/car/right"]
    for g in graphs:
        assert {n["node"] for n in g["nodes"]} == {f"{g['namespace']}/plant"}
        assert "missing topic" not in {p["kind"] for p in g["problems"]}
        assert {row["lost"] for row in g["topics"]} == {"0"}
    assert "graph in /car/right" in text


def test_an_empty_graph_is_said_to_be_empty(tmp_path: Path) -> None:
    with own_domain() as env, Graph(env, tmp_path) as graph:
        status, text = graph.run("doctor", "--seconds", "0.5", "--json", "-")
    assert status == 1
    assert [p["kind"] for p in json.loads(text)["problems"]] == ["empty graph"]
