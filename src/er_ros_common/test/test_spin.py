"""Nodes as processes: they run, cost little, stop cleanly, refuse bad parameters in one line."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
import time
from collections.abc import Iterator
from pathlib import Path

import pytest
import rclpy
from er_ros_common.clock import wall_timer
from rcl_interfaces.srv import DescribeParameters, SetParameters
from rclpy.node import Node
from rclpy.parameter import Parameter
from rclpy.task import Future

from er_ros_common import entry
from er_ros_common import spin as spin_module

pytestmark = pytest.mark.alone

NODE = Path(__file__).with_name("demo_node.py")
DOMAIN = str(150 + os.getpid() % 50)

BLAS = "OPENBLAS_NUM_THREADS"


def start(*args: str) -> subprocess.Popen[str]:
    """The demo node as a process, ready to run."""
    env = os.environ | {"ROS_DOMAIN_ID": DOMAIN, "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    return subprocess.Popen(
        [sys.executable, str(NODE), *args],
        stdout=subprocess.PIPE,
        stderr=subprocess.PIPE,
        text=True,
        env=env,
    )


def wait_for(child: subprocess.Popen[str], word: str) -> str:
    """First line of the node that starts with a word."""
    assert child.stdout is not None
    for line in child.stdout:
        if line.startswith(word):
            return line
    raise AssertionError(f"no '{word}': {child.communicate()[1]}")


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
@pytest.mark.parametrize("idle", ["true", "false"])
def test_signal_ends_a_node_cleanly(number: int, idle: str) -> None:
    child = start("--ros-args", "-p", f"idle:={idle}")
    wait_for(child, "ready")
    time.sleep(0.3)
    begin = time.monotonic()
    child.send_signal(number)
    output, errors = child.communicate(timeout=10)
    assert child.returncode == 0
    assert errors == ""
    assert "stopped" in output
    assert time.monotonic() - begin < 3.0


def test_callbacks_run_at_their_rate_and_cost_little() -> None:
    child = start()
    wait_for(child, "ready")
    begin, served = time.monotonic(), 0.0
    while served < 2.0:  # what this process is given counts: the machine may be held up as a whole
        asleep = time.monotonic()
        time.sleep(0.02)
        served += min(time.monotonic() - asleep, 0.03)
    elapsed = time.monotonic() - begin
    child.send_signal(signal.SIGINT)
    _, ticks, seconds = child.communicate(timeout=10)[0].split()
    # executor.spin() of the wheels runs no callback and burns a whole core
    assert 300 <= int(ticks) <= 250 * elapsed
    assert float(seconds) < 1.0


def test_error_in_a_callback_ends_the_node_with_its_status() -> None:
    child = start("--ros-args", "-p", "fail_after:=5")
    output, errors = child.communicate(timeout=20)
    assert child.returncode == 2
    # the events executor logs where it happened before that
    assert errors.splitlines()[-1] == "demo: the damper is on fire"
    assert "Traceback" not in errors
    assert "stopped 5" in output


@pytest.mark.parametrize(
    ("args", "message"),
    [
        (["-p", "rate:=.nan"], "command line: rate: expected a number in 1..2000 [Hz], found nan"),
        (["-p", "rate:=fast"], "rate: expected a number in 1..2000 [Hz], found 'fast'"),
        (["-p", "weights:=[1.0, .inf]"], "weights: expected a list of numbers, found"),
        (["-p", "rte:=100.0"], "rte: expected a parameter of this node (did you mean rate?)"),
        (["-p", "weights:=[1.0, 2]"], "Sequence should be of same type"),
        (["--no-such-option"], "unknown ROS argument"),
        (["--params-file", "/no/such.yaml"], "/no/such.yaml: expected a readable parameter file"),
    ],
)
def test_bad_arguments_are_one_line_and_status_2(args: list[str], message: str) -> None:
    child = start("--ros-args", *args)
    output, errors = child.communicate(timeout=20)
    assert child.returncode == 2
    assert "ready" not in output
    assert errors.startswith("demo: ")
    assert message in errors
    assert errors.count("\n") == 1


def test_parameter_file_with_a_misspelt_key_is_refused(tmp_path: Path) -> None:
    path = tmp_path / "p.yaml"
    path.write_text(
        "/**:\n  ros__parameters:\n    rate: 100\n    wheel_base: 2.7\n    gian: 1.0\n",
        encoding="utf-8",
    )
    child = start("--ros-args", "--params-file", str(path))
    _, errors = child.communicate(timeout=20)
    assert child.returncode == 2
    assert errors.startswith(
        f"demo: {path}: gian: expected a parameter of this node (did you mean gain?)"
    )


def test_parameter_file_is_used_and_its_integer_promoted(tmp_path: Path) -> None:
    path = tmp_path / "p.yaml"
    path.write_text("demo:\n  ros__parameters:\n    rate: 100\n", encoding="utf-8")
    child = start("--ros-args", "--params-file", str(path))
    assert wait_for(child, "ready") == "ready 100\n"
    child.send_signal(signal.SIGINT)
    child.communicate(timeout=10)


def test_help_is_printed_from_the_tables_without_ros() -> None:
    child = start("--help")
    output, _ = child.communicate(timeout=20)
    assert child.returncode == 0
    assert "pwm/command" in output
    assert "er_damper_msgs/msg/PwmDuty" in output
    row = next(line for line in output.splitlines() if line.strip().startswith("rate"))
    assert "a number in 1..2000 [Hz]" in row
    assert "default 200" in row
    gain = next(line for line in output.splitlines() if line.strip().startswith("gain"))
    assert "dynamic" in gain


@pytest.fixture
def here() -> Iterator[Node]:
    """A node of this process, in the domain of the demo node."""
    rclpy.init(domain_id=int(DOMAIN))
    node = rclpy.create_node("tester")
    yield node
    node.destroy_node()
    rclpy.try_shutdown()


def test_only_dynamic_parameters_change_and_never_to_nonsense(here: Node) -> None:
    child = start()
    wait_for(child, "ready")
    try:
        client = here.create_client(SetParameters, "/demo/set_parameters")
        assert client.wait_for_service(timeout_sec=10.0)
        wanted = [("gain", 2.5), ("gain", float("nan")), ("gain", 11.0), ("rate", 100.0)]
        results = []
        for name, value in wanted:
            message = Parameter(name, value=value).to_parameter_msg()
            future = client.call_async(SetParameters.Request(parameters=[message]))
            rclpy.spin_until_future_complete(here, future, timeout_sec=10.0)
            results.append(future.result().results[0])
        assert [result.successful for result in results] == [True, False, False, False]
        assert all(result.reason for result in results[1:])
        assert wait_for(child, "gain") == "gain 2.5\n"
        describe = here.create_client(DescribeParameters, "/demo/describe_parameters")
        assert describe.wait_for_service(timeout_sec=10.0)
        future = describe.call_async(DescribeParameters.Request(names=["rate"]))
        rclpy.spin_until_future_complete(here, future, timeout_sec=10.0)
        (rate,) = future.result().descriptors
        assert rate.read_only
        assert rate.floating_point_range[0].to_value == 2000.0
        assert rate.description == "ticks per second [Hz]"
    finally:
        child.send_signal(signal.SIGINT)
        child.communicate(timeout=10)


@pytest.mark.parametrize("kind", ["events", "single"])
def test_both_executors_run_callbacks_and_return_when_the_context_ends(
    here: Node, kind: str
) -> None:
    ticks: list[float] = []

    def tick() -> None:
        ticks.append(time.monotonic())
        if len(ticks) == 20:
            rclpy.try_shutdown()

    wall_timer(here, 0.005, tick)
    spin_module.spin(here, kind=kind)
    assert len(ticks) >= 20
    assert 0.05 < ticks[19] - ticks[0] < 2.0


def test_missing_events_executor_falls_back_and_says_so(
    here: Node, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setitem(sys.modules, "rclpy.experimental.events_executor", None)
    said: list[str] = []
    monkeypatch.setattr(here, "get_logger", lambda: type("L", (), {"info": said.append})())
    executor = spin_module.make_executor(here)
    assert isinstance(executor, rclpy.executors.SingleThreadedExecutor)
    assert said == ["no events executor in this rclpy: using the single-threaded one"]
    done: Future = Future()
    done.set_result(None)
    executor.spin_until_future_complete(done, timeout_sec=1.0)


def test_waiting_does_not_pile_up_callbacks(here: Node, monkeypatch: pytest.MonkeyPatch) -> None:
    executor = rclpy.executors.SingleThreadedExecutor()
    wait, futures = executor.spin_until_future_complete, []

    def watched(future: Future, timeout_sec: float) -> None:
        wait(future, timeout_sec=timeout_sec)
        futures.append(future)
        if len(futures) == 3:
            rclpy.try_shutdown()

    monkeypatch.setattr(executor, "spin_until_future_complete", watched)
    monkeypatch.setattr(spin_module, "make_executor", lambda *_: executor)
    spin_module.spin(here)
    assert len({id(future) for future in futures}) == 3


SLOW = """
import os, time
from er_ros_common.spin import Stopped, live

