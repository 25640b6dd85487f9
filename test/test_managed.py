"""Lifecycle, one process for several nodes, and ends while a program is still being imported."""

from __future__ import annotations

import os
import signal
import subprocess
import sys
from collections.abc import Callable, Iterator
from pathlib import Path
from time import monotonic, sleep
from typing import Any

import pytest

pytest.importorskip("rclpy")

import rclpy
from er_bringup.given import parse
from er_bringup.graph import nodes
from er_bringup.nodes.ros2_control_joint import JointNode
from er_bringup.ros_composed import part, split
from er_bringup.ros_joint import COMMANDS
from er_common.program import Program
from er_ftc_controller.programs import FTC, SKYHOOK
from er_models.errors import ErError, InputError
from er_observers.programs import OBSERVERS
from er_ros_common.core_node import CoreNode
from er_ros_common.managed import ManagedNode
from lifecycle_msgs.msg import Transition
from lifecycle_msgs.srv import ChangeState
from rclpy.executors import SingleThreadedExecutor
from rclpy.lifecycle import TransitionCallbackReturn

from er_common import topics
from er_damper_msgs.msg import NodeStatus
from er_ros_common import builders, qos
from test.graph_help import CONFIG, ROOT, VEHICLE, own_domain, skyhook_arguments

OK = TransitionCallbackReturn.SUCCESS


@pytest.fixture
def ros() -> Iterator[SingleThreadedExecutor]:
    """ROS in this process, in a domain of its own."""
    with own_domain() as env:
        rclpy.init(args=[], domain_id=int(env["ROS_DOMAIN_ID"]))
        executor = SingleThreadedExecutor()
        yield executor
        for node in executor.get_nodes():
            node.destroy_node()
        rclpy.try_shutdown()


def until(
    executor: SingleThreadedExecutor, there: Callable[[], object], seconds: float = 300.0
) -> None:
    """Run callbacks until something is true; the first configuration on a machine compiles."""
    end = monotonic() + seconds
    while not there():
        assert monotonic() < end, "it did not come"
        executor.spin_once(timeout_sec=0.02)


def change(executor: SingleThreadedExecutor, node: ManagedNode, transition: int) -> bool:
    """What a manager hears when it asks the node for a transition."""
    client = node.create_client(ChangeState, f"{node.get_name()}/change_state")
    until(executor, client.service_is_ready)
    asked = ChangeState.Request()
    asked.transition.id = transition
    answer = client.call_async(asked)
    until(executor, answer.done)
    return bool(answer.result().success)


def test_a_manager_leads_a_controller_and_hears_no_for_what_cannot_be(
    ros: SingleThreadedExecutor,
) -> None:
    node = CoreNode(SKYHOOK, skyhook_arguments("-p", "autostart:=false"))
    other = rclpy.create_node("other")
    ros.add_node(node)
    ros.add_node(other)
    heard: list[float] = []
    command, acceleration, deflection = topics.PWM_COMMAND, topics.ACCELERATION, topics.DEFLECTION
    other.create_subscription(
        command.type, command.name, lambda m: heard.append(m.duty), qos.profile(command.subscriber)
    )
    ends = [
        other.create_publisher(t.type, t.name, qos.profile(t.publisher))
        for t in (acceleration, deflection)
    ]
    assert not change(ros, node, Transition.TRANSITION_ACTIVATE)
    assert node._said().mode == "unconfigured"
    assert change(ros, node, Transition.TRANSITION_CONFIGURE)

    def send() -> int:
        tick = builders.Tick(node.get_clock().now().nanoseconds, 1)
        ends[0].publish(builders.suspension_acceleration(tick, 1.0, 0.0))
        ends[1].publish(builders.suspension_deflection(tick, 0.0, 0.1))
        for _ in range(5):
            ros.spin_once(timeout_sec=0.01)
        return len(heard)

    def silent() -> bool:
        """Whether no command comes for a while."""
        left, end = len(heard), monotonic() + 0.3
        while monotonic() < end:
            ros.spin_once(timeout_sec=0.02)
        return len(heard) == left

    until(ros, lambda: all(end.get_subscription_count() for end in ends))
    for _ in range(10):
        assert send() == 0, "it acted while inactive"
    assert change(ros, node, Transition.TRANSITION_ACTIVATE)
    until(ros, lambda: send() > 3)
    heard.clear()
    assert change(ros, node, Transition.TRANSITION_DEACTIVATE)
    until(ros, lambda: heard and heard[-1] == node.p.safe_duty)
    until(ros, silent)  # of the last commands one may have had this very duty
    send()
    assert silent(), "it acted while inactive"
    assert change(ros, node, Transition.TRANSITION_CLEANUP)
    assert "waits for a manager (ros2 lifecycle set NODE configure)" in node._said().reason
    assert change(ros, node, Transition.TRANSITION_CONFIGURE)
    assert len(list(node.subscriptions)) == 2 + len(
        [s for s in node.subscriptions if "parameter" in s.topic_name]
    )
    assert change(ros, node, Transition.TRANSITION_INACTIVE_SHUTDOWN)
    said = node._said()
    assert (said.mode, said.status, said.valid) == ("finalized", NodeStatus.STATUS_LOST, False)
    assert said.reason == "it was shut down for good: start it anew"


