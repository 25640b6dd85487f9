"""Running nodes: one way to spin, one way to start and to stop.

``executor.spin()`` of the events executor runs no callback at all in the PyPI wheels (rclpy
7.1.6), and the default executor costs two to six times the processor time; `spin` hides both.
"""

from __future__ import annotations

import gc
import os
import re
import signal
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from time import monotonic
from types import FrameType
from typing import Any, TypeAlias

import rclpy
from er_models.errors import ErError
from rclpy._rclpy_pybind11 import RCLError, UnknownROSArgsError
from rclpy.exceptions import ROSInterruptException
from rclpy.executors import Executor, ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future
from rclpy.utilities import remove_ros_args

from er_ros_common.help import Card, render
from er_ros_common.parameter_files import check_files

#: an idle node looks at its signals this often [s]
ATTENTION = 0.1
#: one wish to stop may arrive as several signals: a dying parent's threads each send theirs, a
#: terminal and a supervisor both pass Ctrl-C on. What follows the first this soon is the same [s]
SAME_WISH = 1.0
#: a node that is still being made is told again this often that it shall end: code that runs when the
#: compiler tidies up swallows exceptions [s]
TOLD_AGAIN = 0.2
BAD_USAGE = 2
Nodes: TypeAlias = Node | Sequence[Node]


class Stopped:
    """Set by the first SIGINT or SIGTERM; one that follows later ends the process at once.

    What is done under `making` gets KeyboardInterrupt too: nodes that compile take long.
    """

    def __init__(self) -> None:
        """Nothing has arrived yet."""
        self.signal, self._since = 0, 0.0
        self._making = False
        self._before: dict[int, Any] = {}

    def __enter__(self) -> Stopped:
        """Start to watch."""
        for number in (signal.SIGINT, signal.SIGTERM):
            self._before[number] = signal.signal(number, self._on_signal)
        return self

    def __exit__(self, *_: object) -> None:
        """Give the signals back."""
        for number, handler in self._before.items():
            signal.signal(number, handler)

    @contextmanager
    def making(self) -> Iterator[None]:
        """A signal raises KeyboardInterrupt in here, again and again until it gets out."""
        alarm = signal.signal(signal.SIGALRM, self._on_alarm)
        hook, sys.unraisablehook = sys.unraisablehook, _quiet(sys.unraisablehook)
        self._making = True
        try:
            yield
        finally:
            self._making = False
            signal.setitimer(signal.ITIMER_REAL, 0.0)
            signal.signal(signal.SIGALRM, alarm)
            sys.unraisablehook = hook

    def _on_alarm(self, _number: int, _: FrameType | None) -> None:
        if self._making:
            raise KeyboardInterrupt

    def _on_signal(self, number: int, _: FrameType | None) -> None:
        if not self.signal:
            self.signal, self._since = number, monotonic()
            if self._making:
                signal.setitimer(signal.ITIMER_REAL, TOLD_AGAIN, TOLD_AGAIN)
                raise KeyboardInterrupt
        elif monotonic() - self._since > SAME_WISH:
            signal.signal(number, signal.SIG_DFL)
            signal.raise_signal(number)


def make_executor(node: Node, kind: str = "events") -> Executor:
    """Events executor where there is one, else the single-threaded one with one line saying so."""
    if kind == "events":
        try:
            from rclpy.experimental.events_executor import EventsExecutor
        except ImportError:
            node.get_logger().info(
                "no events executor in this rclpy: using the single-threaded one"
            )
        else:
            return EventsExecutor()
    return SingleThreadedExecutor()


def spin(nodes: Nodes, stopped: Stopped | None = None, kind: str = "events") -> None:
    """Run callbacks until a signal arrives or the context ends; returns, whichever it was.

    Args:
        nodes: one node or several that share one thread.
        stopped: signals to look at; None watches SIGINT and SIGTERM itself (main thread only).
        kind: "events" or "single".
    """
    if stopped is None:
        with Stopped() as own:
            spin(nodes, own, kind)
        return
    each = [nodes] if isinstance(nodes, Node) else list(nodes)
    executor = make_executor(each[0], kind)
    for node in each:
        executor.add_node(node)
    # what was made so far stays for good: the collector need not look at it in the loop
    gc.collect()
    gc.freeze()
    try:
        while not stopped.signal and rclpy.ok():
            # a new one each time: every call hangs one more callback on the future it is given
            executor.spin_until_future_complete(Future(), timeout_sec=ATTENTION)
    except (ExternalShutdownException, ROSInterruptException, KeyboardInterrupt):
        pass
    except RCLError:
        # the context may end while a callback publishes
        if rclpy.ok():
            raise
    finally:
        for node in each:
            executor.remove_node(node)
        executor.shutdown(timeout_sec=0.0)


def run(factory: Callable[[], Nodes], card: Card, args: Sequence[str] | None = None) -> int:
    """Main program of a node executable; returns the exit status.

    0 after SIGINT or SIGTERM, 2 with one line for bad usage or bad parameters, an `ErError`'s own
    status otherwise. A node may have a method ``on_stop()``: it is called before the node is
    destroyed, while it can still publish.
    """
    argv = list(sys.argv[1:] if args is None else args)
    if any(a in ("-h", "--help") for a in argv):
        show(render(card))
        return 0
    try:
        check_files(argv)
        plain = remove_ros_args(["", *argv])[1:]
        if plain:
            raise ErError(
                f"unknown argument '{plain[0]}'; ROS arguments follow --ros-args, see --help"
            )
        with Stopped() as stopped:
            rclpy.init(args=argv, signal_handler_options=SignalHandlerOptions.NO)
            try:
                _live(factory, stopped)
            finally:
                rclpy.try_shutdown()
    except ErError as error:
        return _complain(card, str(error), error.exit_status)
    except UnknownROSArgsError as error:
        return _complain(card, f"unknown ROS argument {error}", BAD_USAGE)
    except RCLError as error:
        # where in rcl's sources it was found helps nobody
        return _complain(card, re.sub(r", at /\S+:\d+", "", str(error)), BAD_USAGE)
    return 0


def _live(factory: Callable[[], Nodes], stopped: Stopped) -> None:
    """Make the nodes, spin them, stop them."""
    try:
        with stopped.making():
            made = factory()
    except KeyboardInterrupt:
        return
    each = [made] if isinstance(made, Node) else list(made)
    try:
        if not stopped.signal:
            spin(each, stopped)
    finally:
        for node in each:
            on_stop = getattr(node, "on_stop", None)
            if on_stop is not None:
                on_stop()
        for node in each:
            node.destroy_node()


def _quiet(hook: Callable[[Any], object]) -> Callable[[Any], object]:
    """The hook for exceptions that nobody can catch, without those that were raised to be told again."""

    def unless_told_again(unraisable: Any) -> object:
        return None if unraisable.exc_type is KeyboardInterrupt else hook(unraisable)

    return unless_told_again


def show(text: str) -> None:
    """Print a text that somebody asked for."""
    try:
        print(text, flush=True)  # noqa: T201  (somebody asked for it)
    except BrokenPipeError:
        # the reader, head for instance, has seen enough: nothing must be left to flush at exit
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def _complain(card: Card, text: str, status: int) -> int:
    line = " ".join(text.split())
    sys.stderr.write(f"{card.executable}: {line}\n")
    return status
