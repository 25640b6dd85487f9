"""The bridge node: a real rig behind a wire looks like the plant; see `er_plant_sim.hardware.bridge`.

A thread of its own reads the wire and publishes, so that a sample waits for nobody; what it shares with
the callbacks is behind one lock, and what is said to the device is written under it: in the order of its numbers.
"""

from __future__ import annotations

import secrets
import signal
import sys
import threading
from collections.abc import Sequence
from dataclasses import replace
from time import monotonic_ns, perf_counter

from er_common.stamps import SECOND, StampLimits
from er_ros_common.builders import Tick
from er_ros_common.fault_port import FaultPort
from er_ros_common.health import Report
from er_ros_common.help import Card
from er_ros_common.managed import ManagedNode
from er_ros_common.parameters import declare
from er_ros_common.spin import Executable, run

from er_common import topics
from er_damper_msgs.msg import NodeStatus, PwmDuty
from er_plant_sim import ros_commands, ros_hardware
from er_plant_sim.duty_gate import Reason
from er_plant_sim.hardware import bridge, clocks, frame, key_file, seal
from er_plant_sim.hardware.bridge import Reading
from er_plant_sim.hardware.settings import BridgeParameters, build, signals, with_planned
from er_plant_sim.nodes.outlet import Outlet, spoilable
from er_plant_sim.nodes.roll_call import Gathering
from er_plant_sim.nodes.system_time import SystemTime
from er_plant_sim.nodes.wire import Wire
from er_plant_sim.programs import BRIDGE
from er_plant_sim.rig_parameters import tuned
from er_plant_sim.ros_commands import Commands
from er_ros_common import log

CONFLICT = 0.1
"""Share of samples answered more than once that shows two controllers at work."""
WATCH_PERIOD = 0.02
AHEAD = 0.5
"""How long after it was asked for a planned run begins [s]: it is looked at first, while the wire goes on."""