def test_inputs_of_every_tick_are_watched_for_the_rate_the_node_is_made_for(
    ros: SingleThreadedExecutor,
) -> None:
    file, gains = CONFIG / "nodes/ftc_controller.yaml", CONFIG / "gains/lpv_ftc.yaml"
    more = [f"model_file:={VEHICLE}", f"gains_file:={gains}", "rate:=100.0", "autostart:=false"]
    pairs = [word for pair in more for word in ("-p", pair)]
    paced = CoreNode(FTC, ["--ros-args", "--params-file", str(file), *pairs])
    free = CoreNode(SKYHOOK, skyhook_arguments("-p", "autostart:=false"))
    for node in (paced, free):
        ros.add_node(node)
        node.start()
        node.configure()
    found = {name: each.rate for name, each in paced.incoming.items()}
    assert found.pop("fault/estimate") == 0.0
    assert found == dict.fromkeys(
        ("sensors/acceleration", "sensors/deflection", "pwm/applied"), 100.0
    )
    assert {each.rate for each in free.incoming.values()} == {0.0}


@pytest.mark.parametrize("program", [SKYHOOK, FTC], ids=lambda program: program.name)
@pytest.mark.parametrize(("age", "simulated"), [("0.0", True), ("0.02", False)])
def test_the_last_words_of_a_controller_are_of_the_time_of_its_samples(
    ros: SingleThreadedExecutor, program: Program, age: str, *, simulated: bool
) -> None:
    """Without a clock of simulated time they would else differ from one run of a seed to the next."""
    files = ["-p", f"model_file:={VEHICLE}", "-p", f"gains_file:={CONFIG / 'gains/lpv_ftc.yaml'}"]
    given = [
        "--params-file",
        str(CONFIG / f"nodes/{program.name}.yaml"),
        "-p",
        f"max_age:={age}",
    ]
    node = CoreNode(program, ["--ros-args", *given, *(files if program.gains else [])])
    ros.add_node(node)
    node.start()
    said: list[Any] = []
    node.publish = said.extend
    node.state = node.state._replace(last=builders.Tick(6_000_000_000, 1200))
    node.end()
    ((_, message),) = said
    assert message.seq == 1200
    assert (message.header.stamp.sec == 6) == simulated


def test_what_nobody_thought_of_is_said_with_its_kind(ros: SingleThreadedExecutor) -> None:
    def wrong() -> None:
        raise ValueError("no such\nthing")

    node = JointNode([])
    ros.add_node(node)
    node.configure = wrong
    with pytest.raises(ErError, match=r"^ValueError: no such thing$"):
        node.start()


def test_who_else_gives_joint_commands_is_watched(ros: SingleThreadedExecutor) -> None:
    node = JointNode([])
    ros.add_node(node)
    node.start()
    assert node.watched.keys() >= {COMMANDS.name, topics.PWM_COMMAND.name}


def test_who_asked_last_hears_what_a_node_listens_to(ros: SingleThreadedExecutor) -> None:
    """A node that is configured anew makes new listeners, and keeps the ends of its topics."""
    node = CoreNode(SKYHOOK, skyhook_arguments("-p", "autostart:=false"))
    other = rclpy.create_node("other")
    ros.add_node(node)
    ros.add_node(other)
    said: list[str] = []
    status = topics.STATUS
    for who in ("old", "new"):
        node.listen(
            "other/status", status.type, lambda _, who=who: said.append(who), status.subscriber
        )
    other.create_publisher(status.type, "other/status", qos.profile(status.publisher)).publish(
        status.type()
    )
    until(ros, lambda: said)
    assert said == ["new"]


