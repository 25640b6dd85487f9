"""The host's side of the wire without any wire: bytes and commands in, readings and bytes out. Pure.

    state, said = on_bytes(p, state, data, now)     # what came over the wire
    state, data = on_command(p, state, command, valid, now)
    state, said = on_time(p, state, now)            # now and then: questions for the time, silence

now: the host's steady clock [ns]. Two watchdogs hold the safe duty: the duty gate here, when commands stay
away; the device's own, when this program or the wire is gone.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple

from er_plant_sim import duty_gate
from er_plant_sim.duty_gate import Applied, Gate, GateState, Reason
from er_plant_sim.hardware import calibration as calibrating
from er_plant_sim.hardware import clocks, frame, parser, session
from er_plant_sim.hardware.calibration import Calibration, Filters, Value
from er_plant_sim.hardware.clocks import ClockModel, ClockState, Exchange
from er_plant_sim.hardware.frame import Answer, Frame, Hello, Message, Sample, Sync, SyncReply
from er_plant_sim.hardware.parser import ParserState
from er_plant_sim.hardware.seal import SEED
from er_plant_sim.hardware.session import Caller

LIMITED_KEPT = 8
"""Commands whose limiting here is remembered until the device reports them in force."""

NO_ANSWER = "no device answers: is it there, and does it have the key of key_file?"


class Sources(NamedTuple):
    """How a command says that it is the program's, or the safe duty."""

    program: int
    safe: int


@dataclass(frozen=True, eq=False)
class Bridge:
    """What does not change while it runs.

    period: expected between samples [ns]; silence: time without sample after which the rig is lost [s];
    certain: the clocks are aligned when the offset's standard deviation is below this [s]; asking: time
    between two questions for the time [ns]; unanswered: time without an answer after which the clocks are not
    aligned any more, as two that are 200 ppm apart are off by `certain` then [ns]; timely: a sample whose stamp
    is farther from now is not believed [ns]; duty, road: of the program from a tick on [1], [m], or None; the duty is
    None, too, at a tick at which commands say it; key: what it shares with the device, empty on a wire without
    authentication.
    """

    calibration: Calibration
    gate: Gate
    period: int
    silence: float
    sources: Sources
    duty: Callable[[int], float | None] | None = None
    road: Callable[[int], float] | None = None
    certain: float = 1e-3
    asking: int = 100_000_000
    unanswered: int = 5_000_000_000
    timely: int = 1_000_000_000
    clock: ClockModel = field(default_factory=ClockModel)
    key: bytes = b""


class BridgeState(NamedTuple):
    """Memory between calls.

    heard: sequence number of the last frame, heard_at: when it came [ns]; seq: of the last sample given on,
    `number` its number on the device; begun: whether samples are given on; asked_at, answered_at: when the
    device was last asked for its time, and answered [ns]; counts: frames lost and repeated, samples missed and
    untimely; caller: session with the device, on a wire with a key.
    """

    parser: ParserState = ParserState()
    clock: ClockState = ClockState()
    gate: GateState = GateState(0.0, 0.0)
    filters: Filters = calibrating.EMPTY
    hello: Hello | None = None
    heard: int | None = None
    heard_at: int = 0
    begun: bool = False
    seq: int = 0
    number: int | None = None
    stamp: int = 0
    sample_at: int = 0
    silent: bool = False
    reason: Reason = Reason.NO_COMMAND
    limited: tuple[int, ...] = ()
    sent: int = 0
    asked_at: int = 0
    answered_at: int = 0
    lost: int = 0
    repeated: int = 0
    missed: int = 0
    untimely: int = 0
    boots: int = 0
    conflict: bool = False
    caller: Caller = Caller()


class Reading(NamedTuple):
    """One sample: its sequence number, time on the host's steady clock [ns], channels, duty from then on."""

    seq: int
    stamp: int
    values: tuple[Value, ...]
    applied: Applied
    ill: bool


class Said(NamedTuple):
    """Readings to publish, bytes for the device, and whether the rig has just fallen silent."""

    readings: list[Reading]
    data: bytes
    silence: bool = False


