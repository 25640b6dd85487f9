"""Entry points of executables: a program that is asked to end while it is imported ends quietly.

Importing a node takes seconds (ROS, NumPy, the compiler), and Python answers Ctrl-C in there with a
traceback. Nothing heavy may be imported here.
"""

from __future__ import annotations

import os
import signal
from collections.abc import Callable
from importlib import import_module
from types import FrameType


def program(module: str) -> Callable[[], None]:
    """What a console script calls: imports the module, then runs its ``main``."""

    def start() -> None:
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, _leave)
        import_module(module).main()

    return start


def _leave(_number: int, _: FrameType | None) -> None:
    """Nothing has begun yet, or everything is over."""
    os._exit(0)
