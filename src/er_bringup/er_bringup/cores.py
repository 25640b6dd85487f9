"""The cores of nodes, by executable."""

from __future__ import annotations

from er_models.errors import UnknownName
from er_ros_common.core import Shell, shell_of

from er_bringup.programs import CORES


def entry(executable: str) -> Shell:
    """Parameters and maker of one.

    Raises:
        UnknownName: It has none.
    """
    if executable not in CORES:
        raise UnknownName("node with a core", executable, tuple(sorted(CORES)))
    return shell_of(CORES[executable])
