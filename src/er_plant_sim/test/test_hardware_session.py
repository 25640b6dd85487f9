"""The wire with a key: what it does beside one without, who may start again, and what a forger can do: nothing."""

from __future__ import annotations

from dataclasses import replace
from typing import Any

import numpy as np
import pytest
from er_plant_sim.duty_gate import Reason
from er_plant_sim.hardware import bridge, device, frame, parser, seal, session
from er_plant_sim.hardware.device import Device
from er_plant_sim.hardware.frame import Answer, Call, Command, Hello, Open, Sample, Sync
from er_plant_sim.hardware.impair import Wire
from er_plant_sim.hardware.parser import ParserState
from test_hardware_bridge import CALIBRATION, MS, RIG, World, host

KEY = bytes(range(32))
OTHER = bytes(32)


class Sealed(World):
    """A world whose host and device share a key; starts: how often either began."""

    def __init__(self, wire: Wire | None = None, **changes: Any) -> None:
        self.starts = 0
        super().__init__(
            replace(host(), key=KEY),
            wire or Wire(),
            d=Device(RIG, CALIBRATION, 1, KEY, self.seed()),
            **changes,
        )

    def __post_init__(self) -> None:
        sealed, self.p = self.p, host()
        super().__post_init__()
        self.p = sealed
        self.start_host()

    def seed(self) -> bytes:
        """Another one at each start."""
        self.starts += 1
        return self.starts.to_bytes(seal.SEED, "little")

    def start_host(self) -> None:
        self.host = bridge.start(self.p, self.now, seed=self.seed())

    def start_device(self) -> None:
        self.d = Device(RIG, CALIBRATION, self.starts, KEY, self.seed())
        self.device = device.start(self.d)


def kinds(data: bytes, keys: tuple[bytes, ...]) -> list[str]:
    """What the frames of some bytes are."""
    return [type(each.message).__name__ for each in parser.step(ParserState(), data, keys)[1]]


def test_a_frame_with_a_tag_byte_by_byte() -> None:
    """The example of docs/hardware.md: what another implementation has to produce."""
    message = Command(answers=258, duty=15_000, source=2, flags=1, road=-1)
    assert frame.encode(message, 5, KEY[:16]).hex(" ") == EXAMPLE
    made = seal.session_keys(KEY, b"\x01" * 8, b"\x02" * 8)
    assert (made.host.hex(), made.device.hex()) == SESSION


EXAMPLE = (
    "a5 5a 02 03 0c 00 05 00 00 00 02 01 00 00 98 3a 02 01 ff ff ff ff 08 c4 93 b8 88 fc 00 4b"
)
SESSION = ("3838c58642ba6c1e34957154b464d237", "4175d17f382ef701447a2ca0aa313734")


def test_with_a_key_readings_and_duty_are_those_of_a_wire_without_one() -> None:
    plain, sealed = World(host()).begin(), Sealed().begin()
    for each in (plain, sealed):
        each.run(0.5)
    assert [r.seq for r in sealed.readings] == list(range(1, 101))
    assert [r.values for r in sealed.readings] == [r.values for r in plain.readings]
    assert [r.applied for r in sealed.readings[5:]] == [r.applied for r in plain.readings[5:]]
    assert (sealed.host.lost, sealed.host.repeated, sealed.host.parser.damaged) == (0, 0, 0)


@pytest.mark.parametrize("lost", ["Call", "Answer", "Open", "Hello", "Sample"])
def test_a_lost_frame_of_the_handshake_delays_the_session_and_no_more(lost: str) -> None:
    world = Sealed()
    post, gone = world.post, [0]

    def posted(way: int, data: bytes) -> None:
        states = (world.host.caller.keys.device, world.host.caller.offered.device)
        keys = (KEY, *(each for each in states if each)) if way == 0 else (KEY,)
        if lost in kinds(data, keys) and gone[0] < 2:
            gone[0] += 1
            return
        post(way, data)

    world.post = posted  # type: ignore[method-assign]
    world.begin()
    world.run(0.2)
    assert gone[0] == 2
    assert len(world.readings) == 40


