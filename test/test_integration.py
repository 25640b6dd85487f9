"""Files for the tools of a vehicle stack: valid, current, and naming only what there is."""

from __future__ import annotations

import json
import math
import xml.etree.ElementTree as ET
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest
import yaml

pytest.importorskip("rclpy")

from er_bringup.given import CAR
from er_bringup.integration import foxglove, names, plotjuggler
from er_bringup.integration.write import files
from er_bringup.nodes.ros2_control_joint import JointNode
from er_bringup.programs import ESTIMATES
from er_bringup.ros_joint import (
    COMMANDS,
    DUTY_COMMANDS,
    DUTY_STATES,
    STATES,
    JointCore,
    JointParameters,
    State,
)
from er_common.parameter_table import build
from er_models.files import load_model
from er_models.static_damper import static_damper
from er_ros_common.builders import Tick
from er_ros_common.core import When
from sensor_msgs.msg import JointState

from er_common import topics
from er_ros_common import builders, clock
from test.conftest import ROOT

CONFIG = ROOT / "config"
TOPICS = {t.name: t for t in (*topics.MEASUREMENTS, *ESTIMATES, topics.DIAGNOSTICS)}
NUMERIC = ("double", "float", "uint8", "uint64", "boolean")


@pytest.mark.parametrize("name", list(files()))
def test_the_files_kept_are_those_that_are_made(name: str) -> None:
    hint = "./er exec python -m er_bringup.integration.write --out config"
    assert (CONFIG / name).read_text() == files()[name], hint


def field_of(path: str, namespace: str, between: str) -> str:
    """Type of the field that a layout names; AssertionError where there is none."""
    prefix = f"/{namespace}/" if namespace else "/"
    assert path.startswith(prefix)
    topic, _, field = path.removeprefix(prefix).rpartition(between)
    assert topic in TOPICS, path
    kinds = TOPICS[topic].type.get_fields_and_field_types()
    assert field in kinds, path
    return str(kinds[field])


@pytest.mark.parametrize("namespace", ["", "vehicle/suspension/front_left"])
def test_plotjuggler_shows_fields_that_there_are(namespace: str) -> None:
    root = ET.fromstring(plotjuggler.layout(namespace).split("\n", 1)[1])
    assert root.tag == "root"
    curves = [str(curve.get("name")) for curve in root.iter("curve")]
    assert len(curves) >= 15
    assert all(field_of(name, namespace, "/") in NUMERIC for name in curves)
    stamped = [(p.get("ID"), p.find("use_header_stamp")) for p in root.iter("plugin")]
    assert {
        name for name, each in stamped if each is not None and each.get("value") == "true"
    } == {
        "DataLoad ROS2 bags",
        "ROS2 Topic Subscriber",
    }
    for splitter in root.iter("DockSplitter"):
        sizes = [float(text) for text in str(splitter.get("sizes")).split(";")]
        assert len(sizes) == len(splitter) == int(str(splitter.get("count")))
        assert math.isclose(sum(sizes), 1.0, abs_tol=1e-4)


@pytest.mark.parametrize("namespace", ["", "vehicle/suspension/front_left"])
def test_foxglove_shows_fields_that_there_are(namespace: str) -> None:
    document = json.loads(foxglove.layout(namespace))
    panels = document["configById"]
    paths = [path for panel in panels.values() for path in panel.get("paths", ())]
    assert len(paths) >= 15
    for path in paths:
        assert field_of(path["value"], namespace, ".") in NUMERIC
        assert path["timestampMethod"] == "headerStamp"

    def leaves(part: Any) -> list[str]:
        return (
            [part] if isinstance(part, str) else [*leaves(part["first"]), *leaves(part["second"])]
        )

    shown = [leaf for tab in panels[document["layout"]]["tabs"] for leaf in leaves(tab["layout"])]
    assert sorted([*shown, document["layout"]]) == sorted(panels)


