"""Lockstep: what a tick waits for, and for how long."""

from __future__ import annotations

from functools import partial
from types import SimpleNamespace
from typing import Any

import pytest

pytest.importorskip("rclpy")

from diagnostic_msgs.msg import DiagnosticStatus, KeyValue
from er_plant_sim.nodes import drive, recording
from er_plant_sim.nodes import plant as plant_node
from er_plant_sim.nodes.drive import Lockstep, Timed
from er_plant_sim.nodes.plant import PlantNode
from er_plant_sim.nodes.recording import Recording
from er_ros_common.builders import Tick
from er_ros_common.health import Meter


class Clock:
    """A clock that is set by hand."""

    def __init__(self, monkeypatch: pytest.MonkeyPatch) -> None:
        self.now = 100.0
        for module in (drive, recording):
            monkeypatch.setattr(module, "monotonic", lambda: self.now)


@pytest.fixture
def clock(monkeypatch: pytest.MonkeyPatch) -> Clock:
    return Clock(monkeypatch)


class Rig:
    """A plant of which only the order of its doings matters; may: whether the recording follows."""

    def __init__(self, *, answered: bool = True, paced: bool = False) -> None:
        self.done: list[str] = []
        self.tick, self.may, self.hopeless, self.ready = 0, True, False, 0
        pace: Any = SimpleNamespace(ticks=lambda: range(self.ready))
        self.drive: Lockstep | Timed = Lockstep(
            pace,
            self.sense,
            self.act,
            lambda: self.done.append("pass on"),
            lambda: self.may,
            paced=paced,
            answered=answered,
            hopeless=lambda: self.hopeless,
        )

    def sense(self, _: int) -> int:
        self.tick += 1
        self.done.append(f"sense {self.tick}")
        return self.tick

    def act(self) -> bool:
        self.done.append(f"act {self.tick}")
        return self.tick < 5


def test_a_tick_waits_for_its_own_answer_and_for_no_other(clock: Clock) -> None:
    rig = Rig()
    rig.drive.on_time()
    rig.drive.on_time()
    rig.drive.on_command(2)
    assert rig.done == ["sense 1"]
    rig.drive.on_command(1)
    assert rig.done == ["sense 1", "act 1", "sense 2"]


def test_the_wait_is_long_once_and_short_until_somebody_answers_again(clock: Clock) -> None:
    rig = Rig()
    rig.drive.on_time()
    clock.now += drive.PATIENCE - 0.1
    rig.drive.on_time()
    assert rig.done == ["sense 1"]
    clock.now += 0.2
    rig.drive.on_time()
    assert rig.done[-2:] == ["act 1", "sense 2"]
    clock.now += 2.0 * drive.BRIEF
    rig.drive.on_time()
    assert rig.done[-1] == "sense 3"
    rig.drive.on_command(3)
    clock.now += 2.0 * drive.BRIEF
    rig.drive.on_time()
    assert (rig.done[-1], rig.drive.timeouts) == ("sense 4", 2)
    rig.hopeless = True
    rig.drive.on_time()
    assert rig.done[-1] == "sense 5"


def test_nothing_goes_on_until_the_recording_follows(clock: Clock) -> None:
    rig = Rig(answered=False, paced=True)
    rig.may, rig.ready = False, 3
    rig.drive.on_time()
    assert rig.done == []
    rig.may, rig.ready = True, 0
    rig.drive.on_recorded()
    one, two, three = (["sense " + k, "act " + k, "pass on"] for k in "123")
    assert rig.done == [*one, *two, *three]


def test_samples_that_are_due_at_once_are_heard_one_by_one(clock: Clock) -> None:
    """All in one go they were lost to whoever shares the process, but for as many as its queue holds."""
    rig = Rig()
    rig.drive = Timed(rig.drive.pace, rig.sense, rig.act, rig.drive.between)
    for rig.ready in (1, 3):
        rig.drive.on_time()
    assert rig.done[:2] == ["sense 1", "act 1"]
    assert rig.done[2:] == [
        "sense 2",
        "act 2",
        "pass on",
        "sense 3",
        "act 3",
        "pass on",
        "sense 4",
        "act 4",
    ]
    rig.drive.on_time()
    assert rig.done[10:] == ["sense 5", "act 5"]  # the last of all


