"""Frames of the wire between host and rig: header, payload, CRC or tag. docs/hardware.md shows them.

    offset  size  field
    0       2     mark, 0xA5 0x5A
    2       1     version of the protocol: 1 with a CRC, 2 with a tag
    3       1     kind of the frame
    4       2     bytes of payload
    6       4     sequence number of the sender, one more each frame
    10      n     payload
    10 + n  4     version 1: CRC-32 (IEEE 802.3) of everything after the mark
            8     version 2: tag of the same bytes (`hardware/seal.py`)

All numbers are integers, lowest byte first, so that no NaN can travel.
"""

from __future__ import annotations

import struct
from enum import IntEnum
from typing import Final, NamedTuple, TypeAlias
from zlib import crc32

from er_plant_sim.hardware import seal

VERSION: Final = 1
SEALED: Final = 2
"""Version of the protocol whose frames carry a tag."""
MARK: Final = b"\xa5\x5a"
HEADER: Final = struct.Struct("<2sBBHI")
CRC: Final = struct.Struct("<I")
OVERHEAD: Final = HEADER.size + CRC.size
WRAP: Final = 1 << 32
"""Sequence numbers and sample numbers start anew after so many."""


class Kind(IntEnum):
    """Kinds of frames."""

    HELLO = 1
    SAMPLE = 2
    COMMAND = 3
    SYNC = 4
    SYNC_REPLY = 5
    CALL = 6
    ANSWER = 7
    OPEN = 8


CHANNELS: Final = (
    "sprung_acceleration",
    "unsprung_acceleration",
    "deflection",
    "deflection_velocity",
    "force",
    "road",
)
"""Channels in the order of their places in a sample and of their bits."""

DUTY_UNIT: Final = 2e-5
"""Of a duty on the wire [1]: 50000 is full field, more is refused."""
ROAD_UNIT: Final = 1e-9
"""Of a road height that the host asks for [m]."""
ROAD_REACH: Final = 2**31 - 1
"""Greatest road height on the wire, up and down [`ROAD_UNIT`]: 2.147 m."""
CAN_MOVE_ROAD: Final = 1
"""Bit of a device that can follow a road height."""
WATCHDOG, LIMITED, BROKEN = 1, 2, 4
"""Flags of a sample: the device's watchdog holds the safe duty; a limit of the device changed the duty; it is ill."""
MOVE_ROAD: Final = 1
"""Flag of a command: its road height counts."""


class Hello(NamedTuple):
    """Device to host, at the start and once a second: what it is.

    boot: drawn at random when the device starts; period: between samples [ns]; channels: bits of what it
    measures; abilities: bits; watchdog: time without command until the safe duty [us]; safe_duty: its
    safe duty in units of `DUTY_UNIT`.
    """

    boot: int
    period: int
    channels: int
    abilities: int
    watchdog: int
    safe_duty: int


class Sample(NamedTuple):
    """Device to host: one measurement and the duty from then on.

    number: from 1, one more each sample; time: of the measurement on the device's clock [ns]; values: counts
    of each channel; valid: bits of the channels that could be read; duty: in force from `time` on;
    command: the sample that the command in force answers (0: none); source: of that command.
    """

    number: int
    time: int
    values: tuple[int, ...]
    valid: int
    duty: int
    command: int
    source: int
    flags: int


class Command(NamedTuple):
    """Host to device: duty that answers a sample (0: none in particular), and the road height [`ROAD_UNIT`]."""

    answers: int
    duty: int
    source: int
    flags: int
    road: int


class Sync(NamedTuple):
    """Host to device: the host's time [ns]."""

    sent: int


class SyncReply(NamedTuple):
    """Device to host, at once: the host's time as it came, the device's when it came and when this left [ns]."""

    asked: int
    received: int
    sent: int


class Call(NamedTuple):
    """Host to device: its nonce, to be answered."""

    host: bytes


class Answer(NamedTuple):
    """Device to host: the nonce it offers, and that of the call."""

    device: bytes
    host: bytes


class Open(NamedTuple):
    """Host to device: both nonces; the session begins."""

    device: bytes
    host: bytes


Message: TypeAlias = Hello | Sample | Command | Sync | SyncReply | Call | Answer | Open