def test_either_side_may_start_again_at_any_time() -> None:
    world = Sealed().begin()
    world.run(0.3)
    world.start_device()
    world.run(2.0)
    assert world.host.boots == 1
    assert world.now - world.readings[-1].stamp < 10 * MS
    assert world.readings[-1].applied.reason is Reason.COMMAND
    world.start_host()
    world.readings = []
    world.begin()
    world.run(0.2)
    assert {r.applied.duty for r in world.readings[5:]} == {0.2}
    assert world.device.callee.sessions == 2


def test_a_wire_that_was_away_for_long_goes_on_with_the_session_or_another() -> None:
    world = Sealed().begin()
    for away in (0.1, 0.6):
        world.run(0.2)
        post = world.post
        world.post = lambda *_: None  # type: ignore[method-assign]
        world.run(away)
        world.post = post  # type: ignore[method-assign]
        world.run(0.4)
        assert world.now - world.readings[-1].stamp < 10 * MS


def test_before_its_numbers_would_come_again_a_session_is_renewed_without_a_gap() -> None:
    world = Sealed().begin()
    world.run(0.2)
    before = world.host.caller.keys
    world.host = world.host._replace(sent=session.RENEWED)
    world.device = world.device._replace(
        callee=world.device.callee._replace(heard=session.RENEWED)
    )
    world.run(0.3)
    assert world.host.caller.keys != before
    assert [r.seq for r in world.readings] == list(range(1, 101))
    assert {r.applied.reason for r in world.readings[5:]} == {Reason.COMMAND}


def test_another_key_or_none_opens_no_session_and_is_said() -> None:
    for key in (OTHER, b""):
        world = Sealed()
        world.d = replace(world.d, key=key)
        world.run(1.0)
        expected = "version 1" if not key else "no device answers"
        assert expected in bridge.refusal(world.p, world.host)
    plain = Sealed()
    plain.p = host()
    plain.host = bridge.start(plain.p, plain.now)
    plain.run(1.0)
    assert bridge.refusal(plain.p, plain.host)
    assert not plain.device.callee.sessions


def test_an_answer_counts_for_the_call_of_now_alone() -> None:
    caller, asked = session.call(KEY, session.Caller(bytes(16)), 0)
    again, same = session.call(KEY, caller, session.FRESH - 1)
    later, other = session.call(KEY, again, session.FRESH)
    assert (again.nonce, same) == (caller.nonce, asked)
    assert other != asked
    answer = Answer(b"d" * 8, caller.nonce)
    opening, out = session.answered(KEY, again, answer)
    assert kinds(out, (KEY,)) == ["Open"]
    assert opening.offered.device
    assert session.answered(KEY, later, answer) == (later, b"")
    assert session.answered(KEY, session.Caller(), Answer(b"d" * 8, b"")) == (
        session.Caller(),
        b"",
    )


def test_a_recording_of_the_other_side_opens_no_session() -> None:
    """A whole session played in order to a host, and to a device, that are alone with the forger."""
    world, tape = Sealed(), (list[bytes](), list[bytes]())
    post = world.post

    def taped(way: int, data: bytes) -> None:
        tape[way].append(data)
        post(way, data)

    world.post = taped  # type: ignore[method-assign]
    world.run(0.5)
    assert world.host.hello is not None
    world.start_host()
    world.start_device()
    fresh = world.device.rig.gate.command
    for data in tape[0]:
        world.now += MS
        world.host, _ = bridge.on_time(world.p, world.host, world.now)
        world.host, _ = bridge.on_bytes(world.p, world.host, data, world.now)
    for data in tape[1]:
        world.device, _ = device.on_bytes(world.d, world.device, data, world.own())
    assert (world.host.hello, world.host.caller.keys.host) == (None, b"")
    assert (world.device.callee.sessions, world.device.rig.gate.command) == (0, fresh)


