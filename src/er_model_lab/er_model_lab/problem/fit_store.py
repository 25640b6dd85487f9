"""Fits that were made once are found again, to the last bit: what an interrupted search goes on from.

Of a fit only its values are noted and where its derivatives were taken; one batch of predictions makes the rest anew.
"""

from __future__ import annotations

import base64
import hashlib
import json
import zlib
from collections.abc import Iterable
from dataclasses import asdict, dataclass
from typing import Any

import numpy as np
from numpy.typing import NDArray

LENGTH = 16
"""Digits of a key."""


@dataclass(frozen=True)
class Noted:
    """A fit: scaled values, those at which the derivatives were taken, whether none was taken over, iterations.

    about: scaled values near which they were, in longer steps; empty: in the usual ones.
    """

    theta: list[float]
    at: list[float]
    exact: bool
    iterations: int
    about: list[float]


Notes = dict[str, Noted]
"""Fits by what they began with."""


def key(arrays: Iterable[NDArray[Any] | None], rest: object) -> str:
    """Hash of all that decides a fit: data, prediction at the start and derivatives as arrays, and the rest."""
    digest = hashlib.sha256(repr(rest).encode())
    for each in arrays:
        digest.update(b"none" if each is None else np.ascontiguousarray(each).tobytes())
    return digest.hexdigest()[:LENGTH]


def packed(notes: Notes) -> str:
    """Notes as one word."""
    text = json.dumps({k: list(asdict(n).values()) for k, n in dict(notes).items()})
    return base64.b64encode(zlib.compress(text.encode(), 9)).decode()


def unpacked(word: str) -> Notes:
    """Notes from one word; ValueError where it holds none."""
    try:
        text = json.loads(zlib.decompress(base64.b64decode(word, validate=True)))
        return {str(k): Noted(*values) for k, values in text.items()}
    except (zlib.error, AttributeError, TypeError) as error:
        raise ValueError("no notes of fits") from error
