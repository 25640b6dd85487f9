"""Parameters of running nodes: what may change does, from the next sample on; the rest says why not."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("rclpy")

import numpy as np
import rclpy
from er_bringup.programs import CORES
from er_common.parameter_table import specs
from er_common.program import Program
from er_ftc_controller.programs import FTC, SKYHOOK
from er_ftc_controller.settings import controller_of
from er_models.files import load_model, save_model
from er_models.interlude import Interlude
from er_observers.programs import FAULT_ESTIMATOR, OBSERVERS
from er_plant_sim.nodes.plant import PlantNode
from er_plant_sim.rig import Rig, RigState
from er_ros_common.core import When, shell_of
from er_ros_common.core_node import CoreNode
from er_ros_common.managed import ManagedNode
from rclpy.parameter import Parameter

from er_common import topics
from er_plant_sim import rig as plant
from er_ros_common import builders
from test.graph_help import CONFIG, GAINS, VEHICLE, own_domain, plant_arguments

MORE = {
    FTC: ["-p", f"model_file:={VEHICLE}", "-p", f"gains_file:={CONFIG / 'gains/lpv_ftc.yaml'}"],
    FAULT_ESTIMATOR: ["-p", f"model_file:={VEHICLE}"],
    OBSERVERS["nlpv_polytopic"]: ["-p", f"model_file:={VEHICLE}", "-p", f"gains_file:={GAINS}"],
    SKYHOOK: [],
}


@pytest.fixture(autouse=True)
def ros() -> Iterator[None]:
    """ROS in this process, in a domain of its own."""
    with own_domain() as env:
        rclpy.init(args=[], domain_id=int(env["ROS_DOMAIN_ID"]))
        yield
        rclpy.try_shutdown()


@pytest.fixture
def node(request: pytest.FixtureRequest) -> Iterator[ManagedNode]:
    """A node of a program, configured and active."""
    program: Program = request.param
    if program in CORES.values():
        file = str(CONFIG / f"nodes/{program.name}.yaml")
        argv = ["--ros-args", "--params-file", file, *MORE[program]]
        made: ManagedNode = CoreNode(program, argv)
    else:
        made = PlantNode(plant_arguments("-p", "duty_source:=topic"))
    made.start()
    yield made
    made.on_stop()
    made.destroy_node()


def put(node: ManagedNode, **given: Any) -> str:
    """Set parameters at once; why not, empty where it was done."""
    made = [Parameter(name, value=value) for name, value in given.items()]
    result = node.set_parameters_atomically(made)
    assert result.successful != bool(result.reason)
    return str(result.reason)


def answer(core: Any, state: Any, number: int) -> tuple[Any, float]:
    """The duty of a Skyhook core for a sample that asks for the most."""
    tick, when = builders.Tick(number * 5_000_000, number), When(number * 5_000_000, None)
    body = builders.suspension_acceleration(tick, 2.0, 0.0)
    state, _ = core.on_message(state, topics.ACCELERATION, body, when)
    strut = builders.suspension_deflection(tick, 0.0, 0.2)
    state, ((_, said),) = core.on_message(state, topics.DEFLECTION, strut, when)
    return state, said.duty


@pytest.mark.parametrize("node", [SKYHOOK], indirect=True)
def test_a_tuning_value_acts_from_the_next_sample_on(node: CoreNode) -> None:
    node.core.p = replace(node.core.p, max_age=0.0)
    state, duty = answer(node.core, node.core.start(), 1)
    assert duty == node.p.u_max
    assert put(node, u_max=0.21, max_age=0.0) == (
        "/skyhook_controller: max_age: expected no change while the node is configured "
        "(ros2 lifecycle set: deactivate, cleanup), found one"
    )
    assert put(node, u_max=0.21) == ""
    assert node.p.u_max == node.get_parameter("u_max").value == 0.21
    node.core.p = replace(node.core.p, max_age=0.0)
    assert answer(node.core, state, 2)[1] == 0.21


@pytest.mark.parametrize("node", [SKYHOOK], indirect=True)
def test_values_that_contradict_are_refused_together(node: CoreNode) -> None:
    before, core = node.p, node.core
    assert "expected 0 <= u_min <= u_max <= 1, found 0.9 and" in put(node, timeout=0.5, u_min=0.9)
    assert "u_max" in put(node, u_max=1.5)
    assert "executor" in put(node, executor="single")
    assert (node.p, node.core) == (before, core)
    assert node.get_parameter("timeout").value == before.timeout
    assert put(node, u_min=0.5, u_max=0.9) == ""


@pytest.mark.parametrize("node", [SKYHOOK], indirect=True)
def test_all_may_change_while_a_node_is_unconfigured(node: CoreNode) -> None:
    assert put(node, max_age=0.5)
    node.trigger_deactivate()
    assert put(node, max_age=0.5)
    node.trigger_cleanup()
    assert put(node, max_age=0.5, listeners=3) == ""
    assert put(node, autostart=False)
    node.trigger_configure()
    assert node.core.limits[0].stale == node.incoming["sensors/deflection"].limits.stale == 0.5
    assert node.p.listeners == 3


@pytest.mark.parametrize("node", [*MORE], ids=lambda p: p.name, indirect=True)
def test_a_core_with_other_values_is_the_core_that_is_made_of_them(node: CoreNode) -> None:
    shell = shell_of(CORES[node.get_name()])
    dynamic = [spec for spec in specs(type(node.p)) if spec.dynamic and spec.kind is float]
    assert dynamic
    for spec in dynamic:
        old = getattr(node.p, spec.attribute)
        new = 0.9 * old + 0.1 * spec.high if old == spec.low else 0.9 * old + 0.1 * spec.low
        p = replace(node.p, **{spec.attribute: new})
        tuned, made = node.core.tuned(p), shell.make(p)
        assert tuned.p == p
        assert tuned.limits == made.limits
        assert _inside(tuned) == _inside(made), spec.name
        assert _inside(tuned) != _inside(node.core), spec.name
    assert put(node, timeout=0.03) == ""
    assert node.core.p.timeout == 0.03
    assert {each.limits for each in node.incoming.values()} == set(node.core.limits)


def _inside(core: Any) -> str:
    """What a core computes with, as text."""
    each = {k: v for k, v in vars(core).items() if k not in ("model", "loaded")}
    if "controller" in each:
        each["controller"] = controller_of(core.p, core.model, core.loaded)
        assert str(each["controller"]) == str(core.controller)
    return str(each)


@pytest.mark.parametrize("node", [Program("plant", "er_plant_sim", "")], indirect=True)
def test_the_plant_takes_other_limits_of_the_duty(node: PlantNode) -> None:
    assert put(node, safe_duty=0.12, command_timeout=0.03, duty_slew=2.0) == ""
    gate = node.rig.gate
    assert (gate.safe_duty, gate.timeout, gate.slew) == (0.12, 0.03, 2.0)
    assert node.limits.stale == node.incoming["pwm/command"].limits.stale == 0.03
    assert "safe_duty: expected a duty between duty_min and duty_max" in put(node, safe_duty=0.99)
    assert node.rig.gate is gate
    assert "rate: expected no change" in put(node, rate=100.0)
    node.trigger_deactivate()
    node.trigger_cleanup()
    assert put(node, rate=100.0) == ""
    node.trigger_configure()
    assert node.rig.dt == 0.01
    assert node.timer.timer_period_ns == 10_000_000


@pytest.mark.parametrize("node", [Program("plant", "er_plant_sim", "")], indirect=True)
def test_the_plant_takes_another_damper_in_the_middle_of_its_drive(
    node: PlantNode, tmp_path: Path
) -> None:
    def driven(rig: Rig, state: RigState, ticks: int) -> RigState:
        for _ in range(ticks):
            state = plant.advance(rig, state)
        return state

    def deflections(rig: Rig, state: RigState) -> Any:
        each = []
        for _ in range(600):
            state = driven(rig, state, 1)
            assert state.sim.output is not None
            each.append(state.sim.output.deflection)
        return np.array(each)

    worn = tmp_path / "worn.yaml"
    save_model(load_model("inove_guo").with_effect("preload", {"F_0": 3.0}), worn)
    node.state = driven(node.rig, node.state, 400)
    before, rig, model_id = node.state, node.rig, node.health.model_id
    assert "none.yaml" in put(node, damper_file=str(tmp_path / "none.yaml"))
    assert (node.state, node.rig) == (before, rig)
    assert put(node, damper_file=str(worn)) == ""
    assert node.health.model_id != model_id
    assert (node.state.sim.tick, node.state.sim.output) == (before.sim.tick, before.sim.output)
    assert np.array_equal(node.state.sim.plant.q, before.sim.plant.q)
    # the car settles where its springs hold the preload
    there, here = (deflections(r, s) for r, s in ((node.rig, node.state), (rig, before)))
    stiffness = load_model(VEHICLE).value("quarter_car", "k_s") + 263.0
    assert (there - here)[300:].mean() == pytest.approx(-3.0 / stiffness, rel=0.05)
    assert put(node, damper_file="") == ""
    back = deflections(
        node.rig, node.state
    )  # what the damper remembers begins anew, and is soon the same
    assert np.allclose(back[400:], here[400:], rtol=0.0, atol=1e-6)


@pytest.mark.parametrize("node", [Program("plant", "er_plant_sim", "")], indirect=True)
def test_the_plant_takes_a_planned_run_in_the_middle_of_its_drive(
    node: PlantNode, tmp_path: Path
) -> None:
    def run(name: str, amplitude: float, more: str = "") -> str:
        path = tmp_path / name
        path.write_text(
            f"schema: er_program 1\nduration: 0.3\nduty: {{kind: constant, level: 0.2}}\n{more}"
            f"road: {{kind: sine, amplitude: {amplitude}, frequency: 3.0}}\n"
        )
        return str(path)

    node.state = node.state._replace(sim=node.state.sim._replace(tick=400))
    rig = node.rig
    assert "none.yaml" in put(node, planned_file=str(tmp_path / "none.yaml"))
    assert "stroke: expected at most 0.012 m of deflection" in put(
        node, planned_file=run("far", 0.03)
    )
    machine = run("machine", 0.001, "moves: damper\n")
    assert "moves: expected wheel" in put(node, planned_file=machine)
    assert node.rig is rig
    assert put(node, planned_file=run("run", 0.002)) == ""
    drive = node.rig.program
    assert isinstance(drive, Interlude)
    assert (drive.drive, drive.begin) == (rig.program, 401 * rig.dt)
    assert "no run under way: empty ends it" in put(node, planned_file=run("more", 0.001))
    node.state = node.state._replace(sim=node.state.sim._replace(tick=640))
    assert put(node, planned_file="") == ""
    assert node.rig.program.ends == pytest.approx(641 * rig.dt)  # type: ignore[union-attr]
    assert node.report().values["duties limited"] == 0


@pytest.mark.parametrize("node", [OBSERVERS["nlpv_polytopic"]], indirect=True)
def test_an_observer_keeps_what_it_has_until_other_files_belong_together(
    node: CoreNode, tmp_path: Path
) -> None:
    car = load_model(VEHICLE)
    rubbing, thicker = tmp_path / "rubbing.yaml", tmp_path / "thicker.yaml"
    save_model(car.with_effect("coulomb_friction", {"F_c": 1.0, "v_0": 3e-3}), rubbing)
    values = {**car.effects["passive"], "c0": 1.1 * car.value("passive", "c0")}
    save_model(car.with_effect("passive", values), thicker)
    node.state, core, p = node.core.start(), node.core, node.p
    assert "leave out one of coulomb_friction" in put(node, model_file=str(rubbing))
    assert "model.fingerprint: expected" in put(node, model_file=str(thicker))
    assert "expected 'nlpv_polytopic'" in put(
        node, gains_file=str(CONFIG / "gains/unified.yaml"), timeout=0.2
    )
    assert (node.core, node.p, node.core.limits[0].gap) == (core, p, 0.05)
    assert put(node, model_file=str(rubbing), leave_out=True) == ""
    assert node.core.left_out == ("coulomb_friction",)
    assert node.core.model_id == core.model_id
    assert node.get_parameter("model_file").value == str(rubbing)


@pytest.mark.parametrize("node", [FAULT_ESTIMATOR], indirect=True)
def test_a_fault_estimator_begins_anew_with_another_model(node: CoreNode, tmp_path: Path) -> None:
    car, file = load_model(VEHICLE), tmp_path / "thicker.yaml"
    values = {**car.effects["passive"], "c0": 1.1 * car.value("passive", "c0")}
    more = car.with_effect("passive", values).with_effect("coulomb_friction", {"F_c": 1.0})
    save_model(more, file)
    node.state = node.core.start()._replace(mind="of the model before")
    assert "found passive" in put(node, model_file=str(file))
    assert node.state.mind
    assert put(node, model_file=str(file), leave_out=True) == ""
    assert node.core.left_out == ("coulomb_friction",)
    assert node.state.mind is None
    assert node.core.estimator.p[1] == pytest.approx(1.1 * car.value("passive", "c0"))
    assert node.health.model_id == node.core.model_id