def start(p: Bridge, now: int, *, sent: int = 0, seed: bytes = b"") -> BridgeState:
    """Before the first byte.

    sent: number of the last frame of before, where this program sent some already; seed: of the nonces on a wire with
    a key, drawn at random at each start.

    Raises:
        ValueError: There is a key and no seed: the nonces of before would be used again.
    """
    if p.key and len(seed) < SEED:
        raise ValueError(f"expected a seed of {SEED} bytes beside a key, found {len(seed)}")
    gate = GateState(p.gate.safe_duty, 1e-9 * now)
    return BridgeState(gate=gate, sample_at=now, sent=sent, caller=Caller(seed))


def on_bytes(
    p: Bridge, state: BridgeState, data: bytes, now: int, *, datagram: bool = False
) -> tuple[BridgeState, Said]:
    """Take bytes of the wire; datagram: they are whole frames, nothing of which follows later."""
    keys = state.caller.listening(p.key) if p.key else ()
    parsed, found = parser.step(state.parser, data, keys)
    state = state._replace(parser=parser.flushed(parsed) if datagram else parsed)
    readings: list[Reading] = []
    out = b""
    for each in found:
        if isinstance(each.message, Answer):
            caller, answer = session.answered(p.key, state.caller, each.message)
            state, out = state._replace(caller=caller), out + answer
            continue
        state, fresh = (_in_session if p.key else _ordered)(state, each)
        if not fresh:
            continue
        state = state._replace(heard_at=now)
        if isinstance(each.message, Hello):
            state = _on_hello(state, each.message)
        elif isinstance(each.message, SyncReply):
            state = _on_reply(p, state, Exchange(*each.message, now))
        elif isinstance(each.message, Sample) and _usable(p, state):
            state, reading = _on_sample(p, state, each.message, now)
            if reading is not None:
                readings.append(reading)
                state, answer = _after_sample(p, state, now)
                out += answer
    return state, Said(readings, out)


def on_command(
    p: Bridge,
    state: BridgeState,
    command: duty_gate.Command,
    now: int,
    *,
    valid: bool,
    stamp: int | None = None,
) -> tuple[BridgeState, bytes]:
    """Take a command that answers a sample (its seq; 0: none); bytes for the device, if it is to act on it.

    stamp: time of that sample as the command says [ns], None where it says none; the older of both counts.
    """
    if not state.begun:
        return state, b""
    known = 0 < command.seq <= state.seq
    at = state.stamp - (state.seq - command.seq) * p.period if known else now
    at = at if stamp is None else min(at, stamp)
    # one that answers a sample still to come is meant for a bridge that was here before
    command = command._replace(t=1e-9 * at, seq=command.seq if known else 0)
    before = state.gate
    gate = duty_gate.receive(state.gate, command, valid=valid, newest=state.seq)
    state = state._replace(gate=gate)
    if state.gate.command is before.command or _programmed(p, state) is not None:
        return state, b""
    return _decide(p, state, now)


