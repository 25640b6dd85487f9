"""The C reference of docs/hardware.md against the host's side: what a device with it says and believes."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
from collections.abc import Callable
from dataclasses import replace
from hashlib import blake2s
from typing import Any

import numpy as np
import pytest
from er_plant_sim.hardware import bridge, frame, seal
from er_plant_sim.hardware.bridge import BridgeState
from er_plant_sim.hardware.frame import Hello, Kind, Sample, SyncReply
from test_hardware_bridge import CONFIG, MS, host

COMPILER = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
pytestmark = pytest.mark.skipif(COMPILER is None, reason="no C compiler (cc, gcc, clang) here")
KEY = bytes(range(32))
STRICT = ("-std=c99", "-Wall", "-Wextra", "-Wpedantic", "-Wconversion", "-Werror", "-O1")


@pytest.fixture(scope="module")
def code(tmp_path_factory: pytest.TempPathFactory) -> ctypes.CDLL:
    """The firmware's part, compiled."""
    out = tmp_path_factory.mktemp("firmware") / "er_wire.so"
    source = str(CONFIG / "hardware/firmware/er_wire.c")
    done = subprocess.run(
        [str(COMPILER), *STRICT, "-shared", "-fPIC", source, "-o", str(out)],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    made = ctypes.CDLL(str(out))
    made.er_wire_take.restype = made.er_wire_send.restype = ctypes.c_size_t
    return made


class Firmware:
    """A device with the C code; taken: kinds of the frames that it believed."""

    def __init__(self, code: ctypes.CDLL, boot: int) -> None:
        self.code, self.boot, self.taken = code, boot, list[int]()
        self.wire, self.out = ctypes.create_string_buffer(256), ctypes.create_string_buffer(80)
        code.er_wire_start(self.wire, KEY, boot.to_bytes(16, "little"))

    def send(self, message: frame.Message) -> bytes:
        whole = frame.encode(message, 0)
        payload = whole[frame.HEADER.size : -frame.CRC.size]
        size = self.code.er_wire_send(
            self.wire, whole[3], payload, ctypes.c_size_t(len(payload)), self.out
        )
        return self.out.raw[:size]

    def take(self, data: bytes) -> bytes:
        """Take whole frames, as a datagram holds them."""
        answers, kind = b"", ctypes.c_uint8()
        while len(data) >= frame.HEADER.size:
            size = frame.HEADER.unpack(data[: frame.HEADER.size])[3] + frame.HEADER.size + seal.TAG
            whole, data = data[:size], data[size:]
            n = self.code.er_wire_take(
                self.wire, whole, ctypes.c_size_t(len(whole)), self.out, ctypes.byref(kind)
            )
            answers += self.out.raw[:n]
            self.taken += [kind.value] if kind.value else []
            if kind.value == Kind.OPEN:
                answers += self.send(Hello(self.boot, 5 * MS, 63, 1, 50_000, 5_000))
            if kind.value == Kind.SYNC:
                asked = int.from_bytes(whole[10:18], "little")
                answers += self.send(SyncReply(asked, asked, asked))
        return answers


def talk(
    p: bridge.Bridge, state: BridgeState, now: int, firmware: Firmware, seconds: float,
    heard: Callable[[bytes], None] = lambda _: None,
) -> tuple[BridgeState, int]:  # fmt: skip
    """Host and firmware side by side, a sample every 5 ms; heard: gets what the host says."""
    for _ in range(round(200 * seconds)):
        now += 5 * MS
        state, said = bridge.on_time(p, state, now)
        out = said.data
        while out:  # until nobody has anything to say
            heard(out)
            state, said = bridge.on_bytes(p, state, firmware.take(out), now, datagram=True)
            out = said.data
        number = now // (5 * MS) % 2**32
        sample = firmware.send(Sample(number, now, (1, 2, 3, 4, 5, 6), 63, 5_000, 0, 0, 0))
        state, said = bridge.on_bytes(p, state, sample, now, datagram=True)
        heard(said.data)
        firmware.take(said.data)
    return state, now


def test_the_hash_is_that_of_the_standard_library(code: ctypes.CDLL) -> None:
    draw = np.random.default_rng(1)
    for size in (*range(0, 140), 255, 256, 1000):
        text, key = draw.bytes(size), draw.bytes(int(draw.integers(0, 33)))
        long = int(draw.integers(1, 33))
        out = ctypes.create_string_buffer(long)
        code.er_blake2s(
            out, ctypes.c_size_t(long), key, ctypes.c_size_t(len(key)), text, ctypes.c_size_t(size)
        )
        assert out.raw == blake2s(text, key=key, digest_size=long).digest()


def test_host_and_firmware_open_sessions_whoever_starts_again(code: ctypes.CDLL) -> None:
    p = replace(host(), key=KEY, unanswered=10**12)
    now, firmware = 10**9, Firmware(code, 1)
    assert firmware.send(Hello(1, 5 * MS, 63, 1, 50_000, 5_000)) == b""
    state = bridge.start(p, now, seed=b"a" * 16)
    state, now = talk(p, state, now, firmware, 1.5)
    assert bridge.refusal(p, state) == ""
    state, now = talk(p, bridge.begin(state), now, firmware, 0.5)
    assert (state.seq, state.lost, state.parser.damaged) == (100, 0, 0)
    assert {Kind.OPEN, Kind.SYNC, Kind.COMMAND} == set(firmware.taken)
    state, now = talk(p, state, now, Firmware(code, 2), 1.0)  # the device restarted
    assert state.boots == 1
    assert state.sample_at == now
    state = bridge.begin(bridge.start(p, now, seed=b"b" * 16))  # and now the host
    firmware = Firmware(code, 3)
    state, now = talk(p, state, now, firmware, 1.5)
    assert state.sample_at == now


def test_firmware_believes_nothing_that_is_damaged_repeated_or_of_another_session(
    code: ctypes.CDLL,
) -> None:
    p = replace(host(), key=KEY, unanswered=10**12)
    draw, firmware, tape = np.random.default_rng(2), Firmware(code, 1), list[bytes]()
    state, now = talk(p, bridge.start(p, 10**9, seed=b"a" * 16), 10**9, firmware, 0.5, tape.append)
    state = bridge.start(p, now, seed=b"b" * 16)
    state, now = talk(p, state, now, firmware, 0.5, tape.append)
    tape, taken, wire = [each for each in tape if each], len(firmware.taken), firmware.wire.raw
    answers = [firmware.take(each) for each in tape]
    assert [each for each in answers if each] != []  # calls are answered, which changes nothing
    assert (len(firmware.taken), firmware.wire.raw) == (taken, wire)
    for _ in range(3000):
        bits = bytearray(tape[int(draw.integers(len(tape)))])
        bits[int(draw.integers(len(bits)))] ^= 1 << int(draw.integers(8))
        assert firmware.take(bytes(bits)) in (b"", *answers)
        noise: Any = frame.MARK + draw.bytes(int(draw.integers(1, 70)))
        assert firmware.take(noise) == b""
    assert (len(firmware.taken), firmware.wire.raw) == (taken, wire)
    state, _ = talk(p, state, now, firmware, 0.1)
    assert len(firmware.taken) > taken  # and the host is still heard
