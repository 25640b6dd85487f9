"""The plant node: a quarter car on a road, measured at every tick; see `er_plant_sim.rig`.

Three modes. realtime: an absolute schedule on the steady clock, stamps of the system clock.
sim_time: the same schedule, slower or faster, and the plant drives /clock. lockstep: a tick waits
for the command that answers its sample, so that a run repeats exactly however fast the machine is.
"""

from __future__ import annotations

import math
import signal
import sys
from collections.abc import Sequence
from dataclasses import replace
from functools import cached_property
from time import monotonic, perf_counter

from er_common.stamps import StampLimits
from er_ros_common.builders import Tick
from er_ros_common.clock import until_next
from er_ros_common.fault_port import FaultPort
from er_ros_common.health import Report
from er_ros_common.managed import ManagedNode
from er_ros_common.parameters import declare
from er_ros_common.private import overrides
from er_ros_common.spin import Executable, run

from er_common import topics
from er_damper_msgs.msg import NodeStatus, PwmDuty
from er_plant_sim import rig as plant
from er_plant_sim import ros_commands
from er_plant_sim.build import build, with_damper, with_planned
from er_plant_sim.duty_gate import Applied, Reason
from er_plant_sim.loop_times import WARM_UP, LoopTimes
from er_plant_sim.nodes.card import CARD
from er_plant_sim.nodes.drive import Lockstep, Timed
from er_plant_sim.nodes.outlet import Outlet, spoilable
from er_plant_sim.nodes.pace import Pace
from er_plant_sim.nodes.recording import Recording
from er_plant_sim.nodes.roll_call import Gathering
from er_plant_sim.programs import PLANT
from er_plant_sim.rig_parameters import tuned
from er_plant_sim.ros_commands import Commands
from er_plant_sim.settings import PlantParameters, table
from er_ros_common import log

WAKE_PERIOD = 0.01
"""Period of the timer where commands, not time, set the pace [s]."""


LIMITED = 5
"""Duties a second outside the limits that are worth a warning."""
CONFLICT = 0.1
"""Share of samples answered more than once that shows two controllers at work."""