def test_rosbag2_asks_for_no_more_than_is_offered_and_loses_nothing() -> None:
    found = yaml.safe_load((CONFIG / "recording/qos_overrides.yaml").read_text())
    assert set(found) == {f"/{name}" if name[0] != "/" else name for name in TOPICS}
    for name, asked in found.items():
        offered = (TOPICS.get(name[1:]) or TOPICS[name]).publisher
        assert asked["reliability"] == "reliable"
        assert offered.reliable
        assert asked["durability"] == ("transient_local" if offered.latched else "volatile")
        assert asked["depth"] >= 1000
    car = yaml.safe_load((CONFIG / "recording/qos_overrides_car.yaml").read_text())
    corners = {name.split("/")[3] for name in car if name.startswith("/vehicle/suspension/")}
    assert corners == set(CAR)
    assert len(car) == 4 * (len(found) - 1) + 1


def test_the_guide_holds_the_table_of_names() -> None:
    assert names.table() in (ROOT / "docs/vehicle.md").read_text()
    named = {row.split("`")[1] for row in names.table().splitlines() if "`" in row}
    assert named == set(TOPICS) - {topics.DIAGNOSTICS.name}


def test_the_urdf_and_the_controllers_fit_the_node() -> None:
    root = ET.parse(CONFIG / "ros2_control/corner.urdf").getroot()
    base, name = "/vehicle/suspension/front_left", JointParameters().joint
    controllers = yaml.safe_load((CONFIG / "ros2_control/controllers.yaml").read_text())
    for system, joint_name, ends, states, controller in zip(
        root.findall("ros2_control"),
        (name, f"{name}_duty"),
        ((STATES, COMMANDS), (DUTY_STATES, DUTY_COMMANDS)),
        (["position", "velocity", "effort"], ["position"]),
        ("force_controller", "duty_controller"),
        strict=True,
    ):
        given = {str(p.get("name")): str(p.text) for p in system.iter("param")}
        assert given["joint_states_topic"] == f"{base}/{ends[0].name}"
        assert given["joint_commands_topic"] == f"{base}/{ends[1].name}"
        (joint,) = system.findall("joint")
        assert joint.get("name") == joint_name
        assert joint_name in [j.get("name") for j in root.findall("joint")]
        assert [i.get("name") for i in joint.findall("state_interface")] == states
        asked = controllers[controller]["ros__parameters"]
        assert asked["joints"] == [joint_name]
        assert [asked["interface_name"]] == [
            i.get("name") for i in joint.findall("command_interface")
        ]
    assert controllers["controller_manager"]["ros__parameters"]["update_rate"] == 200


def test_an_effort_is_newtons_both_ways() -> None:
    """The duty of a commanded force gives that force in the static law; what it cannot give gets the nearest end."""
    model = load_model(CONFIG / "dampers/inove_guo.yaml")
    damper = static_damper(model)
    core = joint_core(model_file=str(CONFIG / "dampers/inove_guo.yaml"))
    now, x, v = at(sample(1)), 0.002, 0.15

    def asked(core: JointCore, force: float, v: float | None = v) -> list[float]:
        state, _ = joint_state(core, core.start(), builders.suspension_deflection(sample(1), x, v))
        command = JointState(name=["damper"], effort=[force])
        _, said = core.on_message(state, COMMANDS, command, now)
        return [message.duty for _, message in said]

    for duty in (0.05, 0.2, 0.7):
        force = float(damper.force(np.array([x]), np.array([v]), duty)[0])
        assert asked(core, force) == [pytest.approx(duty)]
    assert [*asked(core, -50.0), *asked(core, 1e6)] == [0.0, 1.0]
    assert asked(core, 5.0, None) == asked(core, math.nan) == asked(joint_core(), 5.0) == []


def test_the_applied_duty_is_the_state_of_its_joint() -> None:
    core, applied = joint_core(), builders.pwm_duty(sample(1), 0.3)
    _, ((topic, joint),) = core.on_message(
        core.start(), topics.PWM_APPLIED, applied, at(sample(1))
    )
    assert topic is DUTY_STATES
    assert (list(joint.name), list(joint.position)) == (["damper_duty"], [0.3])
    applied.valid = False
    assert core.on_message(core.start(), topics.PWM_APPLIED, applied, at(sample(1)))[1] == []