class Tidy:
    def __del__(self):
        os.kill(os.getpid(), {number})
        time.sleep(0.001)

def slow():
    del [Tidy()][0]
    time.sleep(20.0)
    print("made")
    raise SystemExit(3)

with Stopped() as stopped:
    live(slow, stopped)
raise SystemExit(4)
"""


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_signal_ends_a_program_whose_node_is_still_being_made(number: int) -> None:
    """Compiling takes longer than whoever asks for the end will wait, and swallows what is raised in finalisers."""
    code = SLOW.format(number=int(number))
    done = subprocess.run(
        [sys.executable, "-c", code], capture_output=True, text=True, timeout=60, check=False
    )
    assert (done.returncode, done.stdout, done.stderr) == (0, "", "")


@pytest.mark.parametrize(("asked", "threads"), [(None, "1"), ("3", "3")])
def test_a_node_has_one_thread_of_blas_unless_asked(
    asked: str | None, threads: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    """A second one spins: the plant took a core more once it made its road while it drove."""
    monkeypatch.setenv(BLAS, "")
    if asked is None:
        monkeypatch.delenv(BLAS)
    else:
        monkeypatch.setenv(BLAS, asked)
    seen: list[str | None] = []
    monkeypatch.setattr(entry, "run", lambda _: seen.append(os.environ.get(BLAS)))
    before = {number: signal.getsignal(number) for number in (signal.SIGINT, signal.SIGTERM)}
    try:
        entry.start("er_plant_sim", "plant")
    finally:
        for number, handler in before.items():
            signal.signal(number, handler)
    assert seen == [threads]
