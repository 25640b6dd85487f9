"""A device that the wire can be tested with: the simulated rig behind the protocol. Pure.

    state, data = on_bytes(p, state, data, now)   # commands, questions for the time
    state, data = tick(p, state, now)             # every period: a sample, now and then what it is

now: the device's own clock [ns]. It follows the road of its program until the host asks for heights.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

from er_plant_sim import rig as plant
from er_plant_sim import simulator
from er_plant_sim.duty_gate import Applied, Reason
from er_plant_sim.duty_gate import Command as Wish
from er_plant_sim.hardware import frame, parser, session
from er_plant_sim.hardware.calibration import Calibration, to_counts
from er_plant_sim.hardware.frame import (
    Call,
    Command,
    Frame,
    Hello,
    Message,
    Open,
    Sample,
    Sync,
    SyncReply,
)
from er_plant_sim.hardware.parser import ParserState
from er_plant_sim.hardware.session import Callee
from er_plant_sim.rig import Rig, RigState
from er_plant_sim.simulator import Measurement

FORGOTTEN = 500_000_000
"""Time without a newer frame after which the host may count anew: it was started again [ns]."""


@dataclass(frozen=True, eq=False)
class Device:
    """Rig, calibration that it undoes to show counts, and the number of this start.

    key: what it shares with the host, empty on a wire without authentication; seed: of its nonces, drawn at random.
    """

    rig: Rig
    calibration: Calibration
    boot: int
    key: bytes = b""
    seed: bytes = b""

    @property
    def hello(self) -> Hello:
        """What it says of itself."""
        channels = sum(1 << i for i, each in enumerate(self.calibration.channels) if each)
        gate = self.rig.gate
        return Hello(
            self.boot, round(1e9 * self.rig.dt), channels, frame.CAN_MOVE_ROAD,
            round(1e6 * gate.timeout), frame.from_duty(gate.safe_duty),
        )  # fmt: skip


class DeviceState(NamedTuple):
    """Rig, parser, frames sent, samples taken, the road height asked for [m] (None: the program's).

    heard: sequence number of the host's last frame (None: none yet), heard_at: when that came [ns];
    callee: session with the host, on a wire with a key.
    """

    rig: RigState
    parser: ParserState = ParserState()
    sent: int = 0
    number: int = 0
    height: float | None = None
    heard: int | None = None
    heard_at: int = 0
    callee: Callee = Callee()


def start(p: Device) -> DeviceState:
    """Before the first tick."""
    return DeviceState(plant.start(p.rig), callee=Callee(p.seed))


def on_bytes(
    p: Device, state: DeviceState, data: bytes, now: int, *, datagram: bool = False
) -> tuple[DeviceState, bytes]:
    """Take bytes of the wire; answers go out at once."""
    keys = state.callee.listening(p.key) if p.key else ()
    parsed, found = parser.step(state.parser, data, keys)
    state = state._replace(parser=parser.flushed(parsed) if datagram else parsed)
    out = b""
    for each in found:
        if isinstance(each.message, Call):
            out += session.answer(p.key, state.callee, each.message)
            continue
        if isinstance(each.message, Open):
            state, answer = _on_open(p, state, each.message)
            out += answer
            continue
        state, fresh = _ordered(p, state, each, now)
        if not fresh:
            continue
        if isinstance(each.message, Command):
            state = _on_command(p, state, each.message)
        elif isinstance(each.message, Sync):
            state, answer = _sent(p, state, SyncReply(each.message.sent, now, now))
            out += answer
    return state, out


def tick(p: Device, state: DeviceState, now: int) -> tuple[DeviceState, bytes]:
    """Move the rig to now, measure, decide the duty, tell all that."""
    if state.number:
        state = state._replace(rig=_advanced(p, state))
    out = b""
    if state.number % round(1.0 / p.rig.dt) == 0:
        state, out = _sent(p, state, p.hello)
    measured = plant.sense(p.rig, state.rig)
    decided, applied = plant.decide(p.rig, state.rig)
    state = state._replace(rig=decided, number=state.number + 1)
    state, data = _sent(p, state, _sample(p, state, measured, applied, now))
    return state, out + data


def _on_open(p: Device, state: DeviceState, asked: Open) -> tuple[DeviceState, bytes]:
    """Begin the session and say what it is, if this is the one that is offered."""
    callee, new = session.opened(p.key, state.callee, asked)
    if not new:
        return state, b""
    return _sent(p, state._replace(callee=callee, sent=0), p.hello)


def _ordered(p: Device, state: DeviceState, found: Frame, now: int) -> tuple[DeviceState, bool]:
    """Whether a frame is newer than the one before; without a key any frame is after a while without such a one."""
    if p.key:
        callee, fresh = session.followed(state.callee, found.seq, found.key)
        return state._replace(callee=callee), fresh
    known = state.heard is not None and now - state.heard_at <= FORGOTTEN
    if known and frame.ahead(found.seq, state.heard or 0) <= 0:
        return state, False
    return state._replace(heard=found.seq, heard_at=now), True


def _advanced(p: Device, state: DeviceState) -> RigState:
    if state.height is None:
        return plant.advance(p.rig, state.rig)
    moved = simulator.advance(p.rig.sim, state.rig.sim, state.height, state.rig.gate.duty)
    return state.rig._replace(sim=moved)


def _on_command(p: Device, state: DeviceState, command: Command) -> DeviceState:
    t = plant.time(p.rig, state.rig)
    wish = Wish(t, command.answers, frame.to_duty(command.duty), command.source)
    state = state._replace(rig=plant.receive(p.rig, state.rig, wish, valid=True))
    if command.flags & frame.MOVE_ROAD:
        state = state._replace(height=command.road * frame.ROAD_UNIT)
    return state


def _sample(p: Device, state: DeviceState, m: Measurement, applied: Applied, now: int) -> Sample:
    si = (
        m.sprung_acceleration, m.unsprung_acceleration, m.deflection, m.deflection_velocity, m.force, m.road
    )  # fmt: skip
    channels = p.calibration.channels
    counts = tuple(to_counts(c, v) if c else 0 for c, v in zip(channels, si, strict=True))
    held = applied.reason is not Reason.COMMAND
    flags = frame.WATCHDOG * held + frame.LIMITED * (applied.saturated and not held)
    return Sample(
        state.number, now, counts, p.hello.channels, frame.from_duty(applied.duty),
        applied.command_seq, applied.source, flags,
    )  # fmt: skip


def _sent(p: Device, state: DeviceState, message: Message) -> tuple[DeviceState, bytes]:
    """A frame with the next number; none to nobody, on a wire with a key."""
    if p.key and not state.callee.keys.device:
        return state, b""
    sent = (state.sent + 1) % frame.WRAP
    return state._replace(sent=sent), frame.encode(message, sent, state.callee.keys.device)
