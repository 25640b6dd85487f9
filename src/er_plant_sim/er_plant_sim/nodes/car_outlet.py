"""Everything the plant of a car publishes: the topics of each corner below its name, and the body's motion."""

from __future__ import annotations

from typing import Any

from er_common.topics import below
from er_models.car.body import CORNERS
from er_ros_common.builders import Tick
from er_ros_common.clock import to_stamp
from er_ros_common.managed import ManagedNode
from geometry_msgs.msg import AccelStamped
from rclpy.publisher import Publisher
from rosgraph_msgs.msg import Clock

from er_common import topics
from er_plant_sim import ros_msgs
from er_plant_sim.car_rig import CarState
from er_plant_sim.duty_gate import Applied
from er_plant_sim.simulator import Measurement


class CarOutlet:
    """Publishers of measurements and applied duty of each corner, of the body, and of /clock in simulated time."""

    def __init__(self, node: ManagedNode, *, force_sd: float, clocked: bool, frame: str) -> None:
        self.force_sd, self.frame = force_sd, frame
        self.corners = [
            [node.advertise(below(t, name)) for t in topics.SENSORS] for name in CORNERS
        ]
        self.body = node.advertise(topics.BODY_ACCELERATION)
        self.clock = node.advertise(topics.CLOCK) if clocked else None

    def send(self, tick: Tick, measured: tuple[Measurement, ...], state: CarState) -> None:
        """Publish one tick's measurements, simulated time first."""
        if self.clock is not None:
            self.clock.publish(Clock(clock=to_stamp(tick.stamp)))
        for (acceleration, deflection, force, road, _), m in zip(self.corners, measured):
            self._send(acceleration, ros_msgs.acceleration(tick, m))
            self._send(deflection, ros_msgs.deflection(tick, m))
            self._send(force, ros_msgs.force(tick, m, self.force_sd))
            self._send(road, ros_msgs.road(tick, m))
        message = AccelStamped()
        message.header.stamp = to_stamp(tick.stamp)
        message.header.frame_id = "base_link"
        heave, roll, pitch = state.output.body.tolist()
        message.accel.linear.z, message.accel.angular.x, message.accel.angular.y = (
            heave,
            roll,
            pitch,
        )
        self.body.publish(message)

    def send_applied(self, tick: Tick, duties: tuple[Applied, ...]) -> None:
        """Publish the duties in force from this tick on."""
        for (*_, applied), duty in zip(self.corners, duties):
            self._send(applied, ros_msgs.applied(tick, duty))

    def _send(self, publisher: Publisher, message: Any) -> None:
        message.header.frame_id = self.frame
        publisher.publish(message)