class BridgeNode(ManagedNode):
    """Publishes what the device measures and hands it the duty of pwm/command or of the program."""

    def __init__(self, argv: Sequence[str] | None = None) -> None:
        super().__init__(BRIDGE.name, argv)
        self.p: BridgeParameters = declare(self, BridgeParameters, self.changed)
        self.lock = threading.Lock()

    def configure(self) -> None:
        """Load the files and make the ends; the wire is opened when the node begins."""
        p, built = self.p, build(self.p, ros_hardware.SOURCES)
        self.drive, self.address = built.drive, built.address
        key, note = key_file.key_of(p.key_file, built.address.kind)
        if note:
            exposed = not key and built.address.kind == "udp"
            (log.warning if exposed else log.info)(self, note)
        self.bridge = replace(built.bridge, key=key)
        if p.planned_file:
            self._go_over(p, 0)
        self.state = bridge.start(self.bridge, monotonic_ns(), seed=secrets.token_bytes(seal.SEED))
        units = spoilable(programmed=p.duty_source == "program")
        self.port = FaultPort(self, units, enabled=p.enable_fault_injection, seed=0, rate=p.rate)
        self.out = Outlet(
            self, self.port, force_sd=p.noise_force, clock_rate=0.0, frame=p.frame_id
        )
        self.gathering = Gathering(self, self.out, p.wait_for, p.wait_for_nodes, p.start_timeout)
        if p.duty_source == "topic":
            self.subscribe(topics.PWM_COMMAND, self.on_command)
        self.commands = Commands()
        self.limits = self.stamp_limits()
        self.health.model_id = built.model_id
        self.health.meter.deadline = 1e-9 * self.bridge.period
        self.watch_every(WATCH_PERIOD, self.on_watch)
        self.every(1.0, self.on_second)

    def tune(self, p: BridgeParameters) -> None:
        """Go on with other limits of the duty and another patience; the wire's thread sees both at once."""
        changed = tuned(p, self.bridge.gate)
        if p.planned_file != self.p.planned_file:
            self._go_over(p, self.state.seq + round(AHEAD * p.rate))
        with self.lock:
            self.bridge = replace(self.bridge, gate=changed, silence=p.silence)
        self.limits = StampLimits(stale=p.command_timeout)
        for each in self.incoming.values():
            each.limits = self.limits

    def _go_over(self, p: BridgeParameters, seq: int) -> None:
        """Drive the planned run from a sample on, or end it there; on a device that moves its road itself its duty."""
        self.drive = with_planned(p, self.drive, seq)
        duty, road = signals(p, self.drive, seq)
        with self.lock:
            self.bridge = replace(self.bridge, duty=duty, road=road)
        log.info(self, f"planned run: {p.planned_file or 'ends'} from sample {seq} on")

    def stamp_limits(self) -> StampLimits:
        """A command is good for as long as it is held."""
        return StampLimits(stale=self.p.command_timeout)

    def stamp_clock(self) -> int | None:
        """The clock of the samples; before the first of them there is none."""
        return self.time.stamp(self.came.steady) if self.state.begun and self.state.seq else None

    def begin(self) -> None:
        """Open the wire, and wait for everybody; the device knows the numbers of before."""
        seed = secrets.token_bytes(seal.SEED)  # nonces of before are never used again
        self.state = bridge.start(self.bridge, monotonic_ns(), sent=self.state.sent, seed=seed)
        self.reading: Reading | None = None
        self.time = SystemTime()
        self.repeated, self.over = 0, False
        self.gathering.begin()
        self.wire = Wire(self.address, self.on_wire, self.on_idle, self.on_open)
        self.wire.start()

    def on_wire(self, data: bytes, now: int, datagram: bool) -> None:
        """Take bytes of the device; the wire's thread."""
        began = perf_counter()
        with self.lock:
            self.state, said = bridge.on_bytes(
                self.bridge, self.state, data, now, datagram=datagram
            )
            self.wire.write(said.data)
        for reading in said.readings:
            self.reading = reading
            tick = Tick(self.time.stamp(reading.stamp), reading.seq)
            self.out.publish(ros_hardware.messages(tick, reading, force_sd=self.p.noise_force))
            self.health.meter.step(perf_counter() - began)

    def on_idle(self, now: int) -> None:
        """Do what has to be done now and then; the wire's thread."""
        with self.lock:
            self.state, said = bridge.on_time(self.bridge, self.state, now)
            self.wire.write(said.data)
            last, seq = self.state.stamp, self.state.seq
        if said.silence:
            tick = Tick(self.time.stamp(last), seq)
            self.out.publish(ros_hardware.lost(tick))

    def on_open(self) -> None:
        """The wire was opened; the wire's thread."""
        with self.lock:
            self.state = bridge.reconnected(self.state)

    def on_command(self, message: PwmDuty) -> None:
        """Hand over a command, or what an injected fault leaves of it."""
        for each in self.port.taken(topics.PWM_COMMAND, message):
            self.hand_over(each)

    def hand_over(self, message: PwmDuty) -> None:
        """Hand a command that answers a sample of late to the device, within the limits."""
        with self.lock:
            self.wire.write(self._passed_on(message, monotonic_ns()))

    def _passed_on(self, message: PwmDuty, now: int) -> bytes:
        """What the device is told for a command; now: steady clock [ns]."""
        state = self.state
        if not (state.begun and state.seq):
            return b""  # there was no sample yet
        last = Tick(self.time.stamp(state.stamp), state.seq)
        self.commands, answer = ros_commands.judged(
            self.limits, self.commands, message, last, self.time.stamp(now)
        )
        if answer is None:
            return b""
        command = ros_commands.command(message, answer, last, self.bridge.period / SECOND)
        at = state.stamp - answer.behind
        self.state, data = bridge.on_command(
            self.bridge, state, command, now, valid=bool(message.valid), stamp=at
        )
        refused = self.state.gate.refused > state.gate.refused
        self.commands = ros_commands.passed_on(self.commands, message, answer.seq, refused=refused)
        return data

    def on_watch(self) -> None:
        """Follow a clock that was set; begin once everybody and the device are there; end with the program."""
        self.time.follow()
        if not self.state.begun:
            if not bridge.refusal(self.bridge, self.state) and self.gathering.complete():
                with self.lock:
                    self.state = bridge.begin(self.state)
        elif 0 < round(self.drive.duration * self.p.rate) <= self.state.seq and not self.over:
            self.over = True
            log.info(self, f"finished after {self.state.seq} ticks")
            signal.raise_signal(signal.SIGINT)

    def on_second(self) -> None:
        """Look at who commands."""
        repeated, self.repeated = (
            self.state.gate.repeated - self.repeated,
            self.state.gate.repeated,
        )
        # a controller that was killed stays listed for 20 s: only two that answer are a conflict
        several = self.count_publishers(topics.PWM_COMMAND.name) > 1
        conflict = several and repeated > CONFLICT * self.p.rate
        with self.lock:
            self.state = self.state._replace(conflict=conflict)

    def report(self) -> Report:
        """Health of bridge, wire and device."""
        s, mode, status, reason = self.state, "running", NodeStatus.STATUS_OK, ""
        refused = "" if bridge.mute(self.bridge, s) else bridge.refusal(self.bridge, s)
        refusal = self.wire.trouble or refused
        if self.wire.dead:
            mode, status = "broken", NodeStatus.STATUS_FAULT
            reason = f"nobody reads the wire any more: restart the node ({refusal or 'no reason'})"
        elif not s.begun:
            mode, status = "waiting", NodeStatus.STATUS_INITIALIZING
            reason = f"for {refusal or ', '.join(self.gathering.missing()) or 'its subscribers'}"
        elif refusal:
            mode, status, reason = "refused", NodeStatus.STATUS_FAULT, refusal
        elif s.silent:
            mode, status = "silent", NodeStatus.STATUS_LOST
            reason = f"no sample for {self.p.silence:g} s: the device is left to its own watchdog"
        elif self.reading and self.reading.ill:
            mode, status, reason = "ill", NodeStatus.STATUS_FAULT, "the device says that it is ill"
        elif self.reading and self.reading.applied.reason not in (Reason.COMMAND, Reason.PROGRAM):
            mode, status = "safe", NodeStatus.STATUS_DEGRADED
            reason = f"safe duty: {self.reading.applied.reason.value}"
        if self.port.in_force and status == NodeStatus.STATUS_OK:
            status, reason = NodeStatus.STATUS_DEGRADED, f"injected: {self.port.in_force}"
        stamps, invalid = self.commands
        valid = mode in ("running", "safe")
        return Report(
            mode, status, reason, stamps, invalid=invalid, valid=valid, values=self._values()
        )

    def _values(self) -> dict[str, object]:
        s, hello = self.state, self.state.hello
        return {
            "duty": f"{self.reading.applied.duty:.4f}" if self.reading else "none yet",
            "frames lost": s.lost,
            "authenticated": bool(s.caller.keys.host),
            "frames damaged": s.parser.damaged,
            "frames repeated": s.repeated,
            "bytes skipped": s.parser.skipped,
            "samples missed": s.missed,
            "samples untimely": s.untimely,
            "wire opened": self.wire.opens,
            "writes failed": self.wire.failed,
            "device restarts": s.boots,
            "device watchdog [ms]": f"{1e-3 * hello.watchdog:g}" if hello else "",
            "device safe duty": f"{frame.to_duty(hello.safe_duty):.4f}" if hello else "",
            "clock drift [ppm]": f"{1e6 * s.clock.drift:.2f}",
            "clock deviation [us]": f"{1e6 * clocks.deviation(s.clock):.1f}",
            "way there and back [us]": f"{1e6 * s.clock.width:.0f}",
            "clock steps": self.time.steps,
            "injected": self.port.in_force,
            "commands refused": s.gate.refused,
            "duties limited": s.gate.limited,
        }

    def end(self) -> None:
        """Leave the safe duty behind as the last command, and let subscribers take the last messages."""
        self.wire.stop(self.on_farewell)
        self.out.flush()

    def on_farewell(self) -> bytes:
        """The last words to the device; nobody else speaks any more."""
        with self.lock:
            self.state, data = bridge.farewell(self.bridge, self.state)
        return data


CARD = Card(
    BRIDGE,
    BridgeParameters,
    subscribes=(topics.PWM_COMMAND,),
    publishes=(*topics.SENSORS, topics.STATUS, topics.DIAGNOSTICS),
)


NODE = Executable(BridgeNode, CARD)


def main() -> None:
    """Entry point of the executable."""
    sys.exit(run(BridgeNode, CARD))


if __name__ == "__main__":
    main()
