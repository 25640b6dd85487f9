"""New messages without their constructors, which take longer than filling a message does.

A generated constructor imports its parts anew each time, makes each default twice and sends every zero through a
setter. Here the slots of one message that was constructed are copied; messages in it (header, stamp) are copied too.
"""

from __future__ import annotations

from collections.abc import Callable
from typing import Any, TypeVar

M = TypeVar("M")
_KNOWN: dict[type[Any], Callable[[], Any]] = {}
_PLAIN = (bool, int, float, str, bytes)


def blank(kind: type[M]) -> M:
    """A message of a type, as its constructor without arguments makes it."""
    maker = _KNOWN.get(kind)
    if maker is None:
        maker = _KNOWN[kind] = _maker(kind)
    made: M = maker()
    return made


def _maker(kind: type[Any]) -> Callable[[], Any]:
    """Makes messages of a type; its constructor, where a message holds what cannot be shared nor copied here."""
    first = kind()
    values = {slot: getattr(first, slot) for slot in kind.__slots__}
    inner = {slot: type(v) for slot, v in values.items() if hasattr(type(v), "SLOT_TYPES")}
    plain = [(slot, value) for slot, value in values.items() if slot not in inner]
    if not all(isinstance(value, _PLAIN) for _, value in plain):
        return kind
    nested = [(slot, _maker(each)) for slot, each in inner.items()]
    new: Any = kind.__new__

    def make() -> Any:
        message = new(kind)
        for slot, value in plain:
            setattr(message, slot, value)
        for slot, part in nested:
            setattr(message, slot, part())
        return message

    return make
