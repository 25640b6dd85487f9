"""What many jobs share, sent to a process once."""

from __future__ import annotations

import pickle
from dataclasses import dataclass
from typing import Any
from uuid import uuid4

_opened: dict[str, tuple[Any, ...]] = {}
"""What this process was sent last."""


@dataclass(frozen=True)
class Parcel:
    """Arguments that many jobs share; `packed` makes one that other processes can open."""

    content: tuple[Any, ...]
    name: str = ""
    sealed: bytes = b""

    def __reduce__(self) -> tuple[Any, ...]:
        return _open, (self.name, self.sealed)


def packed(content: tuple[Any, ...]) -> Parcel | None:
    """Arguments for other processes; None where they cannot be sent."""
    try:
        sealed = pickle.dumps(content, pickle.HIGHEST_PROTOCOL)
    except (pickle.PicklingError, TypeError, AttributeError):
        return None
    return Parcel(content, uuid4().hex, sealed)


def _open(name: str, sealed: bytes) -> Parcel:
    """A parcel where it has arrived; what came before is thrown away."""
    if name not in _opened:
        _opened.clear()
        _opened[name] = pickle.loads(sealed)
    return Parcel(_opened[name], name)
