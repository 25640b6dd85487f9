"""Entry points of programs: one that is asked to end while it is imported ends quietly.

Importing a node takes seconds (ROS, NumPy, the compiler), and Python answers Ctrl-C in there with a
traceback. Nothing may be imported here before the signals are taken.
"""

from __future__ import annotations

import os
import signal
import sys
from collections.abc import Callable
from functools import partial
from importlib import import_module
from types import FrameType
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from er_common.program import Program


def starter(package: str) -> Callable[[str], Callable[[], None]]:
    """`__getattr__` of a module that holds, under its name, the console script of each program of a package."""

    def named(name: str) -> Callable[[], None]:
        if name.startswith("_"):
            raise AttributeError(name)
        return partial(start, package, name)

    return named


def start(package: str, name: str) -> None:
    """What a console script calls; raises `KeyError` where the package has no such program."""
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, _leave)
    # a second thread of BLAS spins on a core of its own for the few products of a tick
    os.environ.setdefault("OPENBLAS_NUM_THREADS", "1")
    try:
        programs = import_module(f"{package}.programs").PROGRAMS
        run({program.name: program for program in programs}[name])
    except ModuleNotFoundError as error:
        from er_common.keys import lacking

        line = lacking(name, error)
        if not line:
            raise
        sys.stderr.write(f"{line}\n")
        sys.exit(2)
    finally:
        # the interpreter gives signals their default back while it is taken down, but not to those that are ignored
        for number in (signal.SIGINT, signal.SIGTERM):
            signal.signal(number, signal.SIG_IGN)


def run(program: Program) -> None:
    """Import what a program is made of, and run it."""
    if program.core:
        from er_ros_common.core_node import main

        main(program)
    else:
        import_module(program.path).main()


def _leave(_number: int, _: FrameType | None) -> None:
    """Nothing has begun yet, or everything is over."""
    os._exit(0)
