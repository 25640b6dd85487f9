"""From bytes as they come to frames: ``step(state, data, keys) -> (state, frames)``. Never raises.

With keys a frame is one of version 2 whose tag is right under one of them, without any one of version 1 whose CRC is
right. After anything that is not a whole frame the search for the next mark begins one byte
later, so that a damaged length cannot swallow the frames behind it.
"""

from __future__ import annotations

from typing import NamedTuple
from zlib import crc32

from er_plant_sim.hardware import seal
from er_plant_sim.hardware.frame import (
    CRC,
    HANDSHAKE,
    HEADER,
    MARK,
    SEALED,
    SIZES,
    VERSION,
    Frame,
    decode,
)


class ParserState(NamedTuple):
    """Bytes that are not yet a frame, and counts since the start.

    frames: whole ones; skipped: bytes that belonged to none; damaged: marks with a wrong CRC or tag; foreign:
    right CRC or tag, but another version (`version` is the last one met) or a content that cannot be.
    """

    rest: bytes = b""
    frames: int = 0
    skipped: int = 0
    damaged: int = 0
    foreign: int = 0
    version: int = VERSION


def step(
    state: ParserState, data: bytes, keys: tuple[bytes, ...] = ()
) -> tuple[ParserState, list[Frame]]:
    """Frames completed by these bytes, in order; keys: that of the handshake, then those of sessions."""
    buffer = state.rest + data
    found: list[Frame] = []
    at, skipped, damaged, foreign, version = 0, 0, 0, 0, state.version
    own, end = SEALED if keys else VERSION, len(buffer)
    while True:
        mark = _next_mark(buffer, at)
        skipped += mark - at
        at = mark
        if end - at < HEADER.size:
            break
        _, spoken, kind, size, seq = HEADER.unpack_from(buffer, at)
        if not _plausible(own, spoken, kind, size):
            at, skipped = at + 1, skipped + 1
            continue
        close = at + HEADER.size + size
        whole = close + (seal.TAG if spoken == own == SEALED else CRC.size)
        if whole > end:
            break
        key = _key(
            keys if spoken == own else (),
            kind,
            buffer[at + len(MARK) : close],
            buffer[close:whole],
        )
        if key is None:
            at, skipped, damaged = at + 1, skipped + 1, damaged + 1
            continue
        message = decode(kind, buffer[at + HEADER.size : close]) if spoken == own else None
        if message is None:
            foreign, version = foreign + 1, spoken
        else:
            found.append(Frame(seq, message, key))
        at = whole
    counts = (state.skipped + skipped, state.damaged + damaged, state.foreign + foreign)
    return ParserState(buffer[at:], state.frames + len(found), *counts, version), found


def _key(keys: tuple[bytes, ...], kind: int, body: bytes, close: bytes) -> bytes | None:
    """The key of a frame's tag, empty where it has a CRC; None where what closes it is wrong."""
    if not keys:
        return b"" if crc32(body) == CRC.unpack(close)[0] else None
    return seal.fitting(keys[:1] if kind in HANDSHAKE else keys[1:], body, close)


def flushed(state: ParserState) -> ParserState:
    """The state at the end of a datagram: what is left of it will not be completed."""
    return state._replace(rest=b"", skipped=state.skipped + len(state.rest))


def _next_mark(buffer: bytes, at: int) -> int:
    """Place of the next mark, or of what may be its first byte at the very end."""
    mark = buffer.find(MARK, at)
    if mark >= 0:
        return mark
    return len(buffer) - buffer.endswith(MARK[:1]) if len(buffer) > at else len(buffer)


def _plausible(own: int, version: int, kind: int, size: int) -> bool:
    """Whether a header may be one: kinds of our own version have a fixed size, others are at most that long."""
    if version == own:
        return SIZES.get(kind) == size and (own == SEALED or kind not in HANDSHAKE)
    return version > 0 and kind in SIZES and size <= LARGEST_PAYLOAD


LARGEST_PAYLOAD = 256
"""Bytes; a header of another version that names more is taken for noise."""
