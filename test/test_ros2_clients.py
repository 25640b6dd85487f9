"""The real `ros2 lifecycle`, `param` and `topic` with a node of ours, as a vehicle's engineer types them."""

from __future__ import annotations

import re
import signal
import subprocess
from collections.abc import Callable, Iterator
from pathlib import Path

import pytest

pytest.importorskip("rclpy")

from test.graph_help import Graph, own_domain, plant_arguments, skyhook_arguments
from test.ros2_tools import MISSING, command, tools

pytestmark = [pytest.mark.slow, pytest.mark.alone]
NODE = "/skyhook_controller"
Ask = Callable[..., tuple[int, str]]


@pytest.fixture
def graph(tmp_path: Path) -> Iterator[tuple[Graph, Ask]]:
    """A graph, and `ros2 WORDS` in its domain: exit status and what was said. No daemon is left behind."""
    paths = tools()
    if paths is None:
        pytest.skip(MISSING)
    with own_domain() as env, Graph(env, tmp_path) as running:

        def ask(*words: str, seconds: float = 60.0) -> tuple[int, str]:
            alone = () if words[1] == "hz" else ("--no-daemon", "--spin-time", "3")
            line = command(paths, *words, *alone)
            with subprocess.Popen(
                line, env=env, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True
            ) as process:
                try:
                    said, _ = process.communicate(timeout=seconds)
                except subprocess.TimeoutExpired:
                    process.send_signal(signal.SIGINT)
                    said, _ = process.communicate(timeout=20.0)
            return process.returncode, said

        yield running, ask


def test_a_manager_leads_a_node_and_tunes_it(graph: tuple[Graph, Ask]) -> None:
    running, ask = graph
    node = running.start("skyhook_controller", *skyhook_arguments("-p", "autostart:=false"))
    node.wait_for("unconfigured")
    assert ask("lifecycle", "get", NODE) == (0, "unconfigured [1]\n")
    for transition in ("configure", "activate"):
        assert ask("lifecycle", "set", NODE, transition) == (0, "Transitioning successful\n")
    assert ask("lifecycle", "get", NODE) == (0, "active [3]\n")
    status, said = ask("param", "get", NODE, "timeout")
    assert (status, said) == (0, "Double value is: 0.025\n")
    assert ask("param", "set", NODE, "timeout", "0.08") == (0, "Set parameter successful\n")
    assert ask("param", "get", NODE, "timeout") == (0, "Double value is: 0.08\n")
    _, said = ask("param", "set", NODE, "timeout", "70.0")
    assert re.search(r"failed: .*timeout", said), said
    assert ask("param", "get", NODE, "timeout") == (0, "Double value is: 0.08\n")
    _, said = ask("param", "describe", NODE, "timeout")
    assert "Parameter name: timeout" in said, said
    assert node.stop() == 0, node.text


def test_topics_are_listed_with_types_and_rates(graph: tuple[Graph, Ask]) -> None:
    running, ask = graph
    running.start("skyhook_controller", *skyhook_arguments())
    plant = running.start("plant", *plant_arguments("-p", "duration:=0.0"))
    plant.wait_for("running", 120.0)
    _, said = ask("topic", "list", "-t")
    for line in (
        "/sensors/acceleration [er_damper_msgs/msg/SuspensionAcceleration]",
        "/pwm/command [er_damper_msgs/msg/PwmDuty]",
        "/diagnostics [diagnostic_msgs/msg/DiagnosticArray]",
    ):
        assert line in said.splitlines(), said
    _, said = ask("topic", "info", "/pwm/command", "--verbose")
    assert re.search(r"Publisher count: 1\s", said)
    assert "Node name: skyhook_controller" in said
    _, said = ask("topic", "hz", "/sensors/acceleration", seconds=12.0)
    rates = [float(each) for each in re.findall(r"average rate: ([\d.]+)", said)]
    assert rates, said
    assert rates[-1] == pytest.approx(200.0, rel=0.05)
