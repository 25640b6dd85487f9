"""Everything the plant of a car publishes: the topics of each corner below its name, and the body's motion."""

from __future__ import annotations

from er_common.topics import below
from er_models.car.body import CORNERS
from er_ros_common.builders import Tick
from er_ros_common.clock import to_stamp
from er_ros_common.managed import ManagedNode
from geometry_msgs.msg import AccelStamped
from rosgraph_msgs.msg import Clock

from er_common import topics
from er_plant_sim import ros_msgs
from er_plant_sim.car_rig import CarState
from er_plant_sim.duty_gate import Applied
from er_plant_sim.simulator import Measurement


class CarOutlet:
    """Publishers of measurements and applied duty of each corner, of the body, and of /clock in simulated time."""

    def __init__(self, node: ManagedNode, *, force_sd: float, clocked: bool) -> None:
        self.force_sd = force_sd
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
            acceleration.publish(ros_msgs.acceleration(tick, m))
            deflection.publish(ros_msgs.deflection(tick, m))
            force.publish(ros_msgs.force(tick, m, self.force_sd))
            road.publish(ros_msgs.road(tick, m))
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
            applied.publish(ros_msgs.applied(tick, duty))
