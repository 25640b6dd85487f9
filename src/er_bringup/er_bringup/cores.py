"""The cores of all nodes that have one: executable to its parameters and what makes it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from importlib import import_module
from typing import Any

from er_models.errors import UnknownName
from er_ros_common.core import Core

MODULES = (
    "er_observers.ros_observer",
    "er_observers.ros_faults",
    "er_ftc_controller.ros_skyhook",
    "er_ftc_controller.ros_ftc",
)
"""Each holds `CORES`: executable to (dataclass of its parameters, maker of the core)."""

Entry = tuple[type[Any], Callable[[Any], Core]]


def cores() -> Mapping[str, Entry]:
    """Every executable with a core."""
    found: dict[str, Entry] = {}
    for module in MODULES:
        found |= import_module(module).CORES
    return found


def entry(executable: str) -> Entry:
    """Parameters and maker of one.

    Raises:
        UnknownName: It has none.
    """
    known = cores()
    if executable not in known:
        raise UnknownName("node with a core", executable, tuple(sorted(known)))
    return known[executable]
