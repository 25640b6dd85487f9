"""Beside a running graph: rows of what is heard, what a drive shows, and a model that the monitor goes on with."""

from __future__ import annotations

import math
from pathlib import Path
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
from er_model_lab.live.coverage import DO, carries, coverage
from er_model_lab.live.heard import Heard
from er_model_lab.live.join import COLUMNS, GAP, WAIT, Join
from er_model_lab.live.planned_run import moves
from er_model_lab.page import live_plots, plots
from er_model_lab.preflight.excitation import CELLS
from er_model_lab.session.live_desk import LiveDesk
from er_model_lab.session.script import script
from er_model_lab.session.steps import Step
from er_models.errors import InputError
from er_models.files import load_model
from er_models.model import Model
from er_models.program import Program, load_program

from test.played_graph import VEHICLE, PlayedGraph

FRICTION = {"F_c": 0.9, "v_0": 0.003}
STEP = 5_000_000
DUTY, FORCE = COLUMNS.index("duty"), COLUMNS.index("damper_force")


def with_friction() -> Model:
    return load_model(VEHICLE).with_effect("coulomb_friction", FRICTION)


def beside(graph: PlayedGraph, folder: Path) -> LiveDesk:
    desk = LiveDesk(folder / "heard", "", models=folder / "models", connect=graph.connect)
    desk.by_itself = False
    return desk


def test_what_belongs_to_an_instant_is_a_row_and_what_is_lost_is_not_waited_for() -> None:
    join = Join()
    for k in (1, 3, 2, 40):  # not in order
        join.add(k * STEP, FORCE, (float(k),))
    join.add(2 * STEP, DUTY, (0.1,))
    rows = join.ready()
    assert [r[1 + FORCE] for r in rows] == [1.0, 2.0, 3.0]
    assert [r[1 + DUTY] for r in rows][1] == 0.1
    assert math.isnan(rows[0][1 + DUTY])
    assert rows[2][0] == pytest.approx(0.01)
    join.add(3 * STEP, DUTY, (0.2,))  # too late
    assert join.ready() == []
    join.add(40 * STEP + WAIT + 1, FORCE, (0.0,))
    assert [r[1 + FORCE] for r in join.ready()] == [40.0]
    join.add(40 * STEP + 4_000_000_000, FORCE, (0.0,))
    join.ready()
    join.add(STEP, FORCE, (7.0,))
    join.add(STEP + 2 * WAIT, FORCE, (8.0,))
    assert join.again == 0, "the jump back is within what was given on"
    join.add(40 * STEP + 9_000_000_000, FORCE, (0.0,))
    join.ready()
    join.add(STEP, FORCE, (7.0,))
    join.add(STEP + 2 * WAIT, FORCE, (8.0,))
    assert join.again == 1
    assert [r[0] for r in join.ready()] == [0.0]


def test_a_pause_of_some_seconds_is_another_drive() -> None:
    """Its rows count from its own first stamp; a shorter pause is a loss."""
    join, begins, rows = Join(), (STEP, STEP + GAP, 3 * STEP + 3 * GAP), []
    for begin in begins:
        for k in range(60):
            join.add(begin + k * STEP, FORCE, (1.0,))
        rows.append(join.ready())
    assert join.again == 1
    assert rows[1][-1][0] > 1e-9 * GAP
    assert rows[2][-1][0] < 1.0


def test_a_graph_that_is_started_again_soon_is_another_drive() -> None:
    """Its numbers begin anew; what the drive before still says comes too late, and 0 is no number."""
    join = Join()
    for k in range(400):
        join.add(k * STEP, FORCE, (1.0,), k + 1)
        join.add(k * STEP, DUTY, (0.1,), k + 1)
    join.ready()
    join.add(400 * STEP, FORCE, (1.0,), 0)
    assert join.again == 0
    join.add(401 * STEP, FORCE, (1.0,), 402)
    begin = 700 * STEP
    join.add(begin, FORCE, (2.0,), 1)
    join.add(401 * STEP, DUTY, (0.1,), 402)
    for k in range(60):
        join.add(begin + k * STEP, FORCE, (2.0,), k + 1)
        join.add(begin + k * STEP, DUTY, (0.2,), k + 1)
    rows = join.ready()
    assert join.again == 1
    assert rows[0][0] == 0.0
    assert {(r[1 + FORCE], r[1 + DUTY]) for r in rows} == {(2.0, 0.2)}


def test_memory_is_bounded_and_holds_the_last() -> None:
    heard, rng = Heard(minutes=0.05), np.random.default_rng(1)
    kept, t = heard._kept.nbytes, 0
    for _ in range(200):
        n = int(rng.integers(1, 2 * heard.most))
        heard.add([(0.005 * (t + k), *(float(t + k),) * len(COLUMNS)) for k in range(n)])
        t += n
        assert heard.now == 0.005 * (t - 1)
        whole = heard.column("left")
        assert np.array_equal(whole, np.arange(t - whole.size, t))
    assert heard.rows.shape[0] == heard.most
    assert heard._kept.nbytes == kept
    assert heard.last(0.1).shape[0] == 21
    for k in range(100):
        heard.mark(str(k))
    assert len(heard.marks) == 50