def test_a_joint_command_becomes_the_duty_that_answers_the_last_sample() -> None:
    core, now = JointCore(build(JointParameters, {}, {})), When(0, None)
    command = JointState(name=["other", "damper_duty"], position=[9.0, 0.25])
    state, said = core.on_message(core.start(), DUTY_COMMANDS, command, now)
    assert (said, state.refused) == ([], 1)  # there is no sample to answer yet
    tick = Tick(5_000_000, 1)
    state, _ = core.on_message(state, topics.FORCE, builders.damper_force(tick, -3.5), now)
    deflection = builders.suspension_deflection(tick, 0.01, -0.2)
    state, ((topic, joint),) = core.on_message(state, topics.DEFLECTION, deflection, now)
    assert topic is STATES
    assert (list(joint.name), list(joint.position), list(joint.velocity), list(joint.effort)) == (
        ["damper"], [0.01], [-0.2], [-3.5],
    )  # fmt: skip
    assert joint.header.stamp.nanosec == 5_000_000
    state, ((topic, duty),) = core.on_message(state, DUTY_COMMANDS, command, now)
    assert (topic, duty.duty, duty.seq, duty.command_seq) == (topics.PWM_COMMAND, 0.25, 1, 1)
    assert duty.header.frame_id == "damper"
    for bad in (
        JointState(name=["damper_duty"], position=[math.nan]),
        JointState(name=["damper_duty"]),
    ):
        state, said = core.on_message(state, DUTY_COMMANDS, bad, now)
        assert said == []
    lost = builders.suspension_deflection(Tick(10_000_000, 2), 0.0, valid=False)
    assert core.on_message(state, topics.DEFLECTION, lost, now)[1] == []


MS = 1_000_000
NOW = 1_700_000_000_000_000_000
"""Time on the system clock of the tests below [ns]."""


def joint_core(**given: Any) -> JointCore:
    """A core with the measured force."""
    return JointCore(build(JointParameters, given, {}))


def sample(k: int) -> Tick:
    """The k-th sample at 200 Hz."""
    return Tick(NOW + 5 * k * MS, k)


def at(tick: Tick) -> When:
    """It comes a millisecond after it was measured."""
    return When(tick.stamp - NOW + MS, tick.stamp + MS)


def joint_state(core: JointCore, state: State, message: Any) -> tuple[State, list[list[float]]]:
    """Position, velocity and effort of what a deflection leads to; empty where it leads to nothing."""
    came = at(Tick(max(clock.from_stamp(message.header.stamp), NOW), 0))
    state, said = core.on_message(state, topics.DEFLECTION, message, came)
    return state, [list(p) for _, j in said for p in (j.position, j.velocity, j.effort)]


def test_a_joint_state_holds_no_force_that_is_old_or_no_number() -> None:
    core = joint_core()
    state = core.start()
    for k in (1, 2):
        force = builders.damper_force(sample(k), 12.5)
        if k == 2:
            force.force = math.nan  # as a foreign publisher may send it, and calls it valid
        state, _ = core.on_message(state, topics.FORCE, force, at(sample(k)))
    for k in range(1, 20):
        deflection = builders.suspension_deflection(sample(k), 0.01, -0.2)
        state, found = joint_state(core, state, deflection)
        fresh = k <= 11  # 50 ms after its own sample
        assert found == [[0.01], [-0.2], [12.5] if fresh else []]
        assert state.lacks == (() if fresh else ("sensors/force",))


