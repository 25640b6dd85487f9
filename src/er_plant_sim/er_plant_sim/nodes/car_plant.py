"""The plant node of a whole car: four corners below one body, measured at every tick; see `er_plant_sim.car_rig`.

Each corner has the topics of the plant below its name (`front_left/sensors/acceleration`), so that observers and
controllers of a corner need no other word than their namespace.
"""

from __future__ import annotations

import math
import signal
import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from time import monotonic, perf_counter

from er_common.stamps import StampLimits
from er_common.topics import below
from er_models.car.body import CORNERS
from er_ros_common.builders import Tick
from er_ros_common.clock import until_next
from er_ros_common.health import Report
from er_ros_common.help import Card
from er_ros_common.managed import ManagedNode
from er_ros_common.parameters import declare
from er_ros_common.spin import Executable, run
from geometry_msgs.msg import AccelStamped

from er_common import topics
from er_damper_msgs.msg import NodeStatus, PwmDuty
from er_plant_sim import car_rig, ros_commands
from er_plant_sim.car_settings import CarParameters
from er_plant_sim.duty_gate import Applied, Reason
from er_plant_sim.nodes.car_outlet import CarOutlet
from er_plant_sim.nodes.drive import Timed
from er_plant_sim.nodes.pace import Pace
from er_plant_sim.programs import CAR
from er_plant_sim.rig_parameters import tuned
from er_plant_sim.ros_commands import Commands
from er_ros_common import log

CONFLICT = 0.1
"""Share of samples answered more than once that shows two controllers at work."""
CARD = Card(
    CAR,
    CarParameters,
    subscribes=(*(below(topics.PWM_COMMAND, name) for name in CORNERS), topics.BODY_LOAD),
    publishes=(
        *(below(topic, name) for name in CORNERS for topic in topics.SENSORS),
        topics.BODY_ACCELERATION,
        topics.CLOCK,
        topics.STATUS,
        topics.DIAGNOSTICS,
    ),
)


