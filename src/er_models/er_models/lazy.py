"""Names of a package that are imported when somebody asks for them (PEP 562), so that importing it costs nothing."""

from __future__ import annotations

import sys
from collections.abc import Callable, Mapping, Sequence
from importlib import import_module
from typing import Any

Lazy = tuple[list[str], Callable[[str], Any], Callable[[], list[str]]]


def lazy(package: str, homes: Mapping[str, Sequence[str]]) -> Lazy:
    """`__all__`, `__getattr__` and `__dir__` of a package.

    homes: module, in full, to the names that it holds. Asking for any other raises `AttributeError` as ever.
    """
    home = {name: module for module, names in homes.items() for name in names}
    every = sorted(home)

    def get(name: str) -> Any:
        if name not in home:
            raise AttributeError(f"module '{package}' has no attribute '{name}'")
        found = getattr(import_module(home[name]), name)
        setattr(sys.modules[package], name, found)  # the next time it is there at once
        return found

    return every, get, lambda: every
