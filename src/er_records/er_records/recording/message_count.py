"""Counts what a topic lost, from the sequence numbers in serialized messages. Pure.

Every message of this project begins with a header and a sequence number, so both can be read
without decoding the rest: after four bytes that name the encoding come the seconds (4 bytes), the
nanoseconds (4), the frame's length (4) and text, and, aligned to 8 bytes, the sequence number (8).
"""

from __future__ import annotations

import struct
from typing import NamedTuple

_ORDER = {0: ">", 1: "<"}
_START = 4
"""Bytes before the first field; alignment counts from there."""


class Header(NamedTuple):
    """Time of measurement [ns] and sequence number of a message."""

    stamp: int
    seq: int


class Count(NamedTuple):
    """Of one topic: last sequence number; messages received, lost, repeated; restarts."""

    last: int = 0
    received: int = 0
    lost: int = 0
    repeated: int = 0
    restarts: int = 0


def header_of(data: bytes) -> Header | None:
    """Header and sequence number of a serialized message; None if it is too short."""
    if len(data) < _START + 12 or data[1] not in _ORDER:
        return None
    order = _ORDER[data[1]]
    second, nano, length = struct.unpack_from(f"{order}iII", data, _START)
    at = _START + (12 + length + 7) // 8 * 8
    if at + 8 > len(data):
        return None
    (seq,) = struct.unpack_from(f"{order}Q", data, at)
    return Header(second * 1_000_000_000 + nano, seq)


def count(state: Count, seq: int) -> Count:
    """Take one message; a number that falls back to the start is a sender that began anew."""
    state = state._replace(received=state.received + 1)
    if seq == 0:
        return state
    if state.last == 0 or seq == state.last + 1:
        return state._replace(last=seq)
    if seq > state.last:
        return state._replace(last=seq, lost=state.lost + seq - state.last - 1)
    if seq == state.last or state.last - seq < RESTART:
        return state._replace(repeated=state.repeated + 1)
    return state._replace(last=seq, restarts=state.restarts + 1)


RESTART = 20
"""A number further back than this is a restart, not a repeated or late message."""
