"""The graph as data: arguments, nodes, and equal command lines under ros2 launch and er up."""

import importlib.util
import sys
import types
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("rclpy")

from er_bringup.arguments import ARGUMENTS, table
from er_bringup.given import CAR, complete, parse
from er_bringup.graph import NodeSpec, nodes
from er_common.parameter_table import build as parameters_of
from er_common.parameter_table import specs as bounds_of
from er_ftc_controller.ros_skyhook import SkyhookCore, SkyhookParameters
from er_models.errors import InputError
from er_observers.programs import OBSERVERS
from er_plant_sim.settings import PlantParameters
from er_ros_common.builders import Tick
from er_ros_common.core import When

from er_bringup import graph, up
from er_common import topics
from er_ros_common import builders
from test.graph_help import CONFIG, ROOT

LAUNCH = ROOT / "src/er_bringup/launch/system.launch.py"


def specs(*pairs: str) -> dict[str, NodeSpec]:
    """Nodes of these arguments by executable."""
    return {spec.executable: spec for spec in nodes(parse(pairs), CONFIG)}


@pytest.mark.parametrize(
    ("pair", "words"),
    [
        ("contrller:=none", r"contrller: expected a known key \(did you mean controller\?\)"),
        ("controller:=pid", "controller: expected one of skyhook, ftc, none, found 'pid'"),
        ("duration:=long", r"duration: expected a number in -1\.\.1000000, found 'long'"),
        ("seed:=1.5", r"seed: expected an integer in -1\.\.2147483648, found '1.5'"),
        ("controller", "controller: expected KEY:=VALUE"),
        ("duration:=nan", r"duration: expected a number in .*, found 'nan'"),
        ("priority:=500", r"priority: expected an integer in 0\.\.99, found '500'"),
        ("seed:=-7", "seed: expected an integer in .*, found '-7'"),
        ("duration:=-5", "duration: expected a number in .*, found '-5'"),
        ("rate_factor:=inf", r"rate_factor: expected a number in 0\.\.50, found 'inf'"),
        ("namespace:=/front//left", "namespace: expected names of letters.* found '/front//left'"),
        ("namespace:=front left", "namespace: expected names of letters"),
        ("namespace:=front__left", "single underscores"),
        ("namespace:=car/__x", "single underscores"),
        ("record:=/", "record: expected a path that does not exist yet"),
    ],
)
def test_a_bad_argument_is_one_line(pair: str, words: str) -> None:
    with pytest.raises(InputError, match=words) as caught:
        parse([pair])
    assert caught.value.exit_status == 2
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("pair", "words"),
    [
        ("program:=nix", "expected a file, or one of .*chirp.*, found no such file"),
        ("model:=nix", "expected a file, or one of inove_quarter_car"),
        (
            "observers:=nlpv_polytopic,nix",
            "observers: expected none, or some of unified, nlpv_polytopic",
        ),
        ("observers:=unified, unified", "observers: expected .*, found 'unified' twice"),
        ("gains:=unified", "gains: expected one observer beside it .*found unified,nlpv"),
        ("damper:=monotube_passive", "one that belongs to this car, found one of 1500 N"),
        ("hardware:=udp:rig:5005", "calibration: expected the calibration .*found nothing"),
        ("hardware:=udp:127.0.0.1:99999", "hardware: expected a port of at most 65535"),
        ("hardware:=can:0", "hardware: expected serial:PORT or serial:PORT@BAUD, udp:HOST:PORT"),
        ("corners:=fü,b", "corners: expected 4, or different names of letters"),
        ("corners:=a__b,c", "single underscores"),
        ("rate_factor:=2.0", "rate_factor: expected 1 in mode realtime, found '2'"),
        ("rate_factor:=0", "rate_factor: expected 1 in mode realtime, found '0'"),
        ("remap:=x", "remap: expected OLD=NEW with commas between, found 'x'"),
        ("remap:=sensors/force=force/unified", "a name that no other topic of the graph has"),
        ("remap:=sensors/force=/pwm/applied", "a name that no other topic of the graph has"),
        (
            "remap:=sensor/acceleration=/x/a",
            r"remap: expected a topic of the graph \(did you mean sensors/acceleration\?\), found",
        ),
        ("remap:=sensors/force=/x//a", "remap: expected a topic, names .*, found '/x//a' for"),
        ("remap:=sensors/force=/a,/sensors/force=/b", "remap: expected each topic once"),
        ("remap:=sensors/force=/a,sensors/road=/a", "remap: expected each topic once"),
    ],
)
def test_a_name_that_does_not_exist_is_one_line(pair: str, words: str) -> None:
    with pytest.raises(InputError, match=words):
        nodes(parse([pair]), CONFIG)