def test_every_region_has_words_for_who_drives() -> None:
    assert {*DO} == {*CELLS}


def test_a_drive_shows_more_and_more_and_a_drive_at_rest_nothing() -> None:
    graph = PlayedGraph(load_model(VEHICLE), 20.0)
    heard = Heard()
    graph.told = lambda word: heard.add(word.get("rows", []))
    graph.drive(4.0)
    first = coverage(heard.channels(), load_model(VEHICLE))
    assert not carries(first)
    assert "hold the duty" in next(s.do for s in first if s.region == "duty_levels")
    graph.drive(16.0)
    later = coverage(heard.channels(), load_model(VEHICLE))
    assert carries(later)
    assert all(
        b.have >= a.have for a in first for b in later if b.region == a.region and a.unit == "s"
    )
    assert [s.done for s in later] == sorted(s.done for s in later), "what lacks most comes first"
    rest = {name: np.zeros_like(y) for name, y in heard.channels().items()} | {
        "t": heard.channels()["t"]
    }
    assert not carries(coverage(rest, load_model(VEHICLE)))


@pytest.mark.slow
def test_what_was_learnt_goes_to_the_monitor_and_the_live_error_falls(tmp_path: Path) -> None:
    graph = PlayedGraph(with_friction(), 25.0)
    desk = beside(graph, tmp_path)
    graph.drive(1.0)
    desk.jobs.wait(60.0)
    assert desk.now.known.name == "inove_quarter_car", (
        "the monitor's model is what one begins with"
    )
    with pytest.raises(Exception, match="10 s of motion"):
        desk.learn()
    graph.drive(11.0)
    before = desk.heard.error()
    desk.gathering()()
    truth = with_friction()
    desk.session = desk.session.then(desk.now.learnt(truth, Step("add", "coulomb_friction")))
    desk.learnt(truth)  # as a fit ends
    assert [Path(p).parent for p in graph.used] == [tmp_path / "models"]
    assert "coulomb_friction" in load_model(graph.used[0]).effects
    graph.drive(8.0)
    assert desk.heard.error() < 0.5 * before
    assert [m.says for m in desk.heard.marks] == ["added coulomb friction"]
    program = script(desk.session)
    assert "heard_1.csv" in program
    assert "lab.add(data, model, 'coulomb_friction'" in program
    for make in (
        live_plots.force,
        live_plots.error,
        live_plots.residual_map,
        live_plots.loops,
        live_plots.spectrum,
    ):
        assert make(desk.heard, plots.DARK)["data"]
    graph.use(str(tmp_path / "none.yaml"))
    assert "none.yaml" in desk.refused


@pytest.mark.parametrize("wanted", [False, True])
def test_observers_go_over_where_that_is_asked(tmp_path: Path, wanted: bool) -> None:
    graph = PlayedGraph(load_model(VEHICLE), 1.0)
    desk = beside(graph, tmp_path)
    desk.observers = wanted
    desk.learnt(load_model(VEHICLE))
    assert graph.observers is wanted


def test_observers_of_the_namespace_are_those_that_say_a_force() -> None:
    pytest.importorskip("rclpy")
    from er_model_lab.ros_live import Listener

    publishers = {
        "/left/force/unified": ["unified_observer"], "/left/force/nlpv_gridding": [],
        "/right/force/nlpv_polytopic": ["nlpv_polytopic_observer"], "/left/sensors/force": ["plant"],
    }  # fmt: skip
    node = SimpleNamespace(
        resolve_topic_name=lambda name: f"/left/{name}",
        get_topic_names_and_types=lambda: [(name, []) for name in publishers],
        get_publishers_info_by_topic=lambda name: [
            SimpleNamespace(node_name=n) for n in publishers[name]
        ],
    )
    assert Listener.observers(SimpleNamespace(node=node)) == ["unified_observer"]


def planned(seconds: float = 2.0) -> Any:
    """What `plan` would have found."""
    run = Program(
        {"kind": "sine", "amplitude": 0.004, "frequency": 2.0}, {"kind": "constant", "level": 0.2}, seconds, 0
    )  # fmt: skip
    limits = {"stroke": 0.012, "velocity": 0.15, "duty": 0.3, "dt": 0.005}
    used = {"stroke": 0.0091, "velocity": 0.1, "duty": 0.2}
    told = {"limits": limits, "programs": [{"used": used}]}
    return SimpleNamespace(program=run, view=SimpleNamespace(result=told))


