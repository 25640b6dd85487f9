"""Whether damaged bytes can do harm: frames by the million, damaged in every way, through parser and bridge.

    ./er study damaged_frames --frames 10000000
    ./er study damaged_frames --frames 10000000 --sealed

Of every frame that comes out it is asked whether it was sent like that; of every undamaged frame, whether
it came out; of every reading, whether it is finite, in range and in order. The contents are random over
all that the fields can hold, so most of what is undamaged is nonsense too. Sealed, every frame is one of a session of
host and device, and some come from a forger, who knows all but the key. Exit status 1 if an answer is no.
"""

from __future__ import annotations

import argparse
import json
import math
import sys
from collections import Counter
from dataclasses import dataclass, field, replace
from time import perf_counter
from typing import NamedTuple
from zlib import crc32

import numpy as np
from er_models.one_line import OneLine
from er_models.seed import seed_reader
from er_plant_sim.duty_gate import Gate
from er_plant_sim.hardware import bridge, frame, parser, seal
from er_plant_sim.hardware.bridge import Bridge, BridgeState, Reading, Sources
from er_plant_sim.hardware.calibration import Calibration, Channel
from er_plant_sim.hardware.frame import Command, Hello, Message, Sample, Sync, SyncReply
from er_plant_sim.hardware.parser import ParserState

BATCH = 100
PERIOD = 5_000_000
DAMAGES = ("none", "bits", "missing", "added", "spliced", "noise", "repeated", "swapped", "forged")
CHANCES = (0.40, 0.30, 0.08, 0.08, 0.05, 0.04, 0.03, 0.02)
FORGED_CHANCES = (0.40, 0.20, *CHANCES[2:], 0.10)
"""Those of a sealed wire."""
BRIDGE = Bridge(
    Calibration("fuzz", (Channel(1e-3), Channel(1e-3, 10.0, -1.0, 50.0), Channel(1e-6), None, *[Channel(1e-2)] * 2)),
    Gate(0.0, 0.3, 0.1, 0.05, 20.0), PERIOD, 0.05, Sources(1, 4),
)  # fmt: skip
KEY, NONCES = bytes(range(seal.KEY)), (bytes(seal.NONCE), bytes(range(seal.NONCE)))


class Wire(NamedTuple):
    """The host's bridge at its start, the key that frames are sealed with, and all that may be; empty: none is."""

    own: Bridge = BRIDGE
    host: BridgeState = bridge.begin(bridge.start(BRIDGE, 0))
    key: bytes = b""
    keys: tuple[bytes, ...] = ()


PLAIN = Wire()


def sealed_wire() -> Wire:
    """A wire whose session is open."""
    own, keys = replace(BRIDGE, key=KEY), seal.session_keys(KEY, *NONCES)
    host = bridge.begin(bridge.start(own, 0, seed=bytes(seal.SEED)))
    return Wire(
        own, host._replace(caller=host.caller._replace(keys=keys)), keys.device, (KEY, keys.device)
    )


@dataclass
class Tally:
    """What happened."""

    frames: int = 0
    damaged: int = 0
    bytes: int = 0
    taken: int = 0
    wrong: int = 0
    missing: int = 0
    readings: int = 0
    bad_readings: int = 0
    damages: Counter[str] = field(default_factory=Counter)

    @property
    def sound(self) -> bool:
        """Whether nothing bad came out and nothing good was lost."""
        return not (self.wrong or self.missing or self.bad_readings)


def run(frames: int, seed: int, progress: bool = False, wire: Wire = PLAIN) -> Tally:
    """Send this many frames; progress: a line on the terminal now and then."""
    draw, tally = np.random.default_rng(seed), Tally()
    state, host, seq = ParserState(), wire.host, 0
    while tally.frames < frames:
        sent = [frame.encode(_message(draw, host, i), seq + i, wire.key) for i in range(BATCH)]
        seq = (seq + BATCH) % frame.WRAP
        stream = _damaged(draw, sent, tally, CHANCES if not wire.key else FORGED_CHANCES)
        state, host, found = _received(draw, wire, state, host, stream, tally)
        _judge(tally, _whole(sent, stream), found)
        if progress and tally.frames % 100_000 == 0:
            sys.stderr.write(f"\r{tally.frames:,} frames")
    return tally


