"""A node made of everything er_ros_common offers, started as a process by test_spin."""

from __future__ import annotations

import sys
import time
from dataclasses import dataclass

from er_common.program import Program
from er_models.errors import ErError
from er_ros_common.clock import now, wall_timer
from er_ros_common.help import Card
from er_ros_common.parameters import declare, param
from er_ros_common.spin import run
from rclpy.node import Node

from er_common import topics
from er_ros_common import builders, qos


@dataclass(frozen=True, kw_only=True)
class Parameters:
    """What the tests set."""

    rate: float = param(200.0, unit="Hz", low=1.0, high=2000.0, text="ticks per second")
    gain: float = param(1.0, low=0.0, high=10.0, text="a gain", dynamic=True)
    weights: tuple[float, ...] = param((), text="weights")
    fail_after: int = param(-1, text="ticks until an error; -1 never")
    idle: bool = param(False, text="have no timer")


class DemoNode(Node):
    """Publishes a duty at a rate, and says what happens to it on stdout."""

    def __init__(self) -> None:
        super().__init__("demo")
        self.parameters = declare(self, Parameters, self.on_change)
        self.ticks = 0
        self.publisher = self.create_publisher(
            topics.PWM_COMMAND.type,
            topics.PWM_COMMAND.name,
            qos.profile(topics.PWM_COMMAND.publisher),
        )
        if not self.parameters.idle:
            wall_timer(self, 1.0 / self.parameters.rate, self.tick)
        self.started = time.process_time()
        say(f"ready {self.parameters.rate:g}")

    def on_change(self, parameters: Parameters) -> None:
        """Show a changed gain."""
        say(f"gain {parameters.gain:g}")

    def tick(self) -> None:
        """One step."""
        self.ticks += 1
        if self.ticks == self.parameters.fail_after:
            raise ErError("the damper is on fire")
        self.publisher.publish(builders.pwm_duty(builders.Tick(now(self), self.ticks), 0.2))

    def on_stop(self) -> None:
        """A last message must still be possible."""
        self.publisher.publish(builders.pwm_duty(builders.Tick(now(self), self.ticks + 1), 0.0))
        say(f"stopped {self.ticks} {time.process_time() - self.started:.3f}")


def say(text: str) -> None:
    """One line on stdout, at once."""
    sys.stdout.write(text + "\n")
    sys.stdout.flush()


CARD = Card(
    Program("demo", "er_ros_common", "Publishes a constant duty."),
    Parameters,
    publishes=(topics.PWM_COMMAND,),
)

if __name__ == "__main__":
    sys.exit(run(DemoNode, CARD))
