"""Keys and tags of the wire: BLAKE2s (RFC 7693) with a key, in place of the CRC. Pure.

The key that host and device share seals the handshake alone. Each session has two keys of its own, one a direction,
made of the nonces of both sides: a frame of another session, or one that is sent back, fits neither.
"""

from __future__ import annotations

from hashlib import blake2s
from secrets import compare_digest
from typing import Final, NamedTuple

KEY: Final = 32
"""Bytes of the shared key."""
SEED: Final = 16
"""Bytes from which a side makes its nonces; drawn at random at each start."""
NONCE: Final = 8
"""Bytes of a nonce; no side uses one twice."""
TAG: Final = 8
"""Bytes of a tag: one of 2^64 forged frames passes, and a forger learns of it on the wire alone."""
SESSION: Final = b"er session"
"""What the keys of a session begin with, so that nothing else is made of the same bytes."""


class Keys(NamedTuple):
    """Keys of a session, of what the host sends and of what the device sends; empty where there is none."""

    host: bytes = b""
    device: bytes = b""


def tag(key: bytes, body: bytes) -> bytes:
    """Tag of a frame's bytes between mark and tag."""
    return blake2s(body, key=key, digest_size=TAG).digest()


def fitting(keys: tuple[bytes, ...], body: bytes, found: bytes) -> bytes | None:
    """The key under which a tag is right; None where it is under none."""
    for key in keys:
        if compare_digest(tag(key, body), found):
            return key
    return None


def session_keys(key: bytes, device: bytes, host: bytes) -> Keys:
    """The keys that follow from the shared one and the nonces of device and host."""
    made = blake2s(SESSION + device + host, key=key, digest_size=32).digest()
    return Keys(made[:16], made[16:])


def nonce(seed: bytes, count: int) -> bytes:
    """The nonce of this number; another seed gives others."""
    return blake2s(count.to_bytes(8, "little"), key=seed, digest_size=NONCE).digest()