def test_real_time_priority_is_held_while_a_node_acts_where_the_system_lets_it(
    ros: SingleThreadedExecutor,
) -> None:
    node = CoreNode(SKYHOOK, skyhook_arguments("-p", "autostart:=false", "-p", "priority:=7"))
    ros.add_node(node)
    try:
        os.sched_setscheduler(0, os.SCHED_FIFO, os.sched_param(1))
        os.sched_setscheduler(0, os.SCHED_OTHER, os.sched_param(0))
        acting = (os.SCHED_FIFO, 7)
    except PermissionError:
        acting = (os.SCHED_OTHER, 0)

    def now() -> tuple[int, int]:
        return os.sched_getscheduler(0), os.sched_getparam(0).sched_priority

    for transition, expected in (
        (Transition.TRANSITION_CONFIGURE, (os.SCHED_OTHER, 0)),
        (Transition.TRANSITION_ACTIVATE, acting),
        (Transition.TRANSITION_DEACTIVATE, (os.SCHED_OTHER, 0)),
        (Transition.TRANSITION_ACTIVATE, acting),
    ):
        assert change(ros, node, transition)
        assert now() == expected, transition
    node.on_stop()
    assert now() == (os.SCHED_OTHER, 0)


def test_gains_are_read_again_when_a_node_is_configured_again(
    ros: SingleThreadedExecutor, tmp_path: Path
) -> None:
    gains = tmp_path / "gains.yaml"
    gains.write_text("nothing: here\n", encoding="utf-8")
    given = [
        "-p",
        f"model_file:={VEHICLE}",
        "-p",
        f"gains_file:={gains}",
        "-p",
        "autostart:=false",
    ]
    node = CoreNode(OBSERVERS["unified"], ["--ros-args", *given])
    ros.add_node(node)
    assert not change(ros, node, Transition.TRANSITION_CONFIGURE)
    assert "gains.yaml" in node._said().reason
    with pytest.raises(InputError, match=r"gains\.yaml"):
        node.start()
    gains.write_bytes((CONFIG / "gains/unified.yaml").read_bytes())
    assert change(ros, node, Transition.TRANSITION_CONFIGURE)
    assert node.health.gains_id


def test_an_input_that_new_gains_do_without_is_neither_heard_nor_asked_for(
    ros: SingleThreadedExecutor,
) -> None:
    """Its end stays, and messages go on arriving there."""
    pairs = (f"model_file:={VEHICLE}", f"gains_file:={CONFIG / 'gains/unified.yaml'}")
    words = [
        word for pair in (*pairs, "deflection:=false", "autostart:=false") for word in ("-p", pair)
    ]
    node = CoreNode(OBSERVERS["unified"], ["--ros-args", *words])
    ros.add_node(node)
    shell = node.shell

    def with_sensor(_: Any) -> Any:
        core = shell.make(node.p)
        core.inputs = (*core.inputs, topics.DEFLECTION)
        core.limits = (*core.limits, core.limits[0])
        return core

    node.shell = shell._replace(make=with_sensor)
    node.start()
    usual = {topics.ACCELERATION.name, topics.PWM_APPLIED.name}
    assert node.incoming.keys() == usual | {topics.DEFLECTION.name}
    assert node.trigger_deactivate() == node.trigger_cleanup() == OK
    node.shell = shell
    node.start()
    tick = builders.Tick(node.get_clock().now().nanoseconds, 1)
    (end,) = (s for s in node.subscriptions if s.topic_name == "/sensors/deflection")
    end.callback(builders.suspension_deflection(tick, 0.0, 0.1))
    assert node.incoming.keys() == usual
    assert topics.DEFLECTION.name not in node.watched


def test_command_lines_of_composed_nodes_are_those_of_the_processes() -> None:
    apart = nodes(parse(["namespace:=fl", "seed:=3"]), CONFIG)
    (together,) = nodes(parse(["namespace:=fl", "seed:=3", "composed:=true"]), CONFIG)
    assert together.executable == "composed"
    assert [each.place() for each in apart] == [together.place()] * len(apart)
    groups, common = split([*together.arguments(), *together.place()])
    assert common == together.place() == ["--ros-args", "-r", "__ns:=/fl"]
    assert [group[1:] for group in groups] == [[*s.arguments(), *s.place()] for s in apart]
    assert [part(g).executable.card.program.name for g in groups] == [s.executable for s in apart]
    assert split(["a/b", "--ros-args", "--"]) == ([["a/b", "--ros-args"]], [])


