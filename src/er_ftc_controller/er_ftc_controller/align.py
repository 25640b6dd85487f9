"""Joins two topics of the same tick by their time of measurement, whichever comes first.

ARCHITECTURE.md compares this with the other two ways to join a tick.
"""

from __future__ import annotations

from collections.abc import Mapping
from types import MappingProxyType
from typing import Any, Generic, NamedTuple, TypeVar

A = TypeVar("A")
B = TypeVar("B")

DEPTH = 20
"""Ticks kept while their partner is missing: 0.1 s at 200 Hz."""


_NONE: Mapping[int, Any] = MappingProxyType({})


class Aligner(NamedTuple, Generic[A, B]):
    """Values that wait for their partner, by stamp [ns]; and how many never met it.

    Where the time of a side has jumped back, what waits there is of another past and forgotten.
    """

    left: Mapping[int, A] = _NONE
    right: Mapping[int, B] = _NONE
    unmatched: int = 0

    def with_left(
        self, stamp: int, value: A, *, back: bool = False
    ) -> tuple[Aligner[A, B], tuple[A, B] | None]:
        """Take a left value; the pair if its partner is there already."""
        if stamp in self.right:
            partner = self.right[stamp]
            return self._after(stamp), (value, partner)
        left, lost = _kept(self.left, stamp, value, back=back)
        return Aligner(left, self.right, self.unmatched + lost), None

    def with_right(
        self, stamp: int, value: B, *, back: bool = False
    ) -> tuple[Aligner[A, B], tuple[A, B] | None]:
        """Take a right value; the pair if its partner is there already."""
        if stamp in self.left:
            partner = self.left[stamp]
            return self._after(stamp), (partner, value)
        right, lost = _kept(self.right, stamp, value, back=back)
        return Aligner(self.left, right, self.unmatched + lost), None

    def _after(self, stamp: int) -> Aligner[A, B]:
        """What still waits once a pair was found: anything older never meets its partner."""
        left = {k: v for k, v in self.left.items() if k > stamp}
        right = {k: v for k, v in self.right.items() if k > stamp}
        # but its partner
        old = len(self.left) - len(left) + len(self.right) - len(right) - 1
        return Aligner(left, right, self.unmatched + old)


def _kept(
    before: Mapping[int, A], stamp: int, value: A, *, back: bool
) -> tuple[dict[int, A], int]:
    """The newest `DEPTH` values with one more, and how many were dropped."""
    if back:
        return {stamp: value}, len(before)
    waiting = {**before, stamp: value}
    if len(waiting) <= DEPTH:
        return waiting, 0
    extra = sorted(waiting)[:-DEPTH]
    return {k: v for k, v in waiting.items() if k not in extra}, len(extra)
