"""A monitor as a process beside a plant: it answers every sample, changes its model, diagnoses and is stopped."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from pathlib import Path
from time import monotonic
from types import SimpleNamespace
from typing import Any

import pytest

pytest.importorskip("rclpy")

import rclpy
from action_msgs.msg import GoalStatus
from er_model_lab.nodes.model_monitor import Asked
from er_models.files import load_model, save_model
from er_ros_common.core_node import LATER
from rcl_interfaces.msg import SetParametersResult
from rcl_interfaces.srv import SetParametersAtomically
from rclpy.action import ActionClient
from rclpy.executors import SingleThreadedExecutor
from rclpy.node import Node
from rclpy.task import Future

from er_common import quality, topics
from er_damper_msgs.action import Diagnose
from er_damper_msgs.msg import NodeStatus
from er_damper_msgs.srv import UseModel
from er_ros_common import qos
from test.graph_help import VEHICLE, Graph, observer_arguments, own_domain, plant_arguments

PLANT = ("-p", "duration:=0.0", "-p", "duty_source:=program")


@pytest.fixture
def graph(tmp_path: Path) -> Iterator[Graph]:
    with own_domain() as env, Graph(env, tmp_path) as made:
        yield made


class Seen(Node):
    """What the monitor says, and what is asked of it."""

    def __init__(self, executor: SingleThreadedExecutor) -> None:
        super().__init__("test_client")
        self.executor_ = executor
        executor.add_node(self)
        self.forces: list[Any] = []
        self.residuals: list[Any] = []
        self.status: NodeStatus | None = None
        for topic, kept in (
            (topics.MODEL_FORCE, self.forces),
            (topics.MODEL_RESIDUAL, self.residuals),
        ):
            self.create_subscription(
                topic.type, topic.name, kept.append, qos.profile(quality.RECORDER)
            )
        self.create_subscription(
            NodeStatus, "/model_monitor/status", self.said, qos.profile(topics.STATUS.subscriber)
        )
        self.use = self.create_client(UseModel, "/model_monitor/use_model")
        self.diagnose = ActionClient(self, Diagnose, "/model_monitor/diagnose")

    def said(self, status: NodeStatus) -> None:
        self.status = status

    def until(self, there: Callable[[], object], seconds: float = 60.0) -> None:
        end = monotonic() + seconds
        while not there():
            assert monotonic() < end, "it did not come"
            self.executor_.spin_once(timeout_sec=0.1)

    def result_of(self, future: Any) -> Any:
        self.until(future.done)
        return future.result()


@pytest.fixture
def seen(graph: Graph) -> Iterator[Seen]:
    rclpy.init(args=[], domain_id=int(graph.env["ROS_DOMAIN_ID"]))
    executor = SingleThreadedExecutor()
    node = Seen(executor)
    yield node
    node.destroy_node()
    rclpy.try_shutdown()


@pytest.mark.parametrize(
    ("done", "reason", "word", "stays"),
    [
        (True, "", "watcher goes over to it, too", False),
        (
            False,
            f"gains are being made: {LATER}",
            f"watcher: gains are being made: {LATER}",
            False,
        ),
        (False, "no such file", "watcher keeps its model: no such file", True),
    ],
)
def test_what_another_node_answers_is_said_as_it_is(
    done: bool, reason: str, word: str, stays: bool
) -> None:
    answered: Future = Future()
    answered.set_result(
        SetParametersAtomically.Response(
            result=SetParametersResult(successful=done, reason=reason)
        )
    )
    client = SimpleNamespace(service_is_ready=lambda: True, call_async=lambda request: answered)
    asked = Asked("watcher", client, "worn.yaml")
    assert asked.look()
    assert (asked.word, asked.stays) == (word, stays)


@pytest.mark.slow
@pytest.mark.alone
def test_it_goes_on_beside_whatever_is_asked_of_it(
    graph: Graph, seen: Seen, tmp_path: Path
) -> None:
    worn = tmp_path / "worn.yaml"
    save_model(load_model(VEHICLE).with_effect("preload", {"F_0": 3.0}), worn)
    monitor = graph.start(
        "model_monitor", "--ros-args", "-p", f"model_file:={VEHICLE}", "-p", "learn:=10.0",
        "-p", f"models:={tmp_path / 'models'}", "-p", "max_age:=0.5", "-p", "along:=[plant, nobody]",
    )  # fmt: skip
    graph.start("plant", *plant_arguments(*PLANT, "-p", f"damper_file:={worn}"))
    observer = graph.start("nlpv_polytopic_observer", *observer_arguments("-p", "max_age:=0.5"))
    seen.until(lambda: len(seen.residuals) > 1100, 240.0)
    assert all(m.valid for m in seen.residuals[300:])
    # another model, and one that there is not
    answer = seen.result_of(seen.use.call_async(UseModel.Request(model="none.yaml")))
    assert not answer.accepted
    assert "none.yaml" in answer.reason
    request = UseModel.Request(model=str(worn), along=["nlpv_polytopic_observer"])
    answer = seen.result_of(seen.use.call_async(request))
    assert answer.accepted, answer.reason
    names = "plant, nobody, nlpv_polytopic_observer"
    assert answer.reason.endswith(f"; asked to go over, too: {names}")
    assert f"model: {answer.reason.split(';')[0]}" in monitor.text
    made = (
        "gains for inove_quarter_car without preload, which its form cannot hold, are being made"
    )
    for words in (
        "plant goes over to it, too", "nobody does not answer: it keeps its model",
        f"nlpv_polytopic_observer: {made}: it goes over when they are proved",
    ):  # fmt: skip
        monitor.wait_for(words)
    # the observer goes on meanwhile, and over to what it can take
    gains = tmp_path / "worn_nlpv_polytopic.yaml"
    observer.wait_for(f"model: inove_quarter_car without preload ({worn}), gains {gains}", 120.0)
    assert "INVALID" not in observer.text
    before = len(seen.residuals)
    seen.until(lambda: len(seen.residuals) > before + 500)
    wrong, right = (
        sum(m.force**2 for m in part) / len(part)
        for part in (seen.residuals[300:before], seen.residuals[before + 100 :])
    )
    assert right < 0.1 * wrong
    # a diagnosis, a second one that is refused, the end of the first
    told: list[Any] = []
    goal = seen.result_of(
        seen.diagnose.send_goal_async(Diagnose.Goal(model=VEHICLE), feedback_callback=told.append)
    )
    assert goal.accepted
    second = seen.result_of(seen.diagnose.send_goal_async(Diagnose.Goal()))
    end = seen.result_of(second.get_result_async())
    refused = "refused: another one is under way"
    assert (end.status, end.result.reason) == (GoalStatus.STATUS_ABORTED, refused)
    assert f"~/diagnose: {refused}" in monitor.text
    seen.until(lambda: told)
    seen.result_of(goal.cancel_goal_async())
    end = seen.result_of(goal.get_result_async())
    assert (end.status, end.result.reason) == (GoalStatus.STATUS_CANCELED, "cancelled")
    assert not (tmp_path / "models").exists()
    # at the rate of the samples, in order; what a busy machine loses is not the monitor's
    numbers = [m.seq for m in seen.forces[100:]]
    assert numbers == sorted(numbers)
    assert len(numbers) > 0.97 * (numbers[-1] - numbers[0])
    assert monitor.stop() == 0, monitor.text


@pytest.mark.slow
@pytest.mark.alone
def test_what_it_lacks_is_learnt_from_the_last_seconds_and_from_a_recording(
    graph: Graph, seen: Seen, tmp_path: Path
) -> None:
    worn, models = tmp_path / "worn.yaml", tmp_path / "models"
    save_model(load_model(VEHICLE).with_effect("preload", {"F_0": 3.0}), worn)
    graph.start(
        "model_monitor", "--ros-args", "-p", f"model_file:={VEHICLE}", "-p", f"models:={models}",
        "-p", "max_age:=0.5",
    )  # fmt: skip
    graph.start("plant", *plant_arguments(*PLANT, "-p", f"damper_file:={worn}"))
    bag = tmp_path / "bag"
    recorder = graph.start("record", str(bag))

    def outcome(**asked: Any) -> tuple[int, Diagnose.Result]:
        goal = seen.result_of(seen.diagnose.send_goal_async(Diagnose.Goal(**asked)))
        found = goal.get_result_async()
        seen.until(found.done, 400.0)
        return found.result().status, found.result().result

    seen.until(lambda: len(seen.residuals) > 200, 240.0)
    status, result = outcome(seconds=0.5)
    assert (status, result.reason) == (
        GoalStatus.STATUS_ABORTED, "less than 5 s were heard with a force",
    )  # fmt: skip
    seen.until(lambda: len(seen.residuals) > 3000, 240.0)
    assert recorder.stop() == 0, recorder.text
    for asked in ({"seconds": 12.0}, {"bag": str(bag)}):
        status, result = outcome(**asked)
        assert status == GoalStatus.STATUS_SUCCEEDED, result.reason
        assert (result.verdict, list(result.effects)) == ("missing_effect", ["preload"])
        assert 0.0 < result.rmse_after < 0.5 * result.rmse_before
        learnt = load_model(result.model)
        assert learnt.value("preload", "F_0") == pytest.approx(3.0, abs=0.5)
    assert len(list(models.iterdir())) == 2
    status, result = outcome(bag=str(tmp_path / "none"))
    assert status == GoalStatus.STATUS_ABORTED
    assert "none" in result.reason