def test_a_planned_run_is_driven_when_asked_for_and_learnt_from_when_it_is_over(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    graph, learnt = PlayedGraph(load_model(VEHICLE), 12.0), list[float]()
    desk = beside(graph, tmp_path)
    monkeypatch.setattr(desk, "learn", lambda: learnt.append(desk.heard.now))
    graph.drive(1.0)
    desk.jobs.wait(60.0)
    with pytest.raises(InputError, match="a run that was planned"):
        desk.drive()
    desk.planned, desk.by_itself = planned(), True
    desk.drive()
    assert load_program(graph.asked[0]).duty == {"kind": "constant", "level": 0.2}
    graph.drive(2.0)
    assert desk.driving
    assert desk.run is not None
    assert desk.run.says(desk.heard.now) == "/plant drives it: 1 of 2 s"
    graph.drive(2.0)
    assert (desk.driving, len(learnt)) == (False, 1)
    assert [m.says for m in desk.heard.marks] == ["planned run", "run over"]
    assert desk.run.says(desk.heard.now) == "/plant has driven it; its own drive goes on"
    words = live_plots.error(desk.heard, plots.LIGHT)["layout"]["annotations"]
    assert [w["xanchor"] for w in words] == ["left", "right"], "none leaves the plot"
    desk.drive()
    graph.drive(1.5)
    desk.end_run()
    assert graph.asked[1:] == [str(tmp_path / "heard" / "planned_2.yaml"), ""]
    graph.drive(0.75)
    assert desk.driving, "the road goes back"
    graph.drive(0.5)
    assert not desk.driving
    desk.drive()
    graph.told({"again": 1})
    assert desk.run is None


def test_a_run_that_nobody_drives_says_why(tmp_path: Path) -> None:
    graph = PlayedGraph(load_model(VEHICLE), 2.0)
    desk = beside(graph, tmp_path)
    desk.planned = planned()
    for node, says in (("/plant", "/plant: too far"), ("", "no node drives it: too far")):
        monkey = {"accepted": False, "reason": "too far", "node": node, "run": "x"}
        desk.drive()
        graph.told({"ran": monkey})
        assert not desk.driving
        assert desk.run is not None
        assert desk.run.says(0.0) == says


def test_who_says_yes_is_told_what_moves_and_how_far() -> None:
    given = planned()
    said = " ".join(moves(given.program, given.view.result))
    for words in (
        "4.00 mm to each side for 2 s",
        "9.10 of 12.0 mm",
        "0.100 of 0.150 m/s",
        "0.200 of 0.300",
    ):
        assert words in said
    assert "road:=program" in said


@pytest.mark.slow
def test_an_alarm_is_learnt_from_where_it_began(tmp_path: Path) -> None:
    leak = {"f": 0.7, "t_0": 20.0, "t_r": 0.0, "q": 0.0, "d": 0.5}
    graph = PlayedGraph(load_model(VEHICLE).with_effect("oil_leakage", leak), 60.0)
    desk = beside(graph, tmp_path)
    graph.drive(18.0)
    assert not desk.failing
    assert desk.since == -math.inf
    graph.drive(8.0)
    desk.jobs.wait(60.0)
    assert desk.failing
    assert [m.says for m in desk.heard.marks] == ["alarm"]
    assert 19.0 < desk.since < 21.0
    assert not desk.due(), "it listens for a while first"
    graph.drive(16.0)
    assert desk.due()
    t = desk.gathering()().records[0].t
    assert [t[0], t[-1]] == pytest.approx([desk.since, desk.heard.now], abs=0.1)


def test_another_drive_begins_with_nothing(tmp_path: Path) -> None:
    graph = PlayedGraph(load_model(VEHICLE), 10.0)
    desk = beside(graph, tmp_path)
    graph.drive(5.0)
    graph.told({"again": 1})
    assert (desk.heard.seconds, desk.shown) == (0.0, [])
    graph.told({"ended": "no graph"})
    assert desk.gone == "no graph"


def test_messages_are_read_as_they_are_sent() -> None:
    pytest.importorskip("rclpy")
    from er_model_lab.ros_live import READERS
    from rclpy.serialization import serialize_message

    from er_common import topics
    from er_ros_common import builders

    for frame in ("", "x", "damper", "a_longer_name"):
        tick = builders.Tick(3_000_000_007, 5)
        sent = {
            topics.ACCELERATION: (builders.suspension_acceleration(tick, 1.5, -2.5), (1.5, -2.5)),
            topics.DEFLECTION: (builders.suspension_deflection(tick, 0.1, 0.2), (0.1, 0.2)),
            topics.PWM_APPLIED: (builders.pwm_duty(tick, 0.25), (0.25,)),
            topics.FORCE: (builders.damper_force(tick, 7.5), (7.5,)),
            topics.MODEL_RESIDUAL: (
                builders.damper_force(tick, -1.0, force_sd=0.2, test_ratio=0.5, status=2), (-1.0, 0.2, 0.5, 2),
            ),
        }  # fmt: skip
        assert sent.keys() == READERS.keys()
        for topic, (message, values) in sent.items():
            message.header.frame_id = frame
            assert READERS[topic][1](serialize_message(message)) == (3_000_000_007, 5, values)
            message.valid = False
            assert all(map(math.isnan, READERS[topic][1](serialize_message(message))[2]))