@pytest.fixture
def plant(clock: Clock, monkeypatch: pytest.MonkeyPatch) -> Any:
    """A plant in lockstep whose sensors and duty take 0.2 ms each, without a graph."""

    def takes(seconds: float) -> None:
        clock.now += seconds

    def advance(_: object, state: Any) -> Any:
        takes(2e-4)
        return SimpleNamespace(sim=SimpleNamespace(tick=state.sim.tick + 1))

    rig = SimpleNamespace(
        sense=lambda *_: takes(2e-4),
        decide=lambda _, state, **__: (state, None),
        advance=advance,
        finished=lambda _, state: state.sim.tick > 5,
    )
    monkeypatch.setattr(plant_node, "plant", rig)
    monkeypatch.setattr(plant_node, "perf_counter", lambda: clock.now)
    monkeypatch.setattr(plant_node, "until_next", lambda _: 0)
    node: Any = SimpleNamespace(
        rig=None, state=SimpleNamespace(sim=SimpleNamespace(tick=1)), tick=Tick(0, 0), sent=[],
        running=False, over=False, conflict=False, timer=None, sensing=0.0,
        pace=SimpleNamespace(
            stamp=lambda _, tick: tick, late=lambda _: 0.0, ticks=lambda: range(0),
            restart=lambda _: None, schedule=SimpleNamespace(period=1),
        ),
        loop=SimpleNamespace(sensed=lambda *_: None),
        health=SimpleNamespace(meter=Meter(1.0)),
        gathering=SimpleNamespace(complete=lambda: True),
    )  # fmt: skip
    node.out = SimpleNamespace(
        send=lambda tick, _: node.sent.append(f"sample {tick.seq}"),
        send_applied=lambda tick, _: node.sent.append(f"duty {tick.seq}"),
    )
    node.sense, node.act = partial(PlantNode.sense, node), partial(PlantNode.act, node)
    node._finish = lambda: setattr(node, "over", True)
    begun(node)
    return node


def begun(node: Any) -> None:
    """The plant is activated, and its timer fires."""
    node.running = False
    node.drive = Lockstep(
        node.pace,
        node.sense,
        node.act,
        bool,
        lambda: True,
        paced=False,
        answered=True,
        hopeless=bool,
    )
    PlantNode.on_time(node)


def test_the_wait_for_an_answer_is_no_time_of_the_step(clock: Clock, plant: Any) -> None:
    clock.now += 0.02
    plant.drive.on_command(1)
    timing = plant.health.meter.look(clock.now)
    assert timing.step_time_mean == pytest.approx(4e-4)


def test_a_sample_that_waited_for_its_answer_in_a_pause_is_not_sent_again(plant: Any) -> None:
    assert plant.sent == ["sample 1"]
    begun(plant)
    assert plant.sent == ["sample 1", "duty 1", "sample 2"]
    for k in (2, 3, 4):
        plant.drive.on_command(k)
    assert plant.sent[-1] == "sample 5"
    begun(plant)
    assert plant.sent[-1] == "duty 5"
    assert plant.over
    assert len(set(plant.sent)) == len(plant.sent) == 10


class Graph:
    """What a recording asks of its node."""

    def __init__(self) -> None:
        self.recorders, self.lines = 1, [""]

    def resolve_topic_name(self, name: str) -> str:
        return f"/front/{name}"

    def listen(self, *_: object) -> None:
        """Nothing comes by itself."""

    def count_publishers(self, _: str) -> int:
        return self.recorders


def said(**last: int | str) -> DiagnosticStatus:
    values = [KeyValue(key=f"/front/{name}", value=str(n)) for name, n in last.items()]
    return DiagnosticStatus(values=[*values, KeyValue(key="/rear/road", value="9999")])


@pytest.fixture
def graph(monkeypatch: pytest.MonkeyPatch) -> Graph:
    graph = Graph()
    monkeypatch.setattr(recording.log, "warning", lambda _, text: graph.lines.append(text))
    return graph


def following(graph: Any) -> Recording:
    made = Recording(graph, "recorder", ["road", "force"], 200.0, lambda: None)
    made.begin(0)
    return made


def test_the_plant_is_never_further_ahead_than_queues_hold(clock: Clock, graph: Graph) -> None:
    one = following(graph)
    assert not one.known
    one.on_said(said(road=0, force=0))
    assert one.known
    assert one.follows(one.ahead)
    assert not one.follows(one.ahead + 1)
    one.on_said(said(road=1, force=0))
    assert not one.follows(one.ahead + 1)
    one.on_said(said(road=1, force=1))
    assert one.follows(one.ahead + 1)
    assert not one.follows(2, ahead=0)
    assert graph.lines == [""]


def test_a_topic_that_stands_still_is_given_up_and_taken_up_again(
    clock: Clock, graph: Graph
) -> None:
    one = following(graph)
    one.on_said(said(road=500, force=0))
    assert not one.follows(500)
    clock.now += recording.PATIENCE - 0.1
    one.on_said(said(road=500, force=1))
    assert not one.follows(500)
    clock.now += recording.PATIENCE + 0.1
    assert one.follows(500)
    assert one.follows(510)
    assert "without /front/force" in graph.lines[-1]
    one.on_said(said(road=510, force=2))
    assert not one.follows(510)
    graph.recorders = 0
    assert one.follows(510)
    assert "no recorder" in graph.lines[-1]


@pytest.mark.parametrize("text", ["abc", "", "1e3", "-5", "\u00b2", "9" * 5000])
def test_what_is_no_number_is_ignored_and_said_once(clock: Clock, graph: Graph, text: str) -> None:
    one = following(graph)
    one.on_said(said(road=7, force=text))
    one.on_said(said(road=8, force=text))
    assert one.written == {"/front/road": 8, "/front/force": 0}
    (line,) = graph.lines[1:]
    assert line.startswith("recorder/recorded: /front/force: expected a whole number from 0")
    assert repr(text[:20]) in line