def on_time(p: Bridge, state: BridgeState, now: int) -> tuple[BridgeState, Said]:
    """Call the device and ask it for its time when that is due, and notice its silence."""
    called, silence = b"", False
    quiet = now - state.heard_at
    if p.key and session.due(state.caller, now, quiet=quiet, sent=state.sent):
        caller, called = session.call(p.key, state.caller, now)
        state = state._replace(caller=caller)
    out = b""
    if now - state.asked_at >= (p.asking if aligned(p, state) else p.asking // 5):
        state, out = _sent(p, state._replace(asked_at=now), Sync(now))
    if (
        state.begun
        and state.seq
        and not state.silent
        and 1e-9 * (now - state.sample_at) > p.silence
    ):
        # not the time of now: samples that were only held up may still come, and are older
        state, silence = state._replace(silent=True, stamp=state.stamp + 1), True
    return state, Said([], called + out, silence)


def begin(state: BridgeState) -> BridgeState:
    """Give samples on from now; the next one is the first."""
    return state._replace(begun=True)


def reconnected(state: BridgeState) -> BridgeState:
    """The wire was opened anew: half frames of before are void."""
    return state._replace(parser=parser.flushed(state.parser), heard=None)


def aligned(p: Bridge, state: BridgeState) -> bool:
    """Whether the device's time is known well enough to stamp with, now and not only when it last answered."""
    quiet = _quiet(state)
    if quiet > p.unanswered:
        return False
    return clocks.deviation_later(p.clock, state.clock, quiet) < p.certain


def refusal(p: Bridge, state: BridgeState) -> str:
    """Why no sample is given on although the device sends some; empty when they are."""
    if state.parser.foreign and state.hello is None:
        ours = frame.SEALED if p.key else frame.VERSION
        return f"the device speaks version {state.parser.version} of the protocol, this program {ours}"
    if p.key and not state.caller.keys.host:
        return NO_ANSWER
    if state.hello is None:
        return "the device has not said what it is"
    if state.hello.period != p.period:
        found, expected = 1e9 / state.hello.period, 1e9 / p.period
        return f"the device samples at {found:g} Hz, parameter rate expects {expected:g} Hz"
    if p.road is not None and not state.hello.abilities & frame.CAN_MOVE_ROAD:
        return "the device cannot move the road: parameter road_source has to be device"
    if state.clock.exchanges and _quiet(state) > p.unanswered:
        return f"the device has not told its time for {1e-9 * p.unanswered:g} s"
    if not aligned(p, state):
        return "the clocks are not aligned yet"
    return ""


def mute(p: Bridge, state: BridgeState) -> bool:
    """Whether a rig that has fallen silent does not say a word: it is not there, and nothing of it is refused."""
    return state.silent and 1e-9 * (state.asked_at - state.heard_at) > p.silence


def _usable(p: Bridge, state: BridgeState) -> bool:
    return state.begun and not refusal(p, state)


def _quiet(state: BridgeState) -> int:
    """Time without an answer to the questions for the time [ns]."""
    return max(state.asked_at - state.answered_at, 0)


def _ordered(state: BridgeState, found: Frame) -> tuple[BridgeState, bool]:
    """Whether a frame is newer than the one before; counts lost ones and those that came again or late."""
    if state.heard is None or isinstance(found.message, Hello):
        return state._replace(heard=found.seq), True
    ahead = frame.ahead(found.seq, state.heard)
    if ahead <= 0:
        return state._replace(repeated=state.repeated + 1), False
    return state._replace(heard=found.seq, lost=state.lost + ahead - 1), True


def _in_session(state: BridgeState, found: Frame) -> tuple[BridgeState, bool]:
    """Whether a frame is a newer one of the session; the first one of another session opens that."""
    before = state.caller
    caller, fresh = session.ordered(before, found.seq, found.key)
    if caller.keys != before.keys:
        return state._replace(caller=caller, sent=0), fresh
    if not fresh:
        return state._replace(repeated=state.repeated + 1), False
    return state._replace(caller=caller, lost=state.lost + found.seq - before.heard - 1), True


def _on_hello(state: BridgeState, hello: Hello) -> BridgeState:
    """Another boot number means that the device restarted: its clock and its numbers are new."""
    if state.hello is not None and hello.boot != state.hello.boot:
        clock = ClockState(restarts=state.clock.restarts + 1)
        state = state._replace(clock=clock, number=None, boots=state.boots + 1)
    return state._replace(hello=hello)


def _on_reply(p: Bridge, state: BridgeState, exchange: Exchange) -> BridgeState:
    """Align the clocks; an answer that cannot be is none."""
    clock = clocks.step(p.clock, state.clock, exchange)
    if clock is state.clock:
        return state
    return state._replace(clock=clock, answered_at=exchange.heard)


def _on_sample(
    p: Bridge, state: BridgeState, sample: Sample, now: int
) -> tuple[BridgeState, Reading | None]:
    """Calibrate a sample and number it on; one that is not newer than the last is dropped."""
    step = 1 if state.number is None else frame.ahead(sample.number, state.number)
    if step <= 0:
        return state._replace(repeated=state.repeated + 1), None
    stamp = clocks.to_host(state.clock, sample.time)
    if abs(stamp - now) > p.timely:
        return state._replace(untimely=state.untimely + 1), None
    filters, values = calibrating.step(
        p.calibration, state.filters, sample.values, sample.valid, 1e-9 * step * p.period
    )
    state = state._replace(
        filters=filters, seq=state.seq + step, number=sample.number, sample_at=now,
        silent=False, missed=state.missed + step - 1,
        stamp=max(stamp, state.stamp + 1),  # time never runs back, however the clocks are corrected
    )  # fmt: skip
    ill = bool(sample.flags & frame.BROKEN)
    return state, Reading(state.seq, state.stamp, values, _applied(p, state, sample), ill)


def _applied(p: Bridge, state: BridgeState, sample: Sample) -> Applied:
    """The duty that the device reports, with what is known here of the command it came from."""
    answers = state.seq + frame.ahead(sample.command, sample.number) if sample.command else 0
    reason = Reason.COMMAND
    if sample.flags & frame.WATCHDOG:
        told = state.gate.command is not None or p.duty is not None
        reason = Reason.OLD_COMMAND if told else Reason.NO_COMMAND
    elif sample.source == p.sources.program:
        reason = Reason.PROGRAM
    elif sample.source == p.sources.safe and not sample.command:
        reason = state.reason if state.reason is not Reason.COMMAND else Reason.OLD_COMMAND
    saturated = bool(sample.flags & frame.LIMITED) or sample.command in state.limited
    seq = max(answers, 0) if reason is Reason.COMMAND else 0
    return Applied(frame.to_duty(sample.duty), seq, sample.source, saturated, reason)


def _after_sample(p: Bridge, state: BridgeState, now: int) -> tuple[BridgeState, bytes]:
    """What the device is told after a sample: the program's duty, or the safe one where commands stay away."""
    wanted = _programmed(p, state)
    if wanted is not None:
        gate, applied = duty_gate.program(p.gate, state.gate, 1e-9 * now, wanted)
        state = state._replace(gate=gate, reason=applied.reason)
        return _told(p, state, applied.duty, p.sources.program)
    command = state.gate.command
    fresh = command is not None and 1e-9 * now - command.t <= p.gate.timeout and not state.conflict
    if fresh:
        return (state, b"") if p.road is None else _decide(p, state, now)
    return _decide(p, state, now)


def _programmed(p: Bridge, state: BridgeState) -> float | None:
    """The program's duty from the next tick on; None where commands say it."""
    return None if p.duty is None else p.duty(state.seq + 1)


def _decide(p: Bridge, state: BridgeState, now: int) -> tuple[BridgeState, bytes]:
    """The duty within all limits, told to the device."""
    gate, applied = duty_gate.step(p.gate, state.gate, 1e-9 * now, conflict=state.conflict)
    state = state._replace(gate=gate, reason=applied.reason)
    if applied.reason is not Reason.COMMAND:
        return _told(p, state, applied.duty, p.sources.safe)
    back = state.seq - applied.command_seq
    answers = ((state.number or 0) - back) % frame.WRAP if applied.command_seq else 0
    if applied.saturated and answers not in state.limited:
        state = state._replace(limited=(*state.limited, answers)[-LIMITED_KEPT:])
    return _told(p, state, applied.duty, applied.source, answers)


def _told(
    p: Bridge, state: BridgeState, duty: float, source: int, answers: int = 0
) -> tuple[BridgeState, bytes]:
    flags, height = 0, 0
    if p.road is not None:
        flags, height = frame.MOVE_ROAD, frame.from_height(p.road(state.seq + 1))
    return _sent(p, state, frame.Command(answers, frame.from_duty(duty), source, flags, height))


def _sent(p: Bridge, state: BridgeState, message: Message) -> tuple[BridgeState, bytes]:
    """A frame with the next number; none before a session, on a wire with a key."""
    key = state.caller.keys.host
    if p.key and not key:
        return state, b""
    sent = (state.sent + 1) % frame.WRAP
    return state._replace(sent=sent), frame.encode(message, sent, key)


def farewell(p: Bridge, state: BridgeState) -> tuple[BridgeState, bytes]:
    """The last thing the device is told: its safe duty."""
    return _sent(
        p, state, frame.Command(0, frame.from_duty(p.gate.safe_duty), p.sources.safe, 0, 0)
    )