def test_nonces_need_a_seed() -> None:
    with pytest.raises(ValueError, match="expected a seed of 16 bytes"):
        bridge.start(replace(host(), key=KEY), 0)


class Attacked(Sealed):
    """One whose wire a forger without the key hears, and talks on as much as both sides together."""

    def __init__(self, **changes: Any) -> None:
        self.tape: list[bytes] = []
        self.forge: Any = None
        super().__init__(**changes)

    def post(self, way: int, data: bytes) -> None:
        if data:
            self.tape.append(data)
        super().post(way, data)

    def run(self, seconds: float, *, ticking: bool = True) -> None:
        for _ in range(round(1000 * seconds)):
            if self.forge is not None:
                for data in self.forge():
                    self.device, answer = device.on_bytes(self.d, self.device, data, self.own())
                    self.tape.append(answer)  # it goes back to the forger
                    heard, said = bridge.on_bytes(self.p, self.host, data, self.now, datagram=True)
                    self.tape.append(said.data)
                    self.host, self.readings = heard, [*self.readings, *said.readings]
            super().run(0.001, ticking=ticking)


def forgeries(world: Attacked, kind: str, draw: np.random.Generator) -> Any:
    """What a forger sends in a millisecond."""

    def chosen() -> bytes:
        return world.tape[int(draw.integers(len(world.tape)))] if world.tape else b"?"

    def flipped() -> bytes:
        bits = bytearray(chosen() or b"?")
        bits[int(draw.integers(len(bits)))] ^= 1 << int(draw.integers(8))
        return bytes(bits)

    def made() -> bytes:
        seq, nonce = int(draw.integers(2**31, 2**32)), draw.bytes(8)
        messages = (
            Command(0, 50_000, 2, 1, 10**9), Sync(seq), Hello(9, 5_000_000, 63, 1, 1, 0),
            Sample(seq, seq, (1,) * 6, 63, 50_000, 0, 2, 0), Call(nonce), Answer(nonce, nonce), Open(nonce, nonce),
        )  # fmt: skip
        message = messages[int(draw.integers(len(messages)))]
        plain = isinstance(message, Call | Answer | Open) or draw.random() < 0.5
        return frame.encode(message, seq, OTHER if plain else b"")

    def noise() -> bytes:
        return draw.bytes(int(draw.integers(1, 200)))

    each = {"replays": (chosen, chosen), "all": (chosen, flipped, made, noise)}[kind]
    return lambda: [one() for one in each]


@pytest.mark.parametrize("kind", ["replays", "all"])
def test_a_forger_changes_nothing_and_locks_nobody_out(kind: str) -> None:
    """With the tape of two earlier sessions, before, while and after the session opens; both sides start again."""
    draw = np.random.default_rng(7)
    alone, attacked = Sealed(), Attacked()
    attacked.start_host()
    alone.start_host()
    for world in (alone, attacked):
        world.run(0.4)  # a session to be replayed later
        world.start_host()
        world.run(0.4)
        world.start_device()
        world.start_host()
    attacked.forge = forgeries(attacked, kind, draw)
    for world in (alone, attacked):
        world.begin()
        world.run(0.6)
        world.start_host()
        world.begin()
        world.run(0.3)
    assert len(alone.readings) == 180
    assert attacked.readings == alone.readings
    assert attacked.truth == alone.truth
    assert attacked.device.rig.gate == alone.device.rig.gate
    assert attacked.device.height == alone.device.height
    assert attacked.device.callee.sessions == alone.device.callee.sessions
    assert (attacked.host.lost, attacked.host.boots) == (alone.host.lost, alone.host.boots)
    assert (
        kind == "replays" or attacked.device.parser.damaged + attacked.device.parser.skipped > 100
    )