def test_every_argument_is_documented_in_the_table() -> None:
    lines = table().splitlines()
    assert [line.split()[0] for line in lines] == [a.name for a in ARGUMENTS]


def test_the_default_graph_is_a_closed_loop_with_all_observers() -> None:
    found = specs()
    observers = [program.name for program in OBSERVERS.values()]
    each = len(observers)
    assert list(found) == [*observers, "skyhook_controller", "plant"]
    for name in observers:
        file = str(found[name].parameters["gains_file"])
        assert file.endswith(f"gains/{name.removesuffix('_observer')}.yaml")
    assert found["plant"].parameters["duty_source"] == "topic"
    assert found["plant"].parameters["wait_for"] == [each + 1, 1, 0, 0, each]
    assert found["plant"].parameters["wait_for_nodes"] == list(found)[:-1]
    assert found["skyhook_controller"].parameters["listeners"] == 1
    assert found["nlpv_polytopic_observer"].parameters["listeners"] == 0


def test_the_fault_tolerant_controller_gets_the_model_and_its_gains() -> None:
    found = specs("controller:=ftc", "mode:=lockstep")["ftc_controller"]
    assert str(found.parameters["model_file"]).endswith("vehicles/inove_quarter_car.yaml")
    assert str(found.parameters["gains_file"]).endswith("gains/lpv_ftc.yaml")
    assert found.files[0].endswith("nodes/ftc_controller.yaml")
    assert found.parameters["timeout"] == 1.0
    assert "timeout" not in specs("controller:=ftc")["ftc_controller"].parameters


def test_the_model_monitor_goes_by_the_model_and_what_it_says_is_recorded() -> None:
    found = specs("model_monitor:=true", "damper:=inove_bingham", RECORD)
    given = found["model_monitor"].parameters
    assert str(given["model_file"]).endswith("vehicles/inove_quarter_car.yaml")
    assert {"model/force", "model/residual"} <= set(found["recorder"].parameters["sources"])  # type: ignore[arg-type]
    assert "model_monitor" in found["plant"].parameters["wait_for_nodes"]  # type: ignore[operator]


def test_the_fault_estimator_comes_when_asked_for() -> None:
    assert "fault_estimator" not in specs()
    found = specs("fault_estimator:=true", "controller:=ftc")
    assert found["fault_estimator"].parameters["listeners"] == 1
    assert found["fault_estimator"].files[0].endswith("nodes/fault_estimator.yaml")
    assert "fault_estimator" in found["plant"].parameters["wait_for_nodes"]


def test_files_of_own_effects_reach_the_plant_alone(tmp_path: Path) -> None:
    files = [tmp_path / name for name in ("one.py", "two.py")]
    for file in files:
        file.touch()
    found = specs(f"effects_from:={files[0]}, {files[1]}")
    assert found["plant"].parameters["effects_from"] == tuple(str(file) for file in files)
    assert "effects_from" not in found["nlpv_polytopic_observer"].parameters
    with pytest.raises(InputError, match=r"three.py: expected a file, found no such file"):
        specs("effects_from:=three.py")


def test_the_plant_waits_for_the_recorder_too(tmp_path: Path) -> None:
    found = specs(f"record:={tmp_path / 'bag'}", "observers:=none", "controller:=none")
    assert list(found) == ["recorder", "plant"]
    assert found["plant"].parameters["wait_for"] == [1, 1, 1, 1, 1]
    assert found["plant"].parameters["duty_source"] == "program"
    assert found["recorder"].parameters["out"] == str(tmp_path / "bag")
    assert "recorder" not in found["plant"].parameters


def test_in_lockstep_the_plant_waits_for_what_is_recorded_of_everybody(tmp_path: Path) -> None:
    given = (f"record:={tmp_path / 'bag'}", "mode:=lockstep", "observers:=unified")
    (plant,) = (spec for spec in nodes(parse(given), CONFIG) if spec.executable == "plant")
    assert plant.parameters["recorder"] == "recorder"
    assert plant.parameters["recorded"] == [
        *(topic.name for topic in topics.SENSORS),
        "force/unified",
        "pwm/command",
    ]
    corners = nodes(parse((*given, "corners:=a,b", "namespace:=car")), CONFIG)
    asked = [s.parameters["recorder"] for s in corners if s.executable == "plant"]
    assert asked == ["/car/recorder"] * 2


