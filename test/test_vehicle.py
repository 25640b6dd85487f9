"""A vehicle stack with one corner: its own names, its own sensors and amplifier; it loses a sensor. docs/vehicle.md.

The stack is this test: it simulates the car, publishes under names of its own, applies the duty it is given, and
keeps the last word on it. Where it does not keep to real time it has a clock, as simulated vehicles do.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path
from time import monotonic, monotonic_ns, sleep, time_ns
from typing import Any

import pytest

pytest.importorskip("rclpy")

import rclpy
import yaml
from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from er_common.parameter_table import build as parameters_of
from er_plant_sim.build import build
from er_plant_sim.duty_gate import Command
from er_plant_sim.settings import PlantParameters
from er_ros_common.builders import Tick
from er_ros_common.clock import to_stamp
from rclpy.executors import SingleThreadedExecutor
from rclpy.qos import DurabilityPolicy, QoSProfile, ReliabilityPolicy
from rosgraph_msgs.msg import Clock

from er_damper_msgs.msg import (
    DamperForce,
    NodeStatus,
    PwmDuty,
    SuspensionAcceleration,
    SuspensionDeflection,
)
from er_plant_sim import rig as plant
from er_plant_sim import ros_msgs
from test.graph_help import CONFIG, VEHICLE, Graph, own_domain, paced

pytestmark = pytest.mark.alone

CORNER = "vehicle/suspension/front_left"
NAMES = {
    "sensors/acceleration": "/chassis/front_left/acceleration",
    "sensors/deflection": "/chassis/front_left/deflection",
    "pwm/applied": "/chassis/front_left/duty",
    "pwm/command": "/chassis/front_left/duty_wanted",
}
PERIOD = 5_000_000
RELIABLE = QoSProfile(depth=10, reliability=ReliabilityPolicy.RELIABLE)
NEWEST = QoSProfile(depth=1, reliability=ReliabilityPolicy.RELIABLE)
LATCHED = QoSProfile(
    depth=1,
    reliability=ReliabilityPolicy.RELIABLE,
    durability=DurabilityPolicy.TRANSIENT_LOCAL,
)


@dataclass
class Heard:
    """Messages with the time of the car at which they came [s]."""

    commands: list[tuple[float, PwmDuty]] = field(default_factory=list)
    forces: list[tuple[float, DamperForce]] = field(default_factory=list)
    diagnostics: list[tuple[float, DiagnosticStatus]] = field(default_factory=list)
    status: list[tuple[float, NodeStatus]] = field(default_factory=list)


class Stack:
    """A car with an amplifier, as a vehicle stack sees it: nothing of ours but the messages."""

    def __init__(self, node: Any, pace: float) -> None:
        self.node, self.heard, self.pace = node, Heard(), pace
        file = yaml.safe_load((CONFIG / "nodes/plant.yaml").read_text())
        given = file["/**"]["ros__parameters"] | {
            "model_file": VEHICLE, "program_file": str(CONFIG / "experiments/iso_steps.yaml"),
            "duration": 0.0, "duty_source": "topic", "seed": 2,
        }  # fmt: skip
        self.rig = build(parameters_of(PlantParameters, given, {}))
        self.state, self.blind = plant.start(self.rig), False
        self.forces: dict[int, float] = {}

        def out(topic: str, kind: Any) -> Any:
            return node.create_publisher(kind, NAMES[topic], RELIABLE)

        self.acceleration = out("sensors/acceleration", SuspensionAcceleration)
        self.deflection = out("sensors/deflection", SuspensionDeflection)
        self.applied = out("pwm/applied", PwmDuty)
        self.clock = None if pace == 1.0 else node.create_publisher(Clock, "/clock", RELIABLE)
        node.create_subscription(PwmDuty, NAMES["pwm/command"], self.on_command, NEWEST)
        for kind, name, kept, profile in (
            (DamperForce, f"/{CORNER}/force/unified", self.heard.forces, RELIABLE),
            (NodeStatus, f"/{CORNER}/skyhook_controller/status", self.heard.status, LATCHED),
        ):
            node.create_subscription(
                kind, name, lambda m, k=kept: k.append((self.now(), m)), profile
            )
        node.create_subscription(DiagnosticArray, "/diagnostics", self.on_diagnostics, RELIABLE)
        self.executor = SingleThreadedExecutor(context=node.context)
        self.executor.add_node(node)
        self.began = monotonic_ns()

    def on_command(self, message: PwmDuty) -> None:
        self.heard.commands.append((self.now(), message))
        tick = self.state.sim.tick
        wish = Command(
            min(int(message.seq), tick) * self.rig.dt,
            int(message.seq),
            message.duty,
            message.source,
        )
        self.state = plant.receive(self.rig, self.state, wish, valid=message.valid)

    def on_diagnostics(self, message: DiagnosticArray) -> None:
        mine = [each for each in message.status if each.name.startswith(f"{CORNER}/")]
        self.heard.diagnostics += [(self.now(), each) for each in mine]

    def now(self) -> float:
        """Time of the car, which goes on while it waits [s]."""
        return self.pace * monotonic()

    def run(self, seconds: float) -> None:
        """Drive at 200 Hz of its time; ticks that the machine was too busy for come late, none is left out."""
        end = self.now() + seconds
        while self.now() < end:
            due = self.began + round(self.state.sim.tick * PERIOD / self.pace)
            while monotonic_ns() < due:
                self.executor.spin_once(timeout_sec=max(1e-9 * (due - monotonic_ns()), 0.0))
            if monotonic_ns() - due > 10 * PERIOD:
                self.began += monotonic_ns() - due
            self.tick()

    def tick(self) -> None:
        measured = plant.sense(self.rig, self.state)
        seq = self.state.sim.tick
        tick = Tick(time_ns() if self.clock is None else seq * PERIOD, seq)
        if self.clock is not None:
            self.clock.publish(Clock(clock=to_stamp(tick.stamp)))
        self.forces[tick.seq] = measured.force
        if not self.blind:
            self.acceleration.publish(ros_msgs.acceleration(tick, measured))
        self.deflection.publish(ros_msgs.deflection(tick, measured))
        self.state, applied = plant.decide(self.rig, self.state)
        self.applied.publish(ros_msgs.applied(tick, applied))
        self.state = plant.advance(self.rig, self.state)


@pytest.fixture
def stack(monkeypatch: pytest.MonkeyPatch, pace: float) -> Iterator[tuple[Stack, dict[str, str]]]:
    with own_domain() as env:
        for key in ("ROS_DOMAIN_ID", "ROS_AUTOMATIC_DISCOVERY_RANGE"):
            monkeypatch.setitem(os.environ, key, env[key])
        context = rclpy.Context()
        context.init(args=[])
        node = rclpy.create_node("vehicle", context=context)
        try:
            yield Stack(node, pace), env
        finally:
            node.destroy_node()
            context.try_shutdown()


def wait_for(stack: Stack, what: Any, seconds: float = 40.0) -> None:
    """Drive until something holds."""
    until = monotonic() + seconds
    while not what():
        assert monotonic() < until
        stack.run(0.1)


def test_a_stack_integrates_one_corner(
    stack: tuple[Stack, dict[str, str]], tmp_path: Path
) -> None:
    car, env = stack
    heard = car.heard
    remap = ",".join(f"{old}={new}" for old, new in NAMES.items())
    with Graph(env, tmp_path) as graph:
        up = graph.start(
            "up",
            "hardware:=stack",
            f"namespace:={CORNER}",
            "observers:=unified",
            f"remap:={remap}",
            *paced(car.pace),
        )
        nominal = [0]

        def commanded() -> bool:
            nominal[0] = sum(m.source == m.SOURCE_NOMINAL for _, m in heard.commands)
            return nominal[0] > 100 and any(m.valid for _, m in heard.forces)

        wait_for(car, commanded)
        # all is well: commands answer samples, the force is that of the car; a busy machine may hold up one look
        for _ in range(3):
            car.run(2.0)
            recent = [m for _, m in heard.commands[-200:]]
            if {m.source for m in recent} == {PwmDuty.SOURCE_NOMINAL}:
                break
        assert {m.source for m in recent} == {PwmDuty.SOURCE_NOMINAL}
        assert {round(m.duty, 6) for m in recent} == {0.0, 0.3}
        good = [m for _, m in heard.forces[-300:] if m.valid and m.status == m.STATUS_OK]
        assert len(good) > 150
        errors = sorted(abs(m.force - car.forces[m.seq]) for m in good)
        assert errors[len(errors) // 2] < 0.6
        # the accelerometer is lost
        car.blind, lost = True, car.now()
        car.run(2.5)
        after = [(t, m) for t, m in heard.commands if t > lost + 0.25]
        assert after
        assert {m.source for _, m in after} == {PwmDuty.SOURCE_SAFE}
        assert {m.duty for _, m in after} == {0.1}
        first = next(t for t, m in heard.commands if t > lost and m.source == m.SOURCE_SAFE)
        # 50 ms of silence; a watch every 10 ms; the rest is the load of the machine
        assert first - lost < 0.25
        assert car.state.gate.duty == 0.1
        assert not heard.forces[-1][1].valid
        bad = [
            s for t, s in heard.diagnostics if t > lost + 0.2 and s.level == DiagnosticStatus.ERROR
        ]
        states = [s for s in bad if s.name == f"{CORNER}/skyhook_controller: state"]
        assert "no usable sample" in states[0].message
        assert states[0].hardware_id == f"/{CORNER}"
        rates = [
            s.message for t, s in heard.diagnostics
            if t > lost + 1.1 and s.name.endswith("input rate") and s.level > DiagnosticStatus.OK
        ]  # fmt: skip
        assert any(NAMES["sensors/acceleration"] in words for words in rates), rates
        assert heard.status[-1][1].status == NodeStatus.STATUS_LOST
        # and comes back
        car.blind, back = False, car.now()
        car.run(1.5)
        resumed = [(t, m) for t, m in heard.commands if t > back + 0.25]
        assert sum(m.source == m.SOURCE_NOMINAL for _, m in resumed) > 0.9 * len(resumed) > 100
        assert heard.forces[-1][1].valid
        assert up.stop() == 0, up.text
        until = monotonic() + 2.0
        while heard.commands[-1][1].source != PwmDuty.SOURCE_SAFE and monotonic() < until:
            car.executor.spin_once(timeout_sec=0.05)
            sleep(0.0)
    assert heard.commands[-1][1].source == PwmDuty.SOURCE_SAFE
    assert "Traceback" not in up.text
