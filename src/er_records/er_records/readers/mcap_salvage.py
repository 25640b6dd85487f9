"""Messages out of a damaged MCAP file: everything up to the damage, and whole chunks behind it.

A recorder that was killed leaves no index and a cut last chunk; ordinary readers refuse such a
file. Record layout after the MCAP specification (https://mcap.dev/spec): opcode u8, length u64,
content; a chunk holds compressed records. A cut chunk is decompressed as far as it goes.
"""

from __future__ import annotations

import struct
import sys
from collections.abc import Iterator
from dataclasses import dataclass, field
from pathlib import Path

MAGIC = b"\x89MCAP0\r\n"
SCHEMA, CHANNEL, MESSAGE, CHUNK, DATA_END = 0x03, 0x04, 0x05, 0x06, 0x0F


@dataclass(slots=True)
class Salvage:
    """What came out: message definitions, messages, and what was lost on the way.

    Attributes:
        schemas: Schema id to (type name, encoding, definition text).
        channels: Channel id to (topic, schema id).
        messages: (topic, schema id, serialized message, time of arrival [ns]) in file order.
        damage: One sentence for each damaged place.
    """

    schemas: dict[int, tuple[str, str, str]] = field(default_factory=dict)
    channels: dict[int, tuple[str, int]] = field(default_factory=dict)
    messages: list[tuple[str, int, bytes, int]] = field(default_factory=list)
    damage: list[str] = field(default_factory=list)


def salvage(path: Path) -> Salvage:
    """All messages that can still be read; `ValueError` when the file is no MCAP at all."""
    data = path.read_bytes()
    if not data.startswith(MAGIC):
        raise ValueError("the file does not begin as an MCAP file")
    found = Salvage()
    for opcode, start, content in _records(data, len(MAGIC), found):
        if opcode == DATA_END:
            break
        if opcode == CHUNK:
            inner = _unpacked(content, start, found)
            for code, _, record in _records(inner, 0, None):
                _take(code, record, found)
        else:
            _take(opcode, content, found)
    return found


def _records(
    data: bytes, position: int, found: Salvage | None
) -> Iterator[tuple[int, int, bytes]]:
    """(opcode, offset, content) of each record; a cut chunk at the end is yielded cut."""
    while position < len(data):
        if position + 9 > len(data):
            _damaged(found, f"the file ends inside a record at byte {position}")
            return
        opcode, length = struct.unpack_from("<BQ", data, position)
        start, end = position + 9, position + 9 + length
        if end > len(data):
            _damaged(found, f"the file ends inside a record at byte {position}")
            if opcode == CHUNK:
                yield opcode, position, data[start:]
            return
        if opcode == 0:
            _damaged(found, f"no record at byte {position}")
            return
        yield opcode, position, data[start:end]
        position = end


def _damaged(found: Salvage | None, sentence: str) -> None:
    """Remember the damage; inside a chunk it was noted when the chunk was unpacked."""
    if found is not None:
        found.damage.append(sentence)


def _unpacked(chunk: bytes, start: int, found: Salvage) -> bytes:
    """The records of a chunk, as far as they can be decompressed."""
    try:
        (length,) = struct.unpack_from("<I", chunk, 28)
        compression = chunk[32 : 32 + length].decode()
        body = chunk[32 + length + 8 :]
        (size,) = struct.unpack_from("<Q", chunk, 16)
        inner = _decompressed(body, compression)
    except (struct.error, UnicodeDecodeError, ValueError) as error:
        found.damage.append(f"the chunk at byte {start} is unreadable ({error})")
        return b""
    if len(inner) != size:
        found.damage.append(f"the chunk at byte {start} gave {len(inner)} of {size} bytes")
    return inner


def _decompressed(body: bytes, compression: str) -> bytes:
    """As many bytes as the compressed body still yields."""
    if not compression:
        return body
    if compression == "lz4":
        import lz4.frame

        return _pieces(lz4.frame.LZ4FrameDecompressor(), body)
    if compression == "zstd":
        if sys.version_info >= (3, 14):
            from compression import zstd
        else:
            from backports import zstd
        return _pieces(zstd.ZstdDecompressor(), body)
    raise ValueError(f"compression '{compression}' is not known")


def _pieces(decompressor: object, body: bytes, step: int = 4096) -> bytes:
    """Decompress in small steps, so that an error late in the body costs only what follows it."""
    out = bytearray()
    for i in range(0, len(body), step):
        if decompressor.eof:  # type: ignore[attr-defined]
            break
        try:
            out += decompressor.decompress(body[i : i + step])  # type: ignore[attr-defined]
        except Exception:
            break
    return bytes(out)


def _take(opcode: int, content: bytes, found: Salvage) -> None:
    """Store a schema, channel or message record; others carry nothing needed here."""
    try:
        if opcode == SCHEMA:
            (number,) = struct.unpack_from("<H", content)
            name, at = _text(content, 2)
            encoding, at = _text(content, at)
            definition, _ = _text(content, at)
            found.schemas[number] = (name, encoding, definition)
        elif opcode == CHANNEL:
            number, schema = struct.unpack_from("<HH", content)
            found.channels[number] = (_text(content, 4)[0], schema)
        elif opcode == MESSAGE:
            number, _, arrival = struct.unpack_from("<HIQ", content)
            if number in found.channels:
                topic, schema = found.channels[number]
                found.messages.append((topic, schema, content[22:], arrival))
    except (struct.error, UnicodeDecodeError):
        found.damage.append(f"a record of kind {opcode} is garbled")


def _text(content: bytes, at: int) -> tuple[str, int]:
    """A length-prefixed string and the offset behind it."""
    (length,) = struct.unpack_from("<I", content, at)
    return content[at + 4 : at + 4 + length].decode(), at + 4 + length
