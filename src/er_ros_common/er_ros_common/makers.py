"""Makers and readers of messages, without what is generated for them, which takes longer than all else that is done.

A generated constructor imports its parts anew each time, makes each default twice and sends every value through a
setter. Here a function is written out for a type, as `dataclasses` does, that sets the slots of a message and of its
header one by one: a sixth of the time. Where ROS 2 is asked to check fields it goes by the setters, which do.
A field is read through a property, a call in Python each time; the slots behind them are read in one.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from operator import attrgetter
from typing import Any

_PLAIN = (bool, int, float, str, bytes)
_STAMP = ("sec", "nanosec")


def maker(kind: type[Any], fields: Sequence[str]) -> Callable[..., Any]:
    """Makes messages of a type from seconds and nanoseconds of their stamp, then the values of these fields in order.

    Other fields are as the constructor makes them; types are not looked at.

    Raises:
        TypeError: A field holds what two messages must not share (a list, say).
        AttributeError: There is no such field.
    """
    return written(kind(), fields)


def written(first: Any, fields: Sequence[str]) -> Callable[..., Any]:
    """The maker of messages like this one."""
    made: list[str] = []
    known: dict[str, Any] = {}

    def copy(message: Any, name: str, given: Sequence[str]) -> None:
        """Statements that make a copy of a message under a name, given some of its fields."""
        known[f"{name}__kind"], known[f"{name}__new"] = type(message), type(message).__new__
        made.append(f"{name} = {name}__new({name}__kind)")
        made.append(f"{name}._check_fields = {message._check_fields}")
        dash = "" if message._check_fields else "_"
        for field in message.get_fields_and_field_types():
            value, source = getattr(message, field), f"{name}_{field}"
            if hasattr(type(value), "SLOT_TYPES"):
                copy(value, source, _STAMP if field == "stamp" else ())
            elif field in given:
                source = field
            elif isinstance(value, _PLAIN):
                known[source] = value
            else:
                raise TypeError(f"{type(message).__name__}.{field} is {type(value).__name__}")
            made.append(f"{name}.{dash}{field} = {source}")

    for field in fields:
        getattr(first, field)
    copy(first, "message", fields)
    text = [f"def make({', '.join((*_STAMP, *fields))}):", *made, "return message"]
    exec("\n    ".join(text), known)
    make: Callable[..., Any] = known["make"]
    return make


def reader(kind: type[Any], fields: Sequence[str]) -> Callable[[Any], tuple[Any, ...]]:
    """Reads seconds and nanoseconds of the stamp of messages of a type, then the values of these fields in order.

    Raises:
        AttributeError: There is no such field, or no header.
    """
    slots = [f"_header._stamp._{part}" for part in _STAMP]
    read = attrgetter(*slots, *(f"_{field}" for field in fields))
    read(kind())
    return read
