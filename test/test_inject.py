"""The service of a running plant: what is injected reaches the graph, and only where it is allowed."""

from __future__ import annotations

import math
from collections.abc import Callable, Iterator
from time import monotonic
from typing import Any

import pytest

pytest.importorskip("rclpy")

import rclpy
from er_plant_sim.nodes.plant import PlantNode
from rclpy.executors import SingleThreadedExecutor

from er_common import topics
from er_damper_msgs.srv import InjectFault
from test.graph_help import own_domain, plant_arguments

pytestmark = pytest.mark.alone

Asked = Callable[..., tuple[bool, str]]


@pytest.fixture
def plant(request: pytest.FixtureRequest) -> Iterator[tuple[Asked, Callable[[float], list[Any]]]]:
    """A plant, how to ask its service, and its accelerations during some seconds."""
    with own_domain() as env:
        rclpy.init(args=[], domain_id=int(env["ROS_DOMAIN_ID"]))
        allowed = f"enable_fault_injection:={request.param}"
        node = PlantNode(plant_arguments("-p", "duration:=0.0", "-p", allowed))
        node.start()
        other = rclpy.create_node("other")
        heard: list[Any] = []
        since = 0
        there = topics.ACCELERATION
        other.create_subscription(there.type, there.name, heard.append, 100)
        client = other.create_client(InjectFault, "/plant/inject_fault")
        executor = SingleThreadedExecutor()
        for each in (node, other):
            executor.add_node(each)

        def run(done: Callable[[], object], seconds: float = 60.0) -> None:
            end = monotonic() + seconds
            while not done() and monotonic() < end:
                executor.spin_once(timeout_sec=0.02)

        def ask(
            unit: str, kind: int, value: float = 0.0, duration: float = 0.0
        ) -> tuple[bool, str]:
            run(client.service_is_ready)
            request = InjectFault.Request(unit=unit, kind=kind, value=value, duration=duration)
            answer = client.call_async(request)
            run(answer.done)
            heard.clear()
            nonlocal since
            since = node.tick.seq
            return answer.result().accepted, answer.result().reason

        def listen(seconds: float) -> list[Any]:
            """What was sent from the answer on: some of what was sent before it may still be on its way."""
            run(lambda: False, seconds)
            return [m for m in heard if m.seq > since]

        run(lambda: len(heard) > 10)
        yield ask, listen
        for each in (node, other):
            each.destroy_node()
        rclpy.try_shutdown()


@pytest.mark.parametrize("plant", ["false"], indirect=True)
def test_without_permission_it_is_refused(plant: tuple[Asked, Any]) -> None:
    ask, listen = plant
    assert ask("sensors/acceleration", InjectFault.Request.OFF) == (
        False,
        "the parameter enable_fault_injection is false",
    )
    assert len(listen(0.2)) > 5


@pytest.mark.parametrize("plant", ["true"], indirect=True)
def test_what_is_injected_goes_out_on_the_topic(plant: tuple[Asked, Any]) -> None:
    ask, listen = plant
    kinds = InjectFault.Request
    accepted, reason = ask("sensors/acceleration.sprung", kinds.STUCK)
    assert (accepted, reason) == (True, "sensors/acceleration stuck")
    stuck = listen(0.2)
    assert len({m.sprung for m in stuck}) == 1
    assert len({m.unsprung for m in stuck}) == len(stuck)
    assert ask("sensors/acceleration", kinds.GARBAGE)[0]
    assert any(not math.isfinite(m.sprung) for m in listen(0.3))
    assert ask("sensors/acceleration", kinds.OFF, duration=0.3)[0]
    assert len(listen(0.2)) <= 2
    assert len(listen(0.4)) > 10
    accepted, reason = ask("sensors/nothing", kinds.OFF)
    assert not accepted
    assert "unit: expected one of" in reason
    # the duty of this plant is its program's: no command would be missed
    accepted, reason = ask("pwm/command", kinds.OFF)
    assert not accepted
    assert "found 'pwm/command'" in reason
    accepted, reason = ask("sensors/acceleration", kinds.SLOW, 1000.0)
    assert not accepted
    assert "below the 200 Hz" in reason