def test_the_recorder_waits_for_everybody_it_will_record(tmp_path: Path) -> None:
    found = specs(f"record:={tmp_path / 'bag'}")
    sources = found["recorder"].parameters["sources"]
    assert isinstance(sources, list)
    assert {"sensors/road", "pwm/applied", "pwm/command", "force/nlpv_polytopic"} <= set(sources)
    assert found["skyhook_controller"].parameters["listeners"] == 2
    assert found["nlpv_polytopic_observer"].parameters["listeners"] == 1


def test_the_program_can_say_the_duty_beside_a_controller() -> None:
    found = specs("duty:=program")
    assert "skyhook_controller" in found
    assert found["plant"].parameters["duty_source"] == "program"


def test_two_topics_may_change_names_and_every_corner_has_a_seed() -> None:
    specs("remap:=sensors/force=force/unified,force/unified=force/mine")
    specs("corners:=a,b", "seed:=2147483647")
    with pytest.raises(InputError, match="seed: expected at most 2147483647, as each corner"):
        specs("corners:=a,b", "seed:=2147483648")
    with pytest.raises(InputError, match=r"above 0 \(0 only in mode lockstep\), found '0'"):
        specs("mode:=sim_time", "rate_factor:=0")


@pytest.mark.parametrize(
    ("mode", "times"),
    [
        ("realtime", {}),
        ("sim_time", {"use_sim_time": True, "max_age": 0.0, "pace": 1.0}),
        ("lockstep", {"max_age": 0.0}),
    ],
)
def test_simulated_time_is_not_compared_with_the_system_clock(
    mode: str, times: dict[str, object]
) -> None:
    found = specs(f"mode:={mode}")
    for name in ("skyhook_controller", "nlpv_polytopic_observer"):
        given = {
            k: v
            for k, v in found[name].parameters.items()
            if k in ("use_sim_time", "max_age", "pace")
        }
        assert given == times


@pytest.mark.parametrize(
    ("mode", "rate_factor", "seconds"),
    [
        ("realtime", 1.0, 0.025),
        ("sim_time", 1.0, 0.025),
        ("sim_time", 0.1, 0.25),
        ("sim_time", 10.0, 0.025),
        ("lockstep", 0.0, 10.0),
    ],
)
def test_a_dead_sensor_counts_in_simulated_time_and_only_lockstep_waits_for_it(
    mode: str, rate_factor: float, seconds: float
) -> None:
    found = specs(f"mode:={mode}", f"rate_factor:={rate_factor}")["skyhook_controller"]
    given = {k: v for k, v in found.parameters.items() if k in ("max_age", "pace")}
    rest = {"u_min": 0.0, "u_max": 0.3, "safe_duty": 0.1, "corner_frequency": 0.1}
    core = SkyhookCore(parameters_of(SkyhookParameters, rest | given, {}))
    state = core.start()
    tick, came = Tick(5_000_000, 1), When(1_000_000_000, 5_000_000)
    for topic, message in (
        (topics.ACCELERATION, builders.suspension_acceleration(tick, 0.1, 0.2)),
        (topics.DEFLECTION, builders.suspension_deflection(tick, 0.01, -0.2)),
    ):
        state, answers = core.on_message(state, topic, message, came)
    assert answers
    for share, safe in ((0.95, False), (1.05, True)):
        steady = came.steady + round(1e9 * share * seconds)
        _, said = core.on_time(state, When(steady, 5_000_000))
        assert [m.source == m.SOURCE_SAFE for _, m in said] == [True] * safe


def test_the_namespace_reaches_every_node() -> None:
    for pairs in (("composed:=false",), ("composed:=true", RECORD)):
        for spec in specs("namespace:=front_left", *pairs).values():
            assert [*spec.arguments(), *spec.place()][-2:] == ["-r", "__ns:=/front_left"]


def test_a_real_rig_takes_the_place_of_the_plant() -> None:
    pairs = ("hardware:=udp:rig:5005", "calibration:=device_emulator", "road:=program")
    found = specs(*pairs)
    assert "plant" not in found
    bridge = found["hardware_bridge"]
    assert bridge.files[0].endswith("nodes/hardware_bridge.yaml")
    same = ("model_file", "program_file", "duty_source", "wait_for", "wait_for_nodes")
    plant = specs()["plant"].parameters
    assert {k: bridge.parameters[k] for k in same} == {k: plant[k] for k in same}
    assert bridge.parameters["link"] == "udp:rig:5005"
    assert bridge.parameters["road_source"] == "program"
    for pair in ("mode:=lockstep", "rate_factor:=2.0", "damper:=inove_guo"):
        with pytest.raises(InputError, match="beside hardware: a real rig has its own"):
            specs(*pairs, pair)


