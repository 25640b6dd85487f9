"""Everything the plant publishes at 200 Hz, made once."""

from __future__ import annotations

import math
from time import monotonic
from typing import Any

from er_common.topics import Topic
from er_ros_common.builders import Tick
from er_ros_common.clock import to_stamp
from er_ros_common.fault_port import FaultPort
from er_ros_common.managed import ManagedNode
from rclpy.duration import Duration
from rclpy.publisher import Publisher
from rosgraph_msgs.msg import Clock

from er_common import topics
from er_plant_sim import ros_msgs
from er_plant_sim.duty_gate import Applied
from er_plant_sim.simulator import Measurement

CLOCK_RATE = 200.0
"""Most messages per second on /clock: more costs every listener dearly."""
TAKEN = 0.3
"""Time the subscribers get to take the last messages [s]; they acknowledge only now and then."""


def spoilable(*, programmed: bool) -> tuple[Topic, ...]:
    """Topics that an injected fault may spoil; where the duty is a program's nobody takes a command."""
    return topics.SENSORS if programmed else (*topics.SENSORS, topics.PWM_COMMAND)


class Outlet:
    """Publishers of the measurements, the applied duty and, in simulated time, of /clock."""

    def __init__(
        self,
        node: ManagedNode,
        port: FaultPort,
        *,
        force_sd: float,
        clock_rate: float,
        frame: str,
    ) -> None:
        made = node.advertise
        self.port, self.force_sd, self.frame = port, force_sd, frame
        self.acceleration, self.deflection = made(topics.ACCELERATION), made(topics.DEFLECTION)
        self.force, self.road = made(topics.FORCE), made(topics.ROAD)
        self.applied = made(topics.PWM_APPLIED)
        self.every = math.ceil(clock_rate / CLOCK_RATE)
        self.clock = made(topics.CLOCK) if clock_rate else None

    def send(self, tick: Tick, measured: Measurement) -> None:
        """Publish one tick's measurements, simulated time first."""
        if self.clock is not None and tick.seq % self.every == 0:
            self.clock.publish(Clock(clock=to_stamp(tick.stamp)))
        send = self._send
        send(self.acceleration, topics.ACCELERATION, ros_msgs.acceleration(tick, measured))
        send(self.deflection, topics.DEFLECTION, ros_msgs.deflection(tick, measured))
        send(self.force, topics.FORCE, ros_msgs.force(tick, measured, self.force_sd))
        send(self.road, topics.ROAD, ros_msgs.road(tick, measured))

    def send_applied(self, tick: Tick, duty: Applied) -> None:
        """Publish the duty in force from this tick on."""
        self._send(self.applied, topics.PWM_APPLIED, ros_msgs.applied(tick, duty))

    def publish(self, messages: tuple[Any, ...]) -> None:
        """Publish acceleration, deflection, force, road, applied duty of one tick."""
        for publisher, topic, message in zip(self._all(), topics.SENSORS, messages, strict=True):
            self._send(publisher, topic, message)

    def _send(self, publisher: Publisher, topic: topics.Topic, message: Any) -> None:
        message.header.frame_id = self.frame
        self.port.publish(publisher, topic, message)

    def subscribers(self) -> tuple[int, ...]:
        """Subscribers of acceleration, deflection, force, road, applied duty."""
        return tuple(publisher.get_subscription_count() for publisher in self._all())

    def _all(self) -> tuple[Publisher, ...]:
        return (self.acceleration, self.deflection, self.force, self.road, self.applied)

    def flush(self) -> None:
        """Wait until reliable subscribers have taken the last messages."""
        until = monotonic() + TAKEN
        for publisher in self._all():
            publisher.wait_for_all_acked(Duration(seconds=max(until - monotonic(), 0.0)))