def _message(draw: np.random.Generator, host: BridgeState, place: int) -> Message:
    """Random content; most samples fit what the bridge has seen, so that it goes on."""
    kind, fits = draw.random(2).tolist()
    words = draw.integers(0, 2**32, 12).tolist()
    near = host.sample_at - (host.clock.host - host.clock.device) + place * PERIOD
    if kind < 0.6:
        time = near % 2**64 if fits < 0.8 else words[0] << 32 | words[1]
        number = (host.number or 0) + 1 + place if fits < 0.8 else words[2]
        counts = tuple((word - 2**31) >> words[3] % 30 for word in words[4:10])
        return Sample(
            number, time, counts, words[3] >> 16, words[10] % 50001, words[11], words[1] % 256, words[2] % 256
        )  # fmt: skip
    if kind < 0.7:
        return Command(
            words[0], words[1] % 50001, words[2] % 256, words[3] % 256, words[4] - 2**31
        )
    if kind < 0.75:
        return Sync(words[0] << 32 | words[1])
    if kind < 0.95:
        now = host.sample_at
        if fits < 0.9:
            return SyncReply(max(now - 1000, 0), now % 2**64, (now + 500) % 2**64)
        return SyncReply(words[0], words[1] << 32, words[1] << 32 | words[2])
    return Hello(
        1 if fits < 0.9 else words[0], PERIOD if fits < 0.95 else words[1] + 1, 63, 1, 50000, 5000
    )


def _damaged(
    draw: np.random.Generator, sent: list[bytes], tally: Tally, chances: tuple[float, ...]
) -> bytes:
    """What goes over the wire."""
    choice = draw.choice(len(chances), size=len(sent), p=chances).tolist()
    pieces: list[bytes] = []
    for i, (data, kind) in enumerate(zip(sent, choice, strict=True)):
        name = DAMAGES[kind]
        tally.damages[name] += 1
        pieces.append(_DAMAGE[name](draw, data, sent[i - 1]))
    tally.frames += len(sent)
    tally.damaged += sum(kind != 0 for kind in choice)
    tally.bytes += sum(map(len, pieces))
    # enough behind the last frame for every header that promises more
    return b"".join(pieces) + bytes(2 * parser.LARGEST_PAYLOAD)


def _whole(sent: list[bytes], stream: bytes) -> Counter[bytes]:
    """The frames that are whole in the stream, however that came about.

    Damage may leave a frame as it was, and a lost last byte be replaced by the first one of the next
    frame, which that one then lacks: of two frames that overlap the first is there.
    """
    places: list[tuple[int, int]] = []
    for data in sent:
        at = stream.find(data)
        while at >= 0:
            places.append((at, at + len(data)))
            at = stream.find(data, at + 1)
    whole: Counter[bytes] = Counter()
    end = 0
    for first, last in sorted(places):
        if first >= end:
            whole[stream[first:last]] += 1
            end = last
    return whole


def _bits(draw: np.random.Generator, data: bytes, _: bytes) -> bytes:
    bits = bytearray(data)
    for place in draw.integers(8 * len(data), size=int(draw.integers(1, 13))).tolist():
        bits[place >> 3] ^= 1 << (place & 7)
    return bytes(bits)


def _missing(draw: np.random.Generator, data: bytes, _: bytes) -> bytes:
    at, length = draw.integers(len(data)), draw.integers(1, len(data))
    return data[:at] + data[at + length :]


def _added(draw: np.random.Generator, data: bytes, _: bytes) -> bytes:
    at, length = int(draw.integers(1, len(data))), int(draw.integers(1, 20))
    return data[:at] + draw.bytes(length) + data[at:]


def _spliced(draw: np.random.Generator, data: bytes, before: bytes) -> bytes:
    at = draw.integers(1, min(len(data), len(before)))
    return before[:at] + data[at:]


