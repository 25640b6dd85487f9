"""What a bad wire does to frames: loss, corruption, delay; drawn from a seed and the frame's place alone."""

from __future__ import annotations

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np


@dataclass(frozen=True, slots=True)
class Wire:
    """Shares of frames lost and damaged [1], mean of the exponential delay [s]; ordered: none overtakes."""

    loss: float = 0.0
    corruption: float = 0.0
    jitter: float = 0.0
    ordered: bool = True
    seed: int = 0


class WireState(NamedTuple):
    """Pieces given in so far, and when the last of them comes out [ns]."""

    given: int = 0
    last: int = 0


def step(
    p: Wire, state: WireState, data: bytes, now: int
) -> tuple[WireState, tuple[int, bytes] | None]:
    """When [ns] and how a piece comes out at the other end; None where it does not."""
    count = state.given + 1
    if not (p.loss or p.corruption or p.jitter):
        return WireState(count, now), (now, data)
    draw = np.random.Generator(np.random.Philox(key=p.seed, counter=[0, 0, 0, count]))
    lost, damaged = draw.random(2) < (p.loss, p.corruption)
    if lost or not data:
        return state._replace(given=count), None
    due = now + round(1e9 * p.jitter * draw.exponential()) if p.jitter else now
    if p.ordered:
        due = max(due, state.last)
    return WireState(count, due), (due, damage(data, draw) if damaged else data)


def damage(data: bytes, draw: np.random.Generator) -> bytes:
    """The piece with one to eight bits turned over, or bytes missing, or bytes too many."""
    kind, at = draw.integers(3), int(draw.integers(len(data)))
    if kind == 0:
        bits = bytearray(data)
        for place in draw.integers(8 * len(data), size=int(draw.integers(1, 9))):
            bits[place // 8] ^= 1 << place % 8
        return bytes(bits)
    length = int(draw.integers(1, 5))
    if kind == 1:
        return data[:at] + data[at + length :]
    return data[:at] + draw.bytes(length) + data[at:]