class _Recorded:
    """Stands for a class of launch or launch_ros: keeps how it was made."""

    def __init__(self, *args: Any, **kwargs: Any) -> None:
        self.args, self.kwargs = args, kwargs


def launch_module(monkeypatch: pytest.MonkeyPatch, given: dict[str, str]) -> types.ModuleType:
    """The launch file imported with stand-ins for launch, which answers with the given arguments."""

    class Configuration(_Recorded):
        def perform(self, _: object) -> str:
            return given[self.args[0]]

    parts = {
        "launch": ("LaunchDescription", "LaunchContext"),
        "launch.actions": ("DeclareLaunchArgument", "OpaqueFunction", "EmitEvent"),
        "launch.events": ("matches_action",),
        "launch.events.process": ("ProcessExited", "ShutdownProcess"),
        "launch.substitutions": (),
        "launch_ros": (),
        "launch_ros.actions": ("Node",),
        "launch_ros.utilities": (),
    }
    for name, classes in parts.items():
        module = types.ModuleType(name)
        for word in classes:
            setattr(module, word, type(word, (_Recorded,), {}))
        monkeypatch.setitem(sys.modules, name, module)
    sys.modules["launch.substitutions"].LaunchConfiguration = Configuration  # type: ignore[attr-defined]

    def joined(above: str | None, own: str) -> str:
        return own if not above or own.startswith("/") else f"{above}/{own}"

    sys.modules["launch_ros.utilities"].prefix_namespace = joined  # type: ignore[attr-defined]
    spec = importlib.util.spec_from_file_location("system_launch", LAUNCH)
    assert spec is not None
    assert spec.loader is not None
    made = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(made)
    monkeypatch.setattr(
        made, "get_package_share_directory", lambda _: str(ROOT / "src/er_bringup")
    )
    return made


def launched(
    monkeypatch: pytest.MonkeyPatch, pairs: tuple[str, ...], **above: object
) -> dict[str, Any]:
    """The launch file's nodes by label, with these arguments; above: what a parent has set."""
    module = launch_module(monkeypatch, parse(pairs))
    started = module.generate_launch_description().args[0][-1].kwargs["function"]
    context = types.SimpleNamespace(launch_configurations=above, argv=[])
    return {node.kwargs["exec_name"]: node for node in started(context)}


RIG = ("hardware:=udp:rig:5005", "calibration:=device_emulator")
RECORD = f"record:={ROOT / 'recording_to_come'}"
"""A recording in a place that nobody has."""
OTHER = {
    "namespace": ("namespace:=vehicle/suspension/fl",),
    "corners": (
        "corners:=4",
        "namespace:=car",
        RECORD,
        "composed:=true",
    ),
    "model": ("model:=inove_stand_in",),
    "damper": ("damper:=inove_bingham",),
    "effects_from": (f"effects_from:={LAUNCH}",),
    "program": ("program:=bumps",),
    "duration": ("duration:=7.5",),
    "seed": ("seed:=3",),
    "mode": ("mode:=sim_time",),
    "rate_factor": ("mode:=lockstep", "rate_factor:=0"),
    "hardware": RIG,
    "calibration": RIG,
    "key": (*RIG, "key:=none"),
    "remap": ("corners:=4", "remap:=sensors/acceleration=/chassis/{corner}/imu"),
    "road": (*RIG, "road:=program"),
    "controller": ("controller:=ftc",),
    "duty": ("duty:=program",),
    "observers": ("observers:=unified",),
    "gains": ("observers:=unified", "gains:=unified"),
    "fault_estimator": ("fault_estimator:=true",),
    "model_monitor": ("model_monitor:=true",),
    "priority": ("priority:=40",),
    "record": (RECORD,),
    "storage": (RECORD, "storage:=sqlite3"),
    "composed": ("composed:=true",),
    "plant_params": (f"plant_params:={CONFIG / 'nodes/plant.yaml'}",),
    "params_file": (f"params_file:={CONFIG / 'nodes/plant.yaml'}",),
    "use_sim_time": ("use_sim_time:=true",),
    "autostart": ("autostart:=false", RECORD),
    "respawn": ("respawn:=true",),
    "log_level": ("log_level:=debug", "composed:=true"),
}
"""For each argument a use of it that is not its default."""


