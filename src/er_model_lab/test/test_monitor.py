"""Messages to the monitor, on a clock of the test's own: force, error, alarm, another model, what is learnt."""

from __future__ import annotations

import math
from collections.abc import Callable
from pathlib import Path
from threading import Event
from typing import Any

import numpy as np
import pytest

pytest.importorskip("rclpy")

from er_common.stamps import SECOND
from er_model_lab.monitor.compare import Row
from er_model_lab.monitor.learner import learn
from er_model_lab.monitor.learning import Task
from er_model_lab.monitor.settings import MonitorParameters
from er_model_lab.monitor.watch import Finding
from er_model_lab.nodes.model_monitor import Memory
from er_model_lab.ros_monitor import MonitorCore, State
from er_models.errors import InputError
from er_models.files import load_model, save_model
from er_models.model import Array, Model
from er_models.prediction import motion, predict
from er_models.road import road_profile
from er_models.simulation import simulate
from er_ros_common.core import Said, When
from er_ros_common.health import Report

from er_common import topics
from er_damper_msgs.msg import DamperForce, NodeStatus
from er_ros_common import builders

CAR = Path(__file__).resolve().parents[3] / "config/vehicles/inove_quarter_car.yaml"
DT, STEP, LEARN = 0.005, 5_000_000, 10.0
Heard = dict[str, Array]
Change = Callable[[int, str, Any], Any]


def driven(model: Model) -> Heard:
    """What the sensors of a rig say for 24 s on a rough road, by the names of the lab's channels."""
    t, rng = np.arange(4800) * DT, np.random.default_rng(2)
    road = 0.3 * road_profile({"kind": "iso8608", "road_class": "C", "speed": 15.0}, t, 3)
    found = simulate(model, DT, road, 0.3 * rng.random(60)[(t / 0.4).astype(int)])
    sizes = dict(deflection="deflection", deflection_velocity="velocity", damper_force="force")
    sizes |= dict.fromkeys(("sprung_acceleration", "unsprung_acceleration"), "acceleration")
    for name, kind in sizes.items():
        found[name] = found[name] + model.rig[f"{kind}_noise"] * rng.standard_normal(t.size)
    return found


@pytest.fixture(scope="module")
def ride() -> Heard:
    return driven(load_model(CAR))


def core_of(**given: Any) -> MonitorCore:
    return MonitorCore(MonitorParameters(model_file=str(CAR), max_age=0.0, learn=LEARN, **given))


def messages(ride: Heard, k: int) -> dict[topics.Topic, Any]:
    """Those of a tick."""
    tick, at = (
        builders.Tick((k + 1) * STEP, k + 1),
        {name: float(y[k]) for name, y in ride.items()},
    )
    accelerations = (at["sprung_acceleration"], at["unsprung_acceleration"])
    return {
        topics.PWM_APPLIED: builders.pwm_duty(tick, at["duty"]),
        topics.ACCELERATION: builders.suspension_acceleration(tick, *accelerations),
        topics.DEFLECTION: builders.suspension_deflection(
            tick, at["deflection"], at["deflection_velocity"]
        ),
        topics.FORCE: builders.damper_force(tick, at["damper_force"]),
    }


def played(
    core: MonitorCore, ride: Heard, rows: range, state: State | None = None, lost: str = ""
) -> tuple[State, list[Said]]:
    """Messages of these ticks, without those of a topic."""
    state, found = state or core.start(), list[Said]()
    for k in rows:
        for topic, message in messages(ride, k).items():
            if topic.name != lost:
                state, said = core.on_message(state, topic, message, When((k + 1) * STEP, None))
                found += said
    return state, found


def of(said: list[Said], topic: topics.Topic) -> list[DamperForce]:
    return [message for name, message in said if name is topic]


def test_every_sample_is_answered_with_the_prediction_of_the_record(ride: Heard) -> None:
    said = played(core_of(), ride, range(400))[1]
    forces, errors = of(said, topics.MODEL_FORCE), of(said, topics.MODEL_RESIDUAL)
    assert [m.seq for m in forces] == [m.seq for m in errors] == [*range(1, 401)]
    y = {name: each[:400] for name, each in ride.items()}
    a = y["sprung_acceleration"] - y["unsprung_acceleration"]
    m = motion(DT, y["deflection"], y["deflection_velocity"], y["duty"], a)
    expected = predict(load_model(CAR), m)
    assert np.allclose([m.force for m in forces], expected, rtol=0.0, atol=1e-11)
    assert np.allclose(
        [m.force for m in errors], y["damper_force"] - expected, rtol=0.0, atol=1e-11
    )
    assert all(m.valid and m.status == DamperForce.STATUS_INITIALIZING for m in forces)


def test_the_same_messages_give_the_same_to_the_last_bit(ride: Heard) -> None:
    once, again = (played(core_of(), ride, range(300))[1] for _ in range(2))
    assert once == again


def findings(core: MonitorCore, ride: Heard, rows: range) -> tuple[dict[Finding, float], Report]:
    """When each finding was first said [s], and the health at the end."""
    state, first = core.start(), dict[Finding, float]()
    for k in rows:
        state, _ = played(core, ride, range(k, k + 1), state)
        first.setdefault(state.mind.watch.finding, k * DT)
    return first, core.report(state)


