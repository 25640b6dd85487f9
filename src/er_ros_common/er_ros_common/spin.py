"""Running nodes: one way to spin, one way to start and to stop.

``executor.spin()`` of the events executor runs no callback at all in the PyPI wheels (rclpy
7.1.6), and the default executor costs two to six times the processor time; `spin` hides both.
"""

from __future__ import annotations

import gc
import os
import re
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from typing import TypeAlias

import rclpy
from er_models.errors import ErError
from er_models.one_line import BAD_USAGE
from rclpy.exceptions import ROSInterruptException
from rclpy.executors import Executor, ExternalShutdownException, SingleThreadedExecutor
from rclpy.node import Node
from rclpy.signals import SignalHandlerOptions
from rclpy.task import Future
from rclpy.utilities import remove_ros_args

from er_ros_common import environment
from er_ros_common.help import Card, render
from er_ros_common.intra_process import IntraProcess
from er_ros_common.managed import ManagedNode
from er_ros_common.parameter_files import check_files
from er_ros_common.private import RCLError, UnknownROSArgsError
from er_ros_common.stopping import Stopped

#: an idle node looks at its signals this often [s]
ATTENTION = 0.1
Nodes: TypeAlias = Node | Sequence[Node]


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
    each = _each(nodes)
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
        if not stopped.signal and not rclpy.ok():
            sys.stderr.write("the ROS context was shut down from elsewhere: this process ends\n")
        for node in each:
            executor.remove_node(node)
        executor.shutdown(timeout_sec=0.0)


@dataclass(frozen=True)
class Executable:
    """A program that is one node: how it is made (from its own command line, or the process's), and its card."""

    make: Callable[[Sequence[str] | None], Nodes]
    card: Card


def run(factory: Callable[..., Nodes], card: Card, args: Sequence[str] | None = None) -> int:
    """Main program of a node executable; returns the exit status.

    0 after SIGINT or SIGTERM, 2 with one line for bad usage or bad parameters, an `ErError`'s own
    status otherwise. A node may have a method ``on_stop()``: it is called before the node is
    destroyed, while it can still publish.
    """
    argv = list(sys.argv[1:] if args is None else args)
    if any(a in ("-h", "--help") for a in argv):
        show(render(card))
        return 0
    return guarded(card.program.name, argv, lambda stopped: _one(factory, argv, stopped))


def guarded(name: str, argv: Sequence[str], live: Callable[[Stopped], None]) -> int:
    """Do something under the signals; what is wrong is one line behind the name, and an exit status."""
    try:
        check_files(argv)
        environment.settle()
        with Stopped() as stopped:
            try:
                live(stopped)
            finally:
                rclpy.try_shutdown()
    except ErError as error:
        return _complain(name, str(error), error.exit_status)
    except UnknownROSArgsError as error:
        return _complain(name, f"unknown ROS argument {error}", BAD_USAGE)
    except RCLError as error:
        # where in rcl's sources it was found helps nobody
        return _complain(name, re.sub(r", at /\S+:\d+", "", str(error)), BAD_USAGE)
    finally:
        _let_go()
    return 0


def _let_go() -> None:
    """Destroy what is left of nodes: parts that hold one another keep the middleware's participant alive.

    One that lives until the process ends is taken down among its own threads, which hear of other processes that end
    just then: that aborted, or hung for good, once in some hundred stops of several nodes at once.
    """
    gc.unfreeze()
    gc.collect()


def _one(factory: Callable[[], Nodes], argv: Sequence[str], stopped: Stopped) -> None:
    """The node of an executable, with the whole command line of the process."""
    plain = remove_ros_args(["", *argv])[1:]
    if plain:
        raise ErError(
            f"unknown argument '{plain[0]}'; ROS arguments follow --ros-args, see --help"
        )
    rclpy.init(args=list(argv), signal_handler_options=SignalHandlerOptions.NO)
    live(factory, stopped)


def live(factory: Callable[[], Nodes], stopped: Stopped) -> None:
    """Make the nodes, start them, spin them, stop them."""
    each: list[Node] = []
    try:
        try:
            with stopped.making():
                each += _each(factory())
                _introduce(each)
                for node in each:
                    if isinstance(node, ManagedNode) and node.common.autostart:
                        node.start()
        except KeyboardInterrupt:
            return
        if not stopped.signal:
            first = each[0]
            spin(
                each,
                stopped,
                first.common.executor if isinstance(first, ManagedNode) else "events",
            )
    finally:
        for node in each:
            on_stop = getattr(node, "on_stop", None)
            if on_stop is not None:
                on_stop()
        for node in each:
            node.destroy_node()


def _introduce(nodes: Sequence[Node]) -> None:
    """Let several nodes hand messages to one another, but not where plain rclpy is asked for."""
    several = [node for node in nodes if isinstance(node, ManagedNode)]
    if len(several) > 1 and several[0].common.executor == "events":
        local = IntraProcess(several)
        for node in several:
            node.local = local


def _each(nodes: Nodes) -> list[Node]:
    return [nodes] if isinstance(nodes, Node) else list(nodes)


def show(text: str) -> None:
    """Print a text that somebody asked for."""
    try:
        print(text, flush=True)  # noqa: T201  (somebody asked for it)
    except OSError as error:
        # nothing must be left to flush at exit
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())
        if not isinstance(error, BrokenPipeError):  # a reader, head for instance, has seen enough
            sys.exit(f"standard output: {error.strerror}")


def _complain(name: str, text: str, status: int) -> int:
    line = " ".join(text.split())
    sys.stderr.write(f"{name}: {line}\n")
    return status
