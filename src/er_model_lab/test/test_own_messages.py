"""What the recorder sends itself is told from what others say on the same topics."""

from __future__ import annotations

from typing import Any

import pytest

pytest.importorskip("rclpy")

from diagnostic_msgs.msg import DiagnosticArray, DiagnosticStatus
from er_model_lab.nodes.own_messages import own
from rcl_interfaces.msg import Log, ParameterEvent
from rclpy.serialization import serialize_message
from std_msgs.msg import String


class Recorder:
    """All that is asked of a node."""

    def get_fully_qualified_name(self) -> str:
        return "/c/recorder"


def diagnostics(*names: str) -> DiagnosticArray:
    return DiagnosticArray(status=[DiagnosticStatus(name=name) for name in names])


@pytest.mark.parametrize(
    ("name", "message", "is_own"),
    [
        ("/c/recorder/status", String(), True),
        ("/c/recorder_2/status", String(), False),
        ("/diagnostics", diagnostics("c/recorder: state", "c/recorder: graph"), True),
        ("/diagnostics", diagnostics("/c/recorder: state"), True),
        ("/diagnostics", diagnostics("/c/recorder: state", "/c/plant: state"), False),
        ("/diagnostics", diagnostics("battery"), False),
        ("/rosout", Log(name="c.recorder"), True),
        ("/rosout", Log(name="plant"), False),
        ("/parameter_events", ParameterEvent(node="/c/recorder"), True),
        ("/parameter_events", ParameterEvent(node="/c/plant"), False),
        ("/c/sensors/force", String(), False),
    ],
)
def test_a_message_is_the_recorders_own_or_not(name: str, message: Any, is_own: bool) -> None:
    kind = type(message)
    package = kind.__module__.partition(".")[0]
    tell = own(Recorder(), name, f"{package}/msg/{kind.__name__}")
    assert tell(serialize_message(message)) is is_own