@pytest.mark.parametrize(
    ("text", "rate"),
    [
        ("/**:\n  ros__parameters:\n    rate: 1000.0\n", 1000.0),
        ("/car/plant:\n  ros__parameters:\n    rate: 100\n", 100.0),
        ("/camera:\n  ros__parameters:\n    rate: 100.0\n", None),
        ("/**:\n  ros__parameters:\n    seed: 1\n", None),
    ],
)
def test_who_is_made_for_a_rate_is_told_that_of_the_plant(
    tmp_path: Path, text: str, rate: float | None
) -> None:
    own = tmp_path / "own.yaml"
    own.write_text(text)
    given = ("controller:=ftc", "fault_estimator:=true", "namespace:=car", f"plant_params:={own}")
    found = specs(*given)
    for name in ("ftc_controller", "fault_estimator"):
        assert found[name].parameters.get("rate") == rate


def test_a_file_that_cannot_be_the_plants_is_one_line(tmp_path: Path) -> None:
    own = tmp_path / "own.yaml"
    own.write_text("rate: 1000.0\n")
    with pytest.raises(InputError, match=r"then ros__parameters, found none"):
        specs("controller:=ftc", f"plant_params:={own}")


def test_every_argument_is_tried_in_launch() -> None:
    tried = {**OTHER}
    assert [a.name for a in ARGUMENTS if a.name not in tried] == []
    for name, pairs in tried.items():
        assert parse(pairs)[name] != complete({})[name]


@pytest.mark.parametrize("pairs", [(), ("controller:=none",), *OTHER.values()])
def test_launch_and_up_start_the_same_command_lines(
    monkeypatch: pytest.MonkeyPatch, pairs: tuple[str, ...]
) -> None:
    found = [
        [each["package"], each["executable"], *each["arguments"], *placed(each["namespace"])]
        for each in (node.kwargs for node in launched(monkeypatch, pairs).values())
    ]
    monkeypatch.setattr(up, "executable", lambda spec: f"{spec.package} {spec.executable}")
    config = ROOT / "src/er_bringup/config"
    upped = [up.argv(spec) for spec in nodes(parse(pairs), config)]
    assert found == [[*first.split(), *rest] for first, *rest in upped]


def placed(namespace: str) -> list[str]:
    """What launch adds for the namespace of a node."""
    return ["--ros-args", "-r", f"__ns:={namespace}"] if namespace != "/" else []


