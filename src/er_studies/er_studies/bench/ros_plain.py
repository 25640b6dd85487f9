"""A node of plain rclpy with the ends of the monitor, which computes nothing: what the middleware alone costs."""

from __future__ import annotations

import sys
from collections.abc import Callable
from typing import Any

import rclpy
from er_common.topics import ACCELERATION, DEFLECTION, FORCE, PWM_APPLIED
from er_ros_common.spin import guarded, spin
from er_ros_common.stopping import Stopped
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions

from er_common import quality
from er_ros_common import builders, qos

HEARD = (ACCELERATION, DEFLECTION, PWM_APPLIED, FORCE)


def node() -> Node:
    """Four subscriptions at the rate of the samples; each force is answered by two messages."""
    made = Node("plain", enable_rosout=False)
    out = [
        made.create_publisher(FORCE.type, f"plain/{name}", qos.profile(FORCE.publisher))
        for name in ("force", "residual")
    ]

    def answer(message: Any) -> None:
        for end in out:
            end.publish(builders.damper_force(builders.tick_of(message), 0.0))

    for topic in HEARD:
        heard: Callable[[Any], None] = answer if topic is FORCE else _nothing
        made.create_subscription(topic.type, topic.name, heard, qos.profile(quality.FOLLOWER))
    return made


def _nothing(_: Any) -> None:
    """As the monitor does until a tick is whole."""


def live(stopped: Stopped) -> None:
    """Until a signal comes."""
    rclpy.init(args=[], signal_handler_options=SignalHandlerOptions.NO)
    spin(node(), stopped)


if __name__ == "__main__":
    sys.exit(guarded("plain", [], live))
