"""What the bridge node says of itself and in which order it speaks, without a graph."""

from __future__ import annotations

from threading import Lock
from types import SimpleNamespace
from typing import Any

import pytest

pytest.importorskip("rclpy")

from er_plant_sim.duty_gate import Applied, Gate, GateState, Reason
from er_plant_sim.hardware import bridge, parser
from er_plant_sim.hardware.bridge import BridgeState, Reading
from er_plant_sim.hardware.calibration import Calibration, Quality, Value
from er_plant_sim.hardware.frame import Hello
from er_plant_sim.hardware.parser import ParserState
from er_plant_sim.nodes import hardware_bridge as module
from er_plant_sim.nodes.hardware_bridge import BridgeNode
from er_plant_sim.nodes.plant import PlantNode
from er_plant_sim.ros_commands import Commands
from er_ros_common.builders import Tick
from er_ros_common.health import Meter, Report

from er_damper_msgs.msg import NodeStatus, PwmDuty
from er_plant_sim import ros_hardware

BRIDGE = bridge.Bridge(
    Calibration("rig", ()), Gate(0.0, 0.3, 0.1, 0.05), 5_000_000, 0.05, ros_hardware.SOURCES
)
HELLO = Hello(1, 5_000_000, 63, 1, 50_000, 5_000)
ALIGNED = BridgeState(hello=HELLO, clock=bridge.ClockState(p_oo=1e-12, exchanges=9))
RUNNING = ALIGNED._replace(begun=True, seq=7)

QUIET = RUNNING._replace(silent=True, asked_at=9_000_000_000)
"""No sample was given on, and the device has not told its time for 9 s."""


def said(state: BridgeState = RUNNING, **changes: Any) -> Report:
    """What a node says in this state of the bridge; changes: of the node."""
    node: Any = SimpleNamespace(
        state=state,
        bridge=BRIDGE,
        wire=SimpleNamespace(trouble="", dead=False),
        p=SimpleNamespace(silence=0.05),
        reading=None,
        gathering=SimpleNamespace(missing=list),
        port=SimpleNamespace(in_force=""),
        commands=Commands(),
        _values=dict,
    )
    vars(node).update(changes)
    return BridgeNode.report(node)


def test_a_wire_that_nobody_reads_is_a_fault_whatever_else_is_well() -> None:
    assert said().status == NodeStatus.STATUS_OK
    wire = SimpleNamespace(trouble="ValueError: 12345", dead=True)
    for state in (RUNNING, ALIGNED):
        told = said(state, wire=wire)
        assert (told.mode, told.status) == ("broken", NodeStatus.STATUS_FAULT)
        assert "ValueError: 12345" in told.reason


def reading(**changes: Any) -> Reading:
    """A good one, or not."""
    applied = Applied(0.2, 6, 2, False, Reason.COMMAND)
    return Reading(7, 0, (), applied, False)._replace(**changes)


@pytest.mark.parametrize(
    ("state", "changes", "mode", "valid"),
    [
        (RUNNING, {}, "running", True),
        (RUNNING, {"reading": reading()}, "running", True),
        (RUNNING, {"port": SimpleNamespace(in_force="noise")}, "running", True),
        (RUNNING, {"reading": reading(applied=Applied(0.1, 0, 4, False, Reason.OLD_COMMAND))}, "safe", True),
        (RUNNING, {"reading": reading(ill=True)}, "ill", False),
        (RUNNING._replace(silent=True), {"reading": reading()}, "silent", False),
        (QUIET._replace(heard_at=1_000_000_000), {}, "silent", False),
        (QUIET._replace(heard_at=8_990_000_000), {}, "refused", False),
        (RUNNING._replace(hello=None), {}, "refused", False),
        (RUNNING, {"wire": SimpleNamespace(trouble="gone", dead=False)}, "refused", False),
        (ALIGNED, {}, "waiting", False),
    ],
)  # fmt: skip
def test_the_status_is_valid_while_what_is_published_is(
    state: BridgeState, changes: dict[str, Any], mode: str, valid: bool
) -> None:
    told = said(state, **changes)
    assert (told.mode, told.valid) == (mode, valid)


