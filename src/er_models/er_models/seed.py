"""Seeds as command lines take them."""

from __future__ import annotations

from argparse import ArgumentTypeError
from collections.abc import Callable

LARGEST = 2**32 - 1
"""Largest seed that every generator of random numbers takes."""
OF_A_PLANT = 2**31
"""Largest seed that a plant's parameter takes."""


def seed_reader(largest: int = LARGEST) -> Callable[[object], int]:
    """What reads a seed from 0 to the largest one that a command takes; it raises what argparse tells in one line."""

    def read(text: object) -> int:
        try:
            value = int(str(text))
        except ValueError:
            value = -1
        if not 0 <= value <= largest:
            raise ArgumentTypeError(f"expected a whole number from 0 to {largest}, found {text}")
        return value

    return read