class PlantNode(ManagedNode):
    """Runs the rig; duties come from the program or from pwm/command."""

    def __init__(self, argv: Sequence[str] | None = None) -> None:
        super().__init__(PLANT.name, argv)
        self.p: PlantParameters = declare(self, table(overrides(self)), self.changed)

    def configure(self) -> None:
        """Load the models and make the ends; the car stands at the beginning of its road."""
        p = self.p
        self.rig = build(p)
        self.state = plant.start(self.rig)
        self.tick = Tick(0, 0)
        self.running, self.commands = False, Commands()
        self.limits = self.stamp_limits()
        self.applied: Applied | None = None
        self.repeated, self.conflict = 0, False
        self.limited, self.outside = 0, 0
        self.sensing = 0.0
        clock_rate = p.rate * p.rate_factor if p.mode == "sim_time" else 0.0
        self.port = FaultPort(
            self,
            spoilable(programmed=self.rig.programmed),
            enabled=p.enable_fault_injection,
            seed=max(p.seed, 0),
            rate=p.rate * p.rate_factor or math.inf,
        )
        self.out = Outlet(
            self, self.port, force_sd=p.noise_force, clock_rate=clock_rate, frame=p.frame_id
        )
        self.recording = Recording(self, p.recorder, p.recorded, p.rate, self.on_recorded)
        self.gathering = Gathering(
            self,
            self.out,
            p.wait_for,
            p.wait_for_nodes,
            p.start_timeout,
            lambda: self.recording.known,
        )
        if not self.rig.programmed:
            self.subscribe(topics.PWM_COMMAND, self.on_command)
        self.health.model_id = self.rig.sim.plant.model.digest()
        self.health.meter.deadline = self.rig.dt
        period = self.rig.dt / p.rate_factor if p.rate_factor else WAKE_PERIOD
        self.timer = self.every(period, self.on_time)
        self.every(1.0, self.on_second)

    def tune(self, p: PlantParameters) -> None:
        """Go on with other limits of the duty, with another damper, or a planned run from the next sample on."""
        rig, state, said = self.rig, self.state, []
        number = state.sim.tick + 1
        if p.damper_file != self.p.damper_file:
            rig, state = with_damper(p, rig, state)
            said.append(f"damper: {p.damper_file or p.model_file} from sample {number} on")
        if p.planned_file != self.p.planned_file:
            rig = with_planned(p, rig, number)
            said.append(f"planned run: {p.planned_file or 'ends'} from sample {number} on")
        self.rig, self.state = replace(rig, gate=tuned(p, rig.gate)), state
        self.health.model_id = rig.sim.plant.model.digest()
        for line in said:
            log.info(self, line)
        self.limits = StampLimits(stale=p.command_timeout)
        for each in self.incoming.values():
            each.limits = self.limits

    @cached_property
    def aged(self) -> bool:
        """Whether the age of a command means anything."""
        return bool(self.p.mode == "realtime")

    def stamp_limits(self) -> StampLimits:
        """A command is good for as long as it is held."""
        return StampLimits(stale=self.p.command_timeout)

    def stamp_clock(self) -> int | None:
        """The clock of the samples, in every mode; before the first of them there is none."""
        return self.pace.now(self.tick.seq) if self.running else None

    def begin(self) -> None:
        """Wait for everybody, then go on from where the car is."""
        self.running, self.over = False, False
        self.state = plant.resumed(self.state)
        self.gathering.begin()
        self.recording.begin(self.state.sim.tick - 1)
        self.pace = Pace(self.rig.dt, self.p.rate_factor or 1.0, real=self.p.mode == "realtime")
        self.drive = self._drive()
        self.loop = LoopTimes(self.state.sim.tick + round(WARM_UP * self.p.rate))

    def _drive(self) -> Timed | Lockstep:
        if self.p.mode != "lockstep":
            return Timed(self.pace, self.sense, self.act, self.pass_on)
        return Lockstep(
            self.pace,
            self.sense,
            self.act,
            self.pass_on,
            lambda: self.recording.follows(self.state.sim.tick),
            paced=self.p.rate_factor > 0.0,
            answered=not self.rig.programmed,
            hopeless=lambda: bool(self.port.in_force),
        )

    def on_time(self) -> None:
        """Begin once everybody is there, then run what is due."""
        if self.over:
            self._leave()
        elif self.running:
            self.drive.on_time()
        elif self.gathering.complete():
            self.running = True
            period = self.pace.schedule.period
            self.pace.restart(max(period - until_next(self.timer), 0) % period)
            # a pause came before the answer: a sample is sent once only
            sent = self.tick.seq == self.state.sim.tick
            if not sent or self.act():
                self.drive.on_time()

    def sense(self, place: int) -> int:
        """Publish this tick's measurement; returns its seq."""
        began = perf_counter()
        number = self.state.sim.tick
        self.tick = Tick(self.pace.stamp(place, number), number)
        self.loop.sensed(number, monotonic(), self.pace.late(place))
        self.out.send(self.tick, plant.sense(self.rig, self.state))
        self.sensing = perf_counter() - began
        return number

    def act(self) -> bool:
        """Publish the duty of this tick and go on to the next; false after the last."""
        began = perf_counter()
        self.state, self.applied = plant.decide(self.rig, self.state, conflict=self.conflict)
        self.out.send_applied(self.tick, self.applied)
        self.state = plant.advance(self.rig, self.state)
        # without the time between both: in lockstep the answer is waited for
        self.health.meter.step(self.sensing + perf_counter() - began)
        if plant.finished(self.rig, self.state):
            self._finish()
        return not self.over

    def _finish(self) -> None:
        """Say so, and end once everything is recorded."""
        log.info(self, f"finished after {self.tick.seq} ticks")
        if self.loop.latency.total:
            log.info(self, self.loop.words())
        self.over = True
        self._leave()

    def _leave(self) -> None:
        """End the node as Ctrl-C would: an exception would end it with a traceback."""
        if self.recording.follows(self.tick.seq, ahead=0):
            signal.raise_signal(signal.SIGINT)

    def on_recorded(self) -> None:
        """Go on where the recording was waited for."""
        if self.over:
            self._leave()
        elif self.running and self.active:
            self.drive.on_recorded()

    def on_command(self, message: PwmDuty) -> None:
        """Take a command, or what an injected fault leaves of it."""
        for each in self.port.taken(topics.PWM_COMMAND, message):
            self.take(each)

    def take(self, message: PwmDuty) -> None:
        """Take a command that answers a sample of late; in lockstep it is what the next tick waits for."""
        if not self.running:
            return  # there was no sample yet
        seq, now = int(message.seq), self.pace.now(self.tick.seq)
        self.commands, answer = ros_commands.judged(
            self.limits, self.commands, message, self.tick, now
        )
        if answer is not None:
            seq = answer.seq
            self.loop.answered(seq, monotonic())
            command = ros_commands.command(message, answer, self.tick, self.rig.dt)
            before = self.state.gate.refused
            self.state = plant.receive(self.rig, self.state, command, valid=bool(message.valid))
            refused = self.state.gate.refused > before
            self.commands = ros_commands.passed_on(self.commands, message, seq, refused=refused)
        if not self.over:
            self.drive.on_command(seq)

    def on_second(self) -> None:
        """Whether two controllers answer, and whether the system clock was set."""
        repeated, self.repeated = (
            self.state.gate.repeated - self.repeated,
            self.state.gate.repeated,
        )
        # a controller that was killed stays listed for 20 s: only two that answer are a conflict
        several = self.count_publishers(topics.PWM_COMMAND.name) > 1
        self.conflict = several and repeated > CONFLICT * self.p.rate * self.p.rate_factor
        self.outside = self._often_limited()
        self.pace.follow_clock()

    def _often_limited(self) -> int:
        """Duties of the last second that were outside the limits; 0 where they are few."""
        limited, self.limited = self.state.gate.limited - self.limited, self.state.gate.limited
        # where the slew is limited every change may be
        return limited if limited > LIMITED and not self.p.duty_slew else 0

    def report(self) -> Report:
        """Health of the plant."""
        mode, status, reason = "running", NodeStatus.STATUS_OK, ""
        if not self.running:
            mode, status = "waiting", NodeStatus.STATUS_INITIALIZING
            reason = f"for {', '.join(self.gathering.missing()) or 'its subscribers'}"
        elif self.applied and self.applied.reason not in (Reason.COMMAND, Reason.PROGRAM):
            mode, status = "safe", NodeStatus.STATUS_DEGRADED
            reason = f"safe duty: {self.applied.reason.value}"
        elif self.outside:
            status = NodeStatus.STATUS_OUT_OF_RANGE
            reason = f"{self.outside} duties of the last second were out of range: see the controller's limits"
        if self.port.in_force and status == NodeStatus.STATUS_OK:
            status, reason = NodeStatus.STATUS_DEGRADED, f"injected: {self.port.in_force}"
        values = {
            "duty": f"{self.state.gate.duty:.4f}",
            "duties limited": self.state.gate.limited,
            "commands refused": self.state.gate.refused,
            "answers missed": self.drive.timeouts,
            "ticks given up": self.pace.progress.skipped,
            "clock steps": self.pace.clock_steps,
            "injected": self.port.in_force,
        }
        stamps, invalid = self.commands
        return Report(
            mode, status, reason, stamps, invalid=invalid, valid=self.running, values=values
        )

    def end(self) -> None:
        """Let subscribers take the last messages."""
        self.out.flush()


NODE = Executable(PlantNode, CARD)


def main() -> None:
    """Entry point of the executable."""
    sys.exit(run(PlantNode, CARD))


if __name__ == "__main__":
    main()