@pytest.mark.parametrize("running", [False, True])
def test_the_plants_status_is_valid_once_it_runs(running: bool) -> None:
    node: Any = SimpleNamespace(
        running=running,
        applied=None,
        outside=0,
        gathering=SimpleNamespace(missing=list),
        port=SimpleNamespace(in_force=""),
        state=SimpleNamespace(gate=GateState(0.1, 0.0)),
        drive=SimpleNamespace(timeouts=0),
        pace=SimpleNamespace(progress=SimpleNamespace(skipped=0), clock_steps=0),
        commands=Commands(),
    )
    assert PlantNode.report(node).valid is running


def test_of_a_rig_that_is_silent_nothing_is_valid_nor_the_duty_stated() -> None:
    for message in ros_hardware.lost(Tick(5_000_000, 1)):
        assert (message.status, message.valid) == (message.STATUS_LOST, False)
    assert (message.duty, message.command_seq) == (0.0, 0)
    assert message.source == message.SOURCE_UNKNOWN


def test_what_the_device_says_of_its_watchdog_is_shown() -> None:
    node: Any = SimpleNamespace(
        state=RUNNING,
        reading=None,
        wire=SimpleNamespace(opens=1, failed=0),
        time=SimpleNamespace(steps=0),
        port=SimpleNamespace(in_force=""),
    )
    shown = BridgeNode._values(node)
    assert (shown["device watchdog [ms]"], shown["device safe duty"]) == ("50", "0.1000")
    node.state = BridgeState()
    assert BridgeNode._values(node)["device safe duty"] == ""


def test_frames_go_out_in_the_order_of_their_numbers(monkeypatch: pytest.MonkeyPatch) -> None:
    """A command is handed over while the wire's thread still publishes what it answered first."""
    written: list[int] = []

    def write(data: bytes) -> None:
        written.extend(each.seq for each in parser.step(ParserState(), data)[1])

    def published(_: object) -> None:
        node._passed_on = lambda *_: spoken(node)
        BridgeNode.hand_over(node, PwmDuty())

    def spoken(node: Any) -> bytes:
        node.state, said = bridge.on_time(BRIDGE, node.state, node.state.asked_at + 10**9)
        return said.data

    def answered(_: Any, state: BridgeState, *__: object, **___: object) -> Any:
        state, said = bridge.on_time(BRIDGE, state, state.asked_at + 10**9)
        return state, bridge.Said([reading(values=(Value(0.0, Quality.OK),) * 6)], said.data)

    node: Any = SimpleNamespace(
        state=ALIGNED,
        bridge=BRIDGE,
        lock=Lock(),
        p=SimpleNamespace(noise_force=0.0),
        time=SimpleNamespace(stamp=lambda steady: steady),
        wire=SimpleNamespace(write=write),
        out=SimpleNamespace(publish=published),
        health=SimpleNamespace(meter=Meter(1.0)),
    )
    monkeypatch.setattr(bridge, "on_bytes", answered)
    for _ in range(2):
        BridgeNode.on_wire(node, b"", 0, True)
        BridgeNode.on_idle(node, node.state.asked_at + 10**9)
    assert written == [1, 2, 3, 4, 5, 6]


def test_a_node_that_is_activated_again_goes_on_counting(monkeypatch: pytest.MonkeyPatch) -> None:
    wire = SimpleNamespace(start=lambda: None)
    monkeypatch.setattr(module, "Wire", lambda *_: wire)
    node: Any = SimpleNamespace(
        state=RUNNING._replace(sent=1000),
        bridge=BRIDGE,
        gathering=SimpleNamespace(begin=lambda: None),
        address=None,
        on_wire=None,
        on_idle=None,
        on_open=None,
    )
    BridgeNode.begin(node)
    assert (node.state.begun, node.state.hello, node.state.sent) == (False, None, 1000)
