"""From bytes as they come to frames: ``step(state, data) -> (state, frames)``. Never raises.

After anything that is not a whole frame with the right CRC the search for the next mark begins one byte
later, so that a damaged length cannot swallow the frames behind it.
"""

from __future__ import annotations

from typing import NamedTuple
from zlib import crc32

from er_plant_sim.hardware.frame import CRC, HEADER, MARK, SIZES, VERSION, Frame, decode


class ParserState(NamedTuple):
    """Bytes that are not yet a frame, and counts since the start.

    frames: whole ones; skipped: bytes that belonged to none; damaged: marks with a wrong CRC; foreign:
    right CRC, but another version (`version` is the last one met) or a content that cannot be.
    """

    rest: bytes = b""
    frames: int = 0
    skipped: int = 0
    damaged: int = 0
    foreign: int = 0
    version: int = VERSION


def step(state: ParserState, data: bytes) -> tuple[ParserState, list[Frame]]:
    """Frames completed by these bytes, in order."""
    buffer = state.rest + data
    found: list[Frame] = []
    at, skipped, damaged, foreign, version = 0, 0, 0, 0, state.version
    end = len(buffer)
    while True:
        mark = _next_mark(buffer, at)
        skipped += mark - at
        at = mark
        if end - at < HEADER.size:
            break
        _, spoken, kind, size, seq = HEADER.unpack_from(buffer, at)
        if not _plausible(spoken, kind, size):
            at, skipped = at + 1, skipped + 1
            continue
        whole = at + HEADER.size + size + CRC.size
        if whole > end:
            break
        payload = buffer[at + HEADER.size : whole - CRC.size]
        if (
            crc32(buffer[at + len(MARK) : whole - CRC.size])
            != CRC.unpack_from(buffer, whole - CRC.size)[0]
        ):
            at, skipped, damaged = at + 1, skipped + 1, damaged + 1
            continue
        message = decode(kind, payload) if spoken == VERSION else None
        if message is None:
            foreign, version = foreign + 1, spoken
        else:
            found.append(Frame(seq, message))
        at = whole
    counts = (state.skipped + skipped, state.damaged + damaged, state.foreign + foreign)
    return ParserState(buffer[at:], state.frames + len(found), *counts, version), found


def flushed(state: ParserState) -> ParserState:
    """The state at the end of a datagram: what is left of it will not be completed."""
    return state._replace(rest=b"", skipped=state.skipped + len(state.rest))


def _next_mark(buffer: bytes, at: int) -> int:
    """Place of the next mark, or of what may be its first byte at the very end."""
    mark = buffer.find(MARK, at)
    if mark >= 0:
        return mark
    return len(buffer) - buffer.endswith(MARK[:1]) if len(buffer) > at else len(buffer)


def _plausible(version: int, kind: int, size: int) -> bool:
    """Whether a header may be one: kinds of this version have a fixed size, others are at most that long."""
    if version == VERSION:
        return SIZES.get(kind) == size
    return version > 0 and kind in SIZES and size <= LARGEST_PAYLOAD


LARGEST_PAYLOAD = 256
"""Bytes; a header of another version that names more is taken for noise."""