@pytest.mark.parametrize("group", [["er_plant_sim/plnt"], ["plant"], ["er_plant_sim/plant", "x"]])
def test_a_node_that_is_none_is_one_line(group: list[str]) -> None:
    with pytest.raises(ErError, match=r"expected PACKAGE/EXECUTABLE|unknown argument 'x'"):
        part(group)


@pytest.mark.alone
def test_the_whole_graph_runs_in_one_process(tmp_path: Path) -> None:
    with own_domain() as env:
        ended = subprocess.run(
            [sys.executable, "-m", "er_bringup.up", "composed:=true", "duration:=1.5"],
            env=env, capture_output=True, text=True, timeout=60, check=False, cwd=tmp_path,
        )  # fmt: skip
    assert ended.returncode == 0, ended.stdout + ended.stderr
    for words in (
        "[plant]: finished after 300 ticks",
        "[skyhook_controller]: running",
        "[unified_observer]: running",
    ):
        assert words in ended.stdout
    assert "Traceback" not in ended.stdout


@pytest.mark.alone
@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_a_program_that_is_still_being_imported_ends_quietly(number: int) -> None:
    """As its console script starts it, once Python itself has begun."""
    code = "import sys; print('begun', flush=True); from er_plant_sim.executables import plant; plant()"
    child = subprocess.Popen(
        [sys.executable, "-c", code], stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        cwd=ROOT, env=os.environ | {"ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"},
    )  # fmt: skip
    assert child.stdout is not None
    child.stdout.readline()
    sleep(0.15)
    child.send_signal(number)
    _, errors = child.communicate(timeout=10)
    assert (child.returncode, errors) == (0, "")


@pytest.mark.parametrize("number", [signal.SIGINT, signal.SIGTERM])
def test_nodes_that_are_still_being_imported_into_one_process_end_quietly(
    number: int, tmp_path: Path
) -> None:
    slow = tmp_path / "snail"
    slow.mkdir()
    (slow / "programs.py").write_text(
        "import time\nprint('begun', flush=True)\ntime.sleep(60.0)\n"
    )
    child = subprocess.Popen(
        [sys.executable, "-m", "er_bringup.ros_composed", "snail/crawling"],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
        env=os.environ | {"PYTHONPATH": f"{tmp_path}:{os.environ.get('PYTHONPATH', '')}"},
    )  # fmt: skip
    assert child.stdout is not None
    assert child.stdout.readline() == "begun\n"
    child.send_signal(number)
    _, errors = child.communicate(timeout=10)
    assert (child.returncode, errors) == (0, "")


LISTED = """
import atexit, sys
from pathlib import Path
from er_ros_common.entry import start
atexit.register(lambda: print("threads", *(p.read_text().strip() for p in Path("/proc/self/task").glob("*/comm"))))
start(*sys.argv.pop(1).split("/"))
"""


@pytest.mark.parametrize(
    "command",
    [
        ["er_ftc_controller/skyhook_controller", *skyhook_arguments()],
        ["er_ftc_controller/skyhook_controller", *skyhook_arguments("-p", "listeners:=many")],
        ["er_bringup/composed", "er_ftc_controller/skyhook_controller", *skyhook_arguments()],
    ],
)
def test_nothing_of_the_middleware_is_left_when_nodes_have_ended(command: list[str]) -> None:
    # a participant that is taken down with its process hangs there now and then, or ends it with SIGABRT
    with own_domain() as env:
        child = subprocess.Popen(
            [sys.executable, "-c", LISTED, *command], env=env, text=True,
            stdout=subprocess.PIPE, stderr=subprocess.PIPE,
        )  # fmt: skip
        assert child.stderr is not None
        said = child.stderr.readline()
        if "waiting" in said:
            child.send_signal(signal.SIGINT)
        out, errors = child.communicate(timeout=20)
    assert "waiting" in said or "listeners: expected" in said, said + errors
    assert "threads" in out
    assert "dds." not in out.replace("dds.shm.wdog", "")