def test_what_a_parent_sets_for_all_nodes_is_as_good_as_an_argument(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    above = {
        "ros_namespace": "/car",
        "ros_remaps": [
            ("sensors/force", "/x/{corner}/force"),
            ("tf", "/tf"),
            ("pwm/command", "/no"),
        ],
        "global_params": ["file.yaml", ("use_sim_time", "True")],
    }
    own = ("corners:=a,b", "remap:=pwm/command=duty", RECORD, "namespace:=body")
    found = launched(monkeypatch, own, **above)
    assert found["a.plant"].kwargs["namespace"] == "/car/body/a"
    words = found["b.plant"].kwargs["arguments"]
    assert [w for w in words if w.startswith("sensors/force:")] == ["sensors/force:=/x/b/force"]
    assert [w for w in words if w.startswith("pwm/command:")] == ["pwm/command:=duty"]
    assert "mode:='sim_time'" in words
    recorded = found["recorder"].kwargs["arguments"]
    assert any("/x/a/force" in word for word in recorded)
    assert found["recorder"].kwargs["namespace"] == "/car/body"


def test_the_recorder_alone_is_not_started_again(monkeypatch: pytest.MonkeyPatch) -> None:
    found = launched(monkeypatch, ("respawn:=true", RECORD, "observers:=none"))
    again = {name: node.kwargs["respawn"] for name, node in found.items()}
    assert again == {"recorder": False, "skyhook_controller": True, "plant": True}
    assert not any(node.kwargs["respawn"] for node in launched(monkeypatch, ()).values())


def test_launch_declares_every_argument_with_its_default(monkeypatch: pytest.MonkeyPatch) -> None:
    module = launch_module(monkeypatch, complete({}))
    declared = [
        a
        for a in module.generate_launch_description().args[0]
        if type(a).__name__ == "DeclareLaunchArgument"
    ]
    assert {a.args[0]: a.kwargs["default_value"] for a in declared} == complete({})
    assert all(a.kwargs["description"] for a in declared)


def ends_with(found: dict[str, Any], label: str, status: int, *, shut: bool = False) -> list[str]:
    """Whom the launch file ends after a node has ended with this status; shut: while launch ends them all."""
    name = {id(node): label for label, node in found.items()}
    event = types.SimpleNamespace(returncode=status)
    events = found[label].kwargs["on_exit"](event, types.SimpleNamespace(is_shutdown=shut))
    matchers = [each.kwargs["event"].kwargs["process_matcher"] for each in events or ()]
    return [name[id(matcher.args[0])] for matcher in matchers]


@pytest.mark.parametrize(
    ("pairs", "source"),
    [((), "plant"), (RIG, "hardware_bridge"), (("composed:=true",), "composed")],
)
def test_only_the_good_end_of_what_measures_ends_the_launch(
    monkeypatch: pytest.MonkeyPatch, pairs: tuple[str, ...], source: str
) -> None:
    found = launched(monkeypatch, (*pairs, RECORD))
    others = sorted({*found} - {source, "recorder"})
    for each in others[:1]:
        assert [ends_with(found, each, status) for status in (1, 0)] == [[], []]
    assert ends_with(found, source, -9) == []
    assert ends_with(found, source, 0, shut=True) == []
    assert ends_with(found, source, 0) == (others[1:] or ["recorder"])
    for each in others[1:]:
        assert "recorder" not in ends_with(found, each, 0)[:-1]
    assert ends_with(found, "recorder", 0) == []


def test_a_node_that_is_started_again_does_not_end_the_launch(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    pairs = ("respawn:=true", "corners:=a,b", "observers:=none")
    found = launched(monkeypatch, pairs)
    for status in (2, -9):
        assert ends_with(found, "a.plant", status) == []
    assert ends_with(found, "a.skyhook_controller", 0) == []
    assert ends_with(found, "a.plant", 0) == ["a.plant"]  # not to be started again
    rest = ["a.skyhook_controller", "b.plant", "b.skyhook_controller"]
    assert ends_with(found, "b.plant", 0) == sorted(rest)
    found = launched(monkeypatch, ("corners:=a,b", "observers:=none"))
    assert ends_with(found, "b.plant", 2) == []
    assert ends_with(found, "a.plant", 0) == ["a.skyhook_controller", "b.skyhook_controller"]


def test_a_vehicle_without_a_plant_of_ours_goes_on_whoever_ends(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    found = launched(monkeypatch, ("hardware:=stack",))
    assert all(ends_with(found, each, 0) == [] for each in found)


def test_parameter_files_reach_every_node_by_its_name(tmp_path: Path) -> None:
    for corner in ("a", "b"):
        (tmp_path / f"{corner}.yaml").write_text(
            "/**/plant:\n  ros__parameters:\n    rate: 100.0\n"
            f"/car/{corner}/skyhook_controller:\n  ros__parameters:\n    u_max: 0.2\n"
        )
    base = ("corners:=a,b", "namespace:=car")
    given = f"params_file:={tmp_path}/{{corner}}.yaml"
    nodes(parse([*base, "controller:=none", given]), CONFIG)
    with pytest.raises(
        InputError, match=r"a\.yaml: /car/a/skyhook_controller: expected a node of"
    ):
        nodes(parse(["corners:=a,b", given]), CONFIG)
    found = nodes(parse([*base, given]), CONFIG)
    assert {spec.files[-1] for spec in found} == {str(tmp_path / f"{c}.yaml") for c in "ab"}
    with pytest.raises(InputError, match=r"arguments: .*car\.yaml: expected a file"):
        nodes(parse([*base, RECORD, given]), CONFIG)
    ftc = {
        s.executable: s
        for s in nodes(parse(["controller:=ftc", f"params_file:={_rate(tmp_path)}"]), CONFIG)
    }
    assert ftc["ftc_controller"].parameters["rate"] == 50.0


def _rate(folder: Path) -> Path:
    """A file for all nodes of a vehicle: a key of ours, and others' nodes."""
    file = folder / "vehicle.yaml"
    text = "/**:\n  ros__parameters:\n    rate: 50.0\n    wheel_base: 2.7\n/camera:\n  ros__parameters:\n    fps: 30\n"
    file.write_text(text)
    return file


@pytest.mark.parametrize(
    ("pairs", "words"),
    [
        (("use_sim_time:=true", "mode:=lockstep"), "use_sim_time: expected 'false' beside mode:=lockstep"),
        (("use_sim_time:=false", "mode:=sim_time"), "use_sim_time: expected 'true' beside mode:=sim_time"),
        (("use_sim_time:=yes",), "use_sim_time: expected one of nothing, false, true, found 'yes'"),
        (("log_level:=loud",), "log_level: expected one of debug, info"),
    ],
)  # fmt: skip
def test_usual_arguments_of_launch_files_are_checked(pairs: tuple[str, ...], words: str) -> None:
    with pytest.raises(InputError, match=words):
        parse(pairs)


def test_the_usual_arguments_reach_every_node() -> None:
    found = specs("autostart:=false", "log_level:=warn", RECORD).values()
    for words in (spec.arguments() for spec in found):
        assert words[words.index("--log-level") + 1] == "warn"
        assert "autostart:=false" in words
    assert not any("--log-level" in s.arguments() for s in specs().values())
    given = parse(["hardware:=stack", "use_sim_time:=true"])
    assert all(spec.parameters["use_sim_time"] for spec in nodes(given, CONFIG))


def test_a_car_has_four_corners_and_one_recorder(tmp_path: Path) -> None:
    given = parse(("corners:=4", "namespace:=car", "seed:=5", f"record:={tmp_path / 'b'}"))
    found = nodes(given, CONFIG)
    assert len(found) == 1 + 4 * 5
    recorder, *rest = found
    assert recorder.namespace == "car"
    plants = [spec for spec in rest if spec.executable == "plant"]
    assert [spec.namespace for spec in plants] == [f"car/{name}" for name in CAR]
    assert [spec.parameters["seed"] for spec in plants] == [5, 6, 7, 8]
    assert {spec.label for spec in found} >= {"recorder", "rear_left/plant"}
    awaited = plants[0].parameters["wait_for_nodes"]
    assert isinstance(awaited, list)
    assert awaited[0] == "/car/recorder"
    said = recorder.parameters["topics"]
    assert isinstance(said, list)
    assert {"front_right/force/unified", "rear_left/plant/status"} <= set(said)
    assert len(said) == len(set(said))


def test_a_stack_has_sensors_of_its_own_under_its_own_names() -> None:
    names = "remap:=sensors/acceleration=/chassis/{corner}/imu, pwm/command=/chassis/{corner}/duty"
    pairs = (
        "hardware:=stack",
        "corners:=4",
        "namespace:=car",
        names,
        RECORD,
    )
    recorder, *found = nodes(parse(pairs), CONFIG)
    assert {spec.executable for spec in found} == {
        "skyhook_controller", *(program.name for program in OBSERVERS.values())
    }  # fmt: skip
    words = found[-1].arguments()
    assert found[-1].full_name == "/car/rear_right/skyhook_controller"
    assert words[1:5] == [
        "-r", "sensors/acceleration:=/chassis/rear_right/imu",
        "-r", "pwm/command:=/chassis/rear_right/duty",
    ]  # fmt: skip
    assert found[-1].parameters["listeners"] == 1
    sources = recorder.parameters["sources"]
    assert isinstance(sources, list)
    assert "rear_right/sensors/road" not in sources
    assert "/chassis/rear_left/duty" in sources


def test_the_recorder_notes_the_names_of_topics_that_have_others() -> None:
    pairs = (
        "remap:=sensors/force=/{corner}/x, sensors/road=y, /diagnostics=/z",
        RECORD,
    )
    recorder, *_ = nodes(parse((*pairs, "namespace:=car", "corners:=a,b")), CONFIG)
    assert recorder.parameters["names"] == [
        "/car/a/sensors/force=/a/x", "/car/a/sensors/road=/car/a/y",
        "/car/b/sensors/force=/b/x", "/car/b/sensors/road=/car/b/y",
    ]  # fmt: skip
    alone = specs("remap:=sensors/force=/x", RECORD)["recorder"]
    assert alone.parameters["names"] == ["/sensors/force=/x"]
    assert "names" not in specs(RECORD)["recorder"].parameters


def test_a_new_name_within_a_corner_is_recorded_where_the_corner_says_it() -> None:
    pairs = (
        "remap:=sensors/force=x, /diagnostics=y, sensors/road=/z/{corner}",
        RECORD,
    )
    recorder, *_ = nodes(parse((*pairs, "namespace:=car", "corners:=a,b")), CONFIG)
    for names in (recorder.parameters["topics"], recorder.parameters["sources"]):
        assert isinstance(names, list)
        assert {"a/x", "b/x", "/z/a", "/z/b"} <= set(names)
        assert not {"x", "a/sensors/force", "y", "a/sensors/road"} & set(names)
    topics_of_all = recorder.parameters["topics"]
    assert isinstance(topics_of_all, list)
    assert {"a/y", "b/y"} <= set(topics_of_all)


def test_each_of_several_plants_has_a_simulated_time_of_its_own() -> None:
    def clocks(*pairs: str) -> dict[str, set[str]]:
        """Where the nodes of each namespace have the clock; the recorder has the system's."""
        found: dict[str, set[str]] = {}
        for spec in nodes(parse(("mode:=sim_time", *pairs)), CONFIG):
            for part in getattr(spec, "parts", (spec,)):
                found.setdefault(part.namespace, set()).add(part.remaps.get("/clock", ""))
        return found

    own = {"car/a": {"/car/a/clock"}, "car/b": {"/car/b/clock"}}
    assert clocks("corners:=a,b", "namespace:=car") == own
    assert clocks("corners:=a,b", "namespace:=car", "composed:=true") == own
    more = (RECORD, "remap:=sensors/force=x")
    assert clocks("corners:=a,b", "namespace:=car", *more) == own | {"car": {""}}
    assert clocks("corners:=a,b", "remap:=/clock=/t/{corner}") == {"a": {"/t/a"}, "b": {"/t/b"}}
    assert clocks("corners:=a,b", "remap:=/clock=t") == {"a": {"t"}, "b": {"t"}}
    assert clocks("corners:=a") == {"a": {""}}
    assert clocks("corners:=a,b", "hardware:=stack") == {"a": {""}, "b": {""}}
    assert clocks("corners:=a,b", "mode:=realtime") == {"a": {""}, "b": {""}}
    words = (
        r"remap: expected a clock of its own for each corner in mode sim_time .*, found '/t' for"
    )
    with pytest.raises(InputError, match=words):
        clocks("corners:=a,b", "remap:=/clock=/t")


@pytest.mark.parametrize(
    "pair",
    [
        "mode:=lockstep",
        "rate_factor:=2",
        "damper:=nonexistent",
        "program:=nonexistent",
        "duration:=2",
        "seed:=3",
        "calibration:=rig",
        "road:=program",
        "duty:=program",
        "effects_from:=own.py",
        "plant_params:=own.yaml",
    ],
)
def test_what_a_stack_has_itself_is_refused_beside_it(pair: str) -> None:
    with pytest.raises(InputError, match=f"{pair.partition(':=')[0]}: expected .* beside"):
        specs("hardware:=stack", pair)


def test_a_stack_may_have_simulated_time_and_no_end() -> None:
    pairs = ("hardware:=stack", "mode:=sim_time", "duration:=0", "rate_factor:=0.5")
    assert specs(*pairs)["skyhook_controller"].parameters["pace"] == 0.5
    assert "hardware_bridge" in specs(*RIG, "rate_factor:=1")


def test_a_topic_may_be_named_in_full() -> None:
    pairs = ("namespace:=car/left", "remap:=/car/left/sensors/force=/x, /diagnostics=/y")
    assert specs(*pairs)["plant"].remaps == {"sensors/force": "/x", "/diagnostics": "/y"}


def test_numbers_have_the_bounds_of_the_nodes() -> None:
    known = {spec.name: spec for spec in bounds_of(PlantParameters)}
    for argument in ARGUMENTS:
        if argument.kind is not str:
            spec = known[argument.name]
            assert (argument.kind, argument.low, argument.high) == (spec.kind, spec.low, spec.high)


def test_a_wire_for_each_corner() -> None:
    given = parse(("corners:=a,b", "hardware:=udp:x:1,udp:y:2", "calibration:=device_emulator"))
    found = [s for s in nodes(given, CONFIG) if s.executable == "hardware_bridge"]
    assert [spec.parameters["link"] for spec in found] == ["udp:x:1", "udp:y:2"]
    for pair, words in (
        ("key:=none,none,none", "key: expected 2 with commas between, in the order a, b"),
        ("hardware:=udp:x:1", "hardware: expected 2 with commas between, in the order a, b"),
        ("corners:=a,a", "corners: expected 4, or different names"),
        ("corners:=5", "corners: expected 4, or different names"),
    ):
        with pytest.raises(InputError, match=words):
            nodes(parse(("corners:=a,b", "calibration:=device_emulator", pair)), CONFIG)


def test_with_the_security_of_ros_each_process_has_its_nodes_enclave(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    pairs = ("namespace:=car/front_left", "controller:=none", "observers:=unified")

    def enclaves(*more: str) -> list[str]:
        words = [
            word for spec in nodes(parse((*pairs, *more)), CONFIG) for word in spec.arguments()
        ]
        return [words[i + 1] for i, word in enumerate(words) if word == "--enclave"]

    assert enclaves() == []
    monkeypatch.setattr(graph, "SECURED", True)
    assert enclaves() == ["/car/front_left/unified_observer", "/car/front_left/plant"]
    assert enclaves("composed:=true")[-1] == "/car/front_left/composed"