@pytest.mark.parametrize(
    ("age", "given", "taken"),
    [
        (0, {}, True),
        (49, {}, True),
        (51, {}, False),
        (1000, {}, False),
        (-1000, {}, True),
        (1000, {"max_age": 0.0}, True),
        (None, {}, True),
    ],
    ids=["new", "in time", "old", "held up", "of a clock ahead", "ages mean nothing", "no stamp"],
)
def test_a_joint_command_that_was_held_up_is_refused(
    age: int | None, given: dict[str, Any], *, taken: bool
) -> None:
    """The duty would be stamped with the newest sample: the plant could not know how old it is."""
    core = joint_core(**given)
    state, now = core.start(), at(sample(1))
    deflection = builders.suspension_deflection(sample(1), 0.01, -0.2)
    state, _ = core.on_message(state, topics.DEFLECTION, deflection, now)
    command = JointState(name=["damper_duty"], position=[0.25])
    if age is not None:
        assert now.system is not None
        command.header.stamp = clock.to_stamp(now.system - age * MS)
    state, said = core.on_message(state, DUTY_COMMANDS, command, now)
    assert (len(said), state.refused) == (taken, not taken)


def test_a_joint_state_holds_what_is_valid_and_finite_and_nothing_else() -> None:
    core = joint_core()
    state = core.start()
    for k, (x, v, velocity_valid, expected) in enumerate(
        [
            (0.01, 0.3, True, [[0.01], [0.3], []]),
            (math.nan, math.inf, True, []),
            (0.01, math.inf, True, [[0.01], [], []]),
            (0.01, 0.0, False, [[0.01], [], []]),
        ],
        start=1,
    ):
        message = builders.suspension_deflection(sample(k), 0.0, 0.0)
        message.deflection, message.velocity, message.velocity_valid = x, v, velocity_valid
        state, found = joint_state(core, state, message)
        assert found == expected
    assert state.unusable == 1
    assert state.lacks == ("velocity", "sensors/force")


@pytest.mark.parametrize("seconds", [-5, 0, 1_600_000_000, 1_800_000_000, 2**31 - 1])
@pytest.mark.parametrize("max_age", [0.02, 0.0])
def test_a_bad_stamp_is_no_sample_and_a_command_after_it_no_crash(
    seconds: int, max_age: float
) -> None:
    core = joint_core(max_age=max_age)
    message = builders.suspension_deflection(sample(1), 0.01, -0.2)
    message.header.stamp.sec, message.header.stamp.nanosec = (
        seconds,
        0 if seconds < 1 else 999_999_999,
    )
    state, found = core.on_message(core.start(), topics.DEFLECTION, message, at(sample(1)))
    aged = max_age > 0.0
    assert bool(found) == (0 < seconds < 2**31 - 1 and not aged)
    command = JointState(name=["damper_duty"], position=[0.25])
    state, said = core.on_message(state, DUTY_COMMANDS, command, When(MS, NOW))
    assert bool(said) == bool(found)


def test_the_joints_status_is_valid_while_joint_states_come() -> None:
    core, ends = joint_core(), [SimpleNamespace(get_publisher_count=lambda: 1)]
    state, _ = joint_state(core, core.start(), builders.suspension_deflection(sample(1), 0.01))
    soon, late = at(sample(2)), When(at(sample(1)).steady + 60 * MS, None)
    cases = ((core.start(), soon, "ready"), (state, soon, "running"), (state, late, "silent"))
    for known, when, mode in cases:
        node: Any = SimpleNamespace(
            core=core, p=core.p, state=known, ends=ends, when=lambda w=when: w
        )
        told = JointNode.report(node)
        assert (told.mode, told.valid) == (mode, mode == "running")


def test_a_joint_command_after_50_ms_without_samples_is_refused() -> None:
    core, command = joint_core(), JointState(name=["damper_duty"], position=[0.25])
    state, _ = joint_state(core, core.start(), builders.suspension_deflection(sample(1), 0.01))
    for late, refused in ((10 * MS, False), (60 * MS, True)):
        when = When(at(sample(1)).steady + late, None)
        assert core.silent(state, when.steady) == refused
        _, said = core.on_message(state, DUTY_COMMANDS, command, when)
        assert bool(said) != refused