class CarPlantNode(ManagedNode):
    """Runs the car; duties come from the program or from each corner's pwm/command."""

    def __init__(self, argv: Sequence[str] | None = None) -> None:
        super().__init__(CAR.name, argv)
        self.p: CarParameters = declare(self, CarParameters, self.changed)

    def configure(self) -> None:
        """Load the models and make the ends; the car stands at the beginning of its road."""
        p = self.p
        self.rig = car_rig.build(p)
        self.state = car_rig.start(self.rig)
        self.tick, self.running, self.over = Tick(0, 0), False, False
        self.commands = [Commands() for _ in CORNERS]
        self.repeated, self.conflicts = [0] * len(CORNERS), (False,) * len(CORNERS)
        self.applied: tuple[Applied, ...] = ()
        self.load, self.loaded_at = (0.0, 0.0), -math.inf
        self.limits = self.stamp_limits()
        self.out = CarOutlet(
            self, force_sd=p.noise_force, clocked=p.mode == "sim_time", frame=p.frame_id
        )
        if not self.rig.programmed:
            for place, name in enumerate(CORNERS):
                self.subscribe(below(topics.PWM_COMMAND, name), self._hears(place))
        load = topics.BODY_LOAD
        self.listen(load.name, load.type, self.on_load, load.subscriber)
        self.health.model_id = self.rig.car.corners[0].digest()
        self.health.meter.deadline = self.rig.dt
        self.timer = self.every(self.rig.dt / p.rate_factor, self.on_time)
        self.every(1.0, self.on_second)

    def tune(self, p: CarParameters) -> None:
        """Go on with other limits of the duties."""
        self.rig = replace(self.rig, gates=tuple(tuned(p, limits) for limits in self.rig.gates))
        self.limits = StampLimits(stale=p.command_timeout)
        for each in self.incoming.values():
            each.limits = self.limits

    def stamp_limits(self) -> StampLimits:
        """A command is good for as long as it is held."""
        return StampLimits(stale=self.p.command_timeout)

    def stamp_clock(self) -> int | None:
        """The clock of the samples; before the first of them there is none."""
        return self.pace.now(self.tick.seq) if self.running else None

    def begin(self) -> None:
        """Go on from where the car is."""
        self.running, self.over = False, False
        gates = tuple(g._replace(command=None, answered=0, ahead=0) for g in self.state.gates)
        self.state = self.state._replace(gates=gates)
        self.pace = Pace(self.rig.dt, self.p.rate_factor, real=self.p.mode == "realtime")
        self.drive = Timed(self.pace, self.sense, self.act, self.pass_on)

    def on_time(self) -> None:
        """Run what is due."""
        if self.over:
            return
        if not self.running:
            self.running = True
            period = self.pace.schedule.period
            self.pace.restart(max(period - until_next(self.timer), 0) % period)
        self.drive.on_time()

    def sense(self, place: int) -> int:
        """Publish this tick's measurements; returns its seq."""
        self.began = perf_counter()
        self.tick = Tick(self.pace.stamp(place, self.state.tick), self.state.tick)
        self.out.send(self.tick, car_rig.sense(self.rig, self.state), self.state)
        return self.state.tick

    def act(self) -> bool:
        """Publish the duties of this tick and go on to the next; false after the last."""
        self.state, self.applied = car_rig.decide(self.rig, self.state, self.conflicts)
        self.out.send_applied(self.tick, self.applied)
        fresh = monotonic() - self.loaded_at < self.p.load_timeout
        self.state = car_rig.advance(self.rig, self.state, *(self.load if fresh else (0.0, 0.0)))
        self.health.meter.step(perf_counter() - self.began, outputs=len(CORNERS))
        if car_rig.finished(self.rig, self.state):
            log.info(self, f"finished after {self.tick.seq} ticks")
            self.over = True
            signal.raise_signal(signal.SIGINT)
        return not self.over

    def on_load(self, message: AccelStamped) -> None:
        """Take the acceleration of the car by driver and tyres: braking and cornering."""
        load = message.accel.linear.x, message.accel.linear.y
        if all(map(math.isfinite, load)):
            self.load, self.loaded_at = load, monotonic()

    def _hears(self, place: int) -> Callable[[PwmDuty], None]:
        return lambda message: self.take(place, message)

    def take(self, place: int, message: PwmDuty) -> None:
        """Take a command of a corner that answers a sample of late."""
        if not self.running:
            return
        now, counted = self.pace.now(self.tick.seq), self.commands[place]
        counted, answer = ros_commands.judged(self.limits, counted, message, self.tick, now)
        if answer is not None:
            command = ros_commands.command(message, answer, self.tick, self.rig.dt)
            before = self.state.gates[place].refused
            self.state = car_rig.receive(
                self.rig, self.state, place, command, valid=bool(message.valid)
            )
            refused = self.state.gates[place].refused > before
            counted = ros_commands.passed_on(counted, message, answer.seq, refused=refused)
        self.commands[place] = counted

    def on_second(self) -> None:
        """Whether two controllers answer for a corner, and whether the system clock was set."""
        found = []
        for place, (held, name) in enumerate(zip(self.state.gates, CORNERS)):
            several = self.count_publishers(below(topics.PWM_COMMAND, name).name) > 1
            often = (
                held.repeated - self.repeated[place] > CONFLICT * self.p.rate * self.p.rate_factor
            )
            found.append(several and often)
            self.repeated[place] = held.repeated
        self.conflicts = tuple(found)
        self.pace.follow_clock()

    def report(self) -> Report:
        """Health of the plant: the first corner in trouble is named."""
        mode, status, reason = "running", NodeStatus.STATUS_OK, ""
        if not self.running:
            mode, status, reason = "waiting", NodeStatus.STATUS_INITIALIZING, "for its first tick"
        for name, duty in zip(CORNERS, self.applied):
            if duty.reason not in (Reason.COMMAND, Reason.PROGRAM) and not reason:
                mode, status = "safe", NodeStatus.STATUS_DEGRADED
                reason = f"safe duty at {name}: {duty.reason.value}"
        values = {
            f"{name} {what}": count
            for name, held in zip(CORNERS, self.state.gates)
            for what, count in (("duty", f"{held.duty:.4f}"), ("commands refused", held.refused))
        }
        invalid = sum(counted.invalid for counted in self.commands)
        return Report(mode, status, reason, invalid=invalid, valid=self.running, values=values)


NODE = Executable(CarPlantNode, CARD)


def main() -> None:
    """Entry point of the executable."""
    sys.exit(run(CarPlantNode, CARD))


if __name__ == "__main__":
    main()
