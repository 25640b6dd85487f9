"""Frames of the wire between host and rig, version 1: header, payload, CRC. docs/hardware.md shows them.

    offset  size  field
    0       2     mark, 0xA5 0x5A
    2       1     version of the protocol
    3       1     kind of the frame
    4       2     bytes of payload
    6       4     sequence number of the sender, one more each frame
    10      n     payload
    10 + n  4     CRC-32 (IEEE 802.3) of everything after the mark

All numbers are integers, lowest byte first, so that no NaN can travel.
"""

from __future__ import annotations

import struct
from enum import IntEnum
from typing import Final, NamedTuple, TypeAlias
from zlib import crc32

VERSION: Final = 1
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


Message: TypeAlias = Hello | Sample | Command | Sync | SyncReply

_LAYOUTS: Final = {
    Kind.HELLO: struct.Struct("<IIHHIH"),
    Kind.SAMPLE: struct.Struct(f"<IQ{len(CHANNELS)}iHHIBB"),
    Kind.COMMAND: struct.Struct("<IHBBi"),
    Kind.SYNC: struct.Struct("<Q"),
    Kind.SYNC_REPLY: struct.Struct("<QQQ"),
}
_KINDS: Final = {
    Hello: Kind.HELLO,
    Sample: Kind.SAMPLE,
    Command: Kind.COMMAND,
    Sync: Kind.SYNC,
    SyncReply: Kind.SYNC_REPLY,
}
SIZES: Final = {int(kind): layout.size for kind, layout in _LAYOUTS.items()}
"""Bytes of payload of each kind."""
LONGEST: Final = OVERHEAD + max(SIZES.values())
"""Bytes of the longest frame."""
FULL_DUTY: Final = round(1.0 / DUTY_UNIT)
_N: Final = len(CHANNELS)


class Frame(NamedTuple):
    """A frame whose CRC was right: sequence number and what it says."""

    seq: int
    message: Message


def encode(message: Message, seq: int) -> bytes:
    """Bytes of a frame."""
    kind = _KINDS[type(message)]
    if isinstance(message, Sample):
        number, time, values, *rest = message
        payload = _LAYOUTS[kind].pack(number % WRAP, time, *values, *rest)
    else:
        payload = _LAYOUTS[kind].pack(*message)
    head = HEADER.pack(MARK, VERSION, kind, len(payload), seq % WRAP)
    return head + payload + CRC.pack(crc32(payload, crc32(head[2:])))


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
    return Sync(*values) if kind == Kind.SYNC else SyncReply(*values)


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