_LAYOUTS: Final = {
    Kind.HELLO: struct.Struct("<IIHHIH"),
    Kind.SAMPLE: struct.Struct(f"<IQ{len(CHANNELS)}iHHIBB"),
    Kind.COMMAND: struct.Struct("<IHBBi"),
    Kind.SYNC: struct.Struct("<Q"),
    Kind.SYNC_REPLY: struct.Struct("<QQQ"),
    Kind.CALL: struct.Struct(f"<{seal.NONCE}s"),
    Kind.ANSWER: struct.Struct(f"<{seal.NONCE}s{seal.NONCE}s"),
    Kind.OPEN: struct.Struct(f"<{seal.NONCE}s{seal.NONCE}s"),
}
_KINDS: Final = {
    Hello: Kind.HELLO,
    Sample: Kind.SAMPLE,
    Command: Kind.COMMAND,
    Sync: Kind.SYNC,
    SyncReply: Kind.SYNC_REPLY,
    Call: Kind.CALL,
    Answer: Kind.ANSWER,
    Open: Kind.OPEN,
}
HANDSHAKE: Final = frozenset({int(Kind.CALL), int(Kind.ANSWER), int(Kind.OPEN)})
"""Kinds of version 2 alone, sealed with the shared key."""
SIZES: Final = {int(kind): layout.size for kind, layout in _LAYOUTS.items()}
"""Bytes of payload of each kind."""
LONGEST: Final = OVERHEAD + max(SIZES.values())
"""Bytes of the longest frame of version 1."""
_PLAIN: Final[dict[int, type[Sync | SyncReply | Call | Answer | Open]]] = {
    int(_KINDS[each]): each for each in (Sync, SyncReply, Call, Answer, Open)
}
"""Messages of which every content can be."""
FULL_DUTY: Final = round(1.0 / DUTY_UNIT)
_N: Final = len(CHANNELS)


class Frame(NamedTuple):
    """A frame whose CRC or tag was right: sequence number, what it says, and the key of its tag."""

    seq: int
    message: Message
    key: bytes = b""


def encode(message: Message, seq: int, key: bytes = b"") -> bytes:
    """Bytes of a frame; with a key one of version 2."""
    kind = _KINDS[type(message)]
    if isinstance(message, Sample):
        number, time, values, *rest = message
        payload = _LAYOUTS[kind].pack(number % WRAP, time, *values, *rest)
    else:
        payload = _LAYOUTS[kind].pack(*message)
    version = SEALED if key else VERSION
    whole = HEADER.pack(MARK, version, kind, len(payload), seq % WRAP) + payload
    body = whole[len(MARK) :]
    return whole + (seal.tag(key, body) if key else CRC.pack(crc32(body)))


def decode(kind: int, payload: bytes) -> Message | None:
    """What a payload of the right size says; None where it says what cannot be (a duty above one)."""
    if kind == Kind.SAMPLE:
        found = _LAYOUTS[Kind.SAMPLE].unpack(payload)
        sample = Sample(found[0], found[1], found[2 : 2 + _N], *found[2 + _N :])
        return sample if sample.duty <= FULL_DUTY else None
    values = _LAYOUTS[Kind(kind)].unpack(payload)
    if kind == Kind.COMMAND:
        return Command(*values) if values[1] <= FULL_DUTY else None
    if kind == Kind.HELLO:
        return Hello(*values) if values[1] > 0 and values[5] <= FULL_DUTY else None
    return _PLAIN[kind](*values)


def ahead(number: int, of: int) -> int:
    """How far a number that starts anew at `WRAP` is ahead of another; negative where it is behind."""
    return (number - of + WRAP // 2) % WRAP - WRAP // 2


def to_duty(units: int) -> float:
    """Duty [1] from the wire."""
    return units / FULL_DUTY


def from_duty(duty: float) -> int:
    """Duty within 0..1 for the wire."""
    return round(min(max(duty, 0.0), 1.0) * FULL_DUTY)


def from_height(height: float) -> int:
    """Road height [m] for the wire, as far as that reaches."""
    return min(max(round(height / ROAD_UNIT), -ROAD_REACH), ROAD_REACH)