def test_a_change_of_the_damper_is_found_and_said(ride: Heard) -> None:
    worn = dict(ride)
    grown = math.sqrt(1.3**2 - 1.0)  # what adds 30 % to an error of 0.18 N
    drag = np.sign(ride["deflection_velocity"]) * np.where(ride["t"] > 16.0, 0.18 * grown, 0.0)
    worn["damper_force"] = ride["damper_force"] + drag
    first, report = findings(core_of(), worn, range(4800))
    assert LEARN < first[Finding.EXPLAINS] < 1.3 * LEARN
    assert 16.0 < first[Finding.FAILS] < 24.0
    assert (report.mode, report.status) == ("fails", NodeStatus.STATUS_DEGRADED)
    assert report.reason.startswith("the model no longer explains the damper")
    first, report = findings(core_of(), ride, range(4800))
    assert Finding.FAILS not in first
    assert float(str(report.values["error learnt [N]"])) == pytest.approx(0.18, rel=0.15)


def test_a_leak_that_begins_in_the_middle_of_the_drive_is_found() -> None:
    leak = {"f": 0.9, "t_0": 16.0, "t_r": 0.0, "q": 0.0, "d": 0.5}
    first, _ = findings(
        core_of(), driven(load_model(CAR).with_effect("oil_leakage", leak)), range(4800)
    )
    assert 16.0 < first[Finding.FAILS] < 20.0


def test_a_model_that_lacks_something_from_the_beginning_needs_a_known_floor(ride: Heard) -> None:
    worn = ride | {"damper_force": ride["damper_force"] + 1.0}
    assert Finding.FAILS not in findings(core_of(), worn, range(3200))[0]
    assert Finding.FAILS in findings(core_of(floor=0.18), worn, range(3200))[0]


def test_what_is_lost_is_bridged_and_a_long_gap_begins_anew(ride: Heard) -> None:
    core = core_of()
    state, _ = played(core, ride, range(400))
    without, said = played(core, ride, range(403, 500), state)
    assert without.mind.begun == state.mind.begun
    whole = of(played(core, ride, range(400, 500), state)[1], topics.MODEL_FORCE)
    assert of(said, topics.MODEL_FORCE)[-1].force == pytest.approx(whole[-1].force, abs=0.05)
    anew, said = played(core, ride, range(420, 500), state)
    assert anew.mind.begun == 421 * STEP
    assert all(m.valid for m in of(said, topics.MODEL_FORCE))


def test_without_a_force_the_model_goes_on_and_nothing_is_judged(ride: Heard) -> None:
    core = core_of()
    said = played(core, ride, range(300), lost=topics.FORCE.name)[1]
    assert all(m.valid for m in of(said, topics.MODEL_FORCE))
    assert not any(m.valid for m in of(said, topics.MODEL_RESIDUAL))


def test_silence_is_said_once(ride: Heard) -> None:
    core = core_of()
    state, _ = played(core, ride, range(100))
    state, said = core.on_time(state, When(102 * STEP + SECOND * 20, None))
    assert [m.status for _, m in said] == [DamperForce.STATUS_LOST] * 2
    assert core.on_time(state, When(104 * STEP + SECOND * 20, None))[1] == []
    assert core.report(state).mode == "silent"


def test_another_model_takes_over_at_a_sample(ride: Heard, tmp_path: Path) -> None:
    file = tmp_path / "other.yaml"
    save_model(load_model(CAR).with_effect("preload", {"F_0": 2.0}), file)
    first = core_of()
    state, before = played(first, ride, range(300))
    second = first.with_model(str(file))
    after = played(second, ride, range(300, 320), second.taken_over(state, first))[1]
    errors = of(before, topics.MODEL_RESIDUAL)[-1], of(after, topics.MODEL_RESIDUAL)[0]
    assert [m.seq for m in errors] == [300, 301]
    assert errors[1].force - errors[0].force == pytest.approx(-2.0, abs=1.0)
    assert second.model_id != first.model_id
    with pytest.raises(InputError, match=r"none\.yaml"):
        first.with_model("none.yaml")


def test_a_force_that_there_cannot_be_is_refused() -> None:
    assert core_of(force_source="force/unified").inputs[-1] is topics.estimated_force("unified")
    with pytest.raises(
        InputError, match="force_source: expected sensors/force, or force/OBSERVER"
    ):
        core_of(force_source="sensors/road")


def test_what_was_heard_last_is_remembered() -> None:
    memory = Memory(100)
    for k in range(1, 251):
        memory.add([Row(k * STEP, 1.0, math.nan, float(k), 0.0, 0.1, math.nan)])
    heard = memory.last(0.0)
    assert list(heard["deflection"]) == [*range(151, 251)]
    assert heard.keys().isdisjoint({"unsprung_acceleration", "damper_force"})
    assert memory.last(0.0975)["deflection"].size == 20
    memory.add([Row(STEP, 1.0, 1.0, 7.0, 0.0, 0.1, 0.0)])
    assert list(memory.last(0.0)["deflection"]) == [7.0]


def test_what_the_model_lacks_is_learnt_and_kept(ride: Heard, tmp_path: Path) -> None:
    rows = slice(0, 1600)
    heard = {name: y[rows] for name, y in ride.items() if name not in ("road", "tyre_deflection")}
    heard["damper_force"] = heard["damper_force"] + 2.0 * np.tanh(
        ride["deflection_velocity"][rows] / 0.01
    )
    said: list[dict[str, Any]] = []
    task = Task(str(CAR), "", str(tmp_path / "models"))
    found = learn(task, heard, Event(), said.append)
    assert found["verdict"] == "missing_effect", found
    assert found["effects"] == ["coulomb_friction"]
    assert found["rmse_after"] < 0.3 * found["rmse_before"]
    assert "coulomb_friction" in load_model(found["model"]).effects
    assert said[-1]["done"] == 1.0
    stopped = Event()
    stopped.set()
    assert learn(task, heard, stopped, said.append) == {"reason": "cancelled"}
    wrong = learn(Task("none.yaml", "", ""), heard, Event(), said.append)
    assert "none.yaml" in wrong["reason"]
