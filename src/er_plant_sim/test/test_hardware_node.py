"""What the bridge node says of itself and in which order it speaks, without a graph."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

pytest.importorskip("rclpy")

from er_plant_sim.hardware import bridge
from er_plant_sim.hardware.bridge import BridgeState
from er_plant_sim.hardware.frame import Hello
from er_plant_sim.nodes.hardware_bridge import BridgeNode
from er_plant_sim.ros_commands import Commands
from er_ros_common.health import Report

from er_damper_msgs.msg import NodeStatus

HELLO = Hello(1, 5_000_000, 63, 1, 50_000, 5_000)
ALIGNED = BridgeState(hello=HELLO, clock=bridge.ClockState(p_oo=1e-12, exchanges=9))
RUNNING = ALIGNED._replace(begun=True, seq=7)


def said(state: BridgeState = RUNNING, **changes: Any) -> Report:
    """What a node says in this state of the bridge; changes: of the node."""
    node: Any = SimpleNamespace(
        state=state,
        bridge=SimpleNamespace(period=HELLO.period, certain=1e-3, road=None),
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