def _noise(draw: np.random.Generator, data: bytes, _: bytes) -> bytes:
    """Noise with headers that look right, then the frame."""
    head = frame.HEADER.pack(frame.MARK, data[len(frame.MARK)], 2, frame.SIZES[2], 7)
    return (
        draw.bytes(int(draw.integers(1, 80))) + head + draw.bytes(int(draw.integers(0, 40))) + data
    )


def _swapped(draw: np.random.Generator, data: bytes, _: bytes) -> bytes:
    """Two neighbouring bytes change places."""
    at = draw.integers(len(data) - 1)
    return data[:at] + data[at + 1 : at + 2] + data[at : at + 1] + data[at + 2 :]


def _forged(draw: np.random.Generator, data: bytes, _: bytes) -> bytes:
    """The frame with another content, sealed as well as can be without the key: by one of the forger's, or the CRC."""
    body = bytearray(data[: -seal.TAG])
    body[-1] ^= 1
    inner = bytes(body[len(frame.MARK) :])
    sealed = seal.tag(draw.bytes(seal.KEY), inner)
    return bytes(body) + (
        sealed if draw.random() < 0.5 else frame.CRC.pack(crc32(inner)) + sealed[4:]
    )


_DAMAGE = {
    "none": lambda _, data, __: data,
    "bits": _bits,
    "missing": _missing,
    "added": _added,
    "spliced": _spliced,
    "noise": _noise,
    "repeated": lambda _, data, __: data + data,
    "swapped": _swapped,
    "forged": _forged,
}


def _received(
    draw: np.random.Generator,
    wire: Wire,
    state: ParserState,
    host: BridgeState,
    stream: bytes,
    tally: Tally,
) -> tuple[ParserState, BridgeState, Counter[bytes]]:
    """Everything that comes out of the stream, cut into chunks of any length."""
    cuts = np.unique(draw.integers(0, len(stream), len(stream) // 40))
    found: Counter[bytes] = Counter()
    before = 0
    for cut in [*cuts.tolist(), len(stream)]:
        chunk, before = stream[before:cut], cut
        state, frames = parser.step(state, chunk, wire.keys)
        found.update(frame.encode(each.message, each.seq, wire.key) for each in frames)
        now = host.sample_at + PERIOD
        last = host.stamp
        host, said = bridge.on_bytes(wire.own, host, chunk, now)
        tally.readings += len(said.readings)
        tally.bad_readings += sum(not _good(reading, last, now) for reading in said.readings)
        host, _ = bridge.on_time(wire.own, host, now)
    return state, host, found


def _good(reading: Reading, last: int, now: int) -> bool:
    """Whether a reading may be published."""
    finite = all(math.isfinite(value.value) for value in reading.values)
    timely = last < reading.stamp and abs(reading.stamp - now) <= BRIDGE.timely + PERIOD
    return finite and timely and 0.0 <= reading.applied.duty <= 1.0


def _judge(tally: Tally, whole: Counter[bytes], found: Counter[bytes]) -> None:
    """Count what came out and was not sent, and what was whole and did not come out."""
    tally.taken += found.total()
    tally.wrong += (found - whole).total()
    tally.missing += (whole - found).total()


def main() -> None:
    """Entry point of the command."""
    p = OneLine(
        prog="er study damaged_frames",
        description=__doc__,
        formatter_class=argparse.RawTextHelpFormatter,
    )
    p.add_argument("--frames", type=int, default=100_000, help="number of frames (100000)")
    p.add_argument("--seed", type=seed_reader(), default=1, help="seed of contents and damage (1)")
    p.add_argument("--sealed", action="store_true", help="a wire whose frames are authenticated")
    options = p.parse_args()
    began = perf_counter()
    wire = sealed_wire() if options.sealed else PLAIN
    tally = run(options.frames, options.seed, sys.stderr.isatty(), wire)
    took = perf_counter() - began
    result = {
        **vars(tally),
        "damages": dict(tally.damages),
        "seconds": round(took, 1),
        "sound": tally.sound,
    }
    print(json.dumps(result, indent=1))  # noqa: T201  (what it is for)
    sys.exit(0 if tally.sound else 1)


if __name__ == "__main__":
    main()
