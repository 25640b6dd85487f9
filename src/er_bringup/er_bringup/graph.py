"""The graph as data: its nodes and their parameters. Launch file and `up` are made from it.

for node in nodes(parse(["controller:=skyhook", "record:=run1"]), config):
    node.arguments()        # what follows the executable on its command line, but for the namespace
"""

from __future__ import annotations

import os
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field, replace
from pathlib import Path

from er_common.program import OBSERVER, Program
from er_common.topics import (
    ACCELERATION,
    DEFLECTION,
    DIAGNOSTICS,
    PWM_APPLIED,
    PWM_COMMAND,
    SENSORS,
    Topic,
)
from er_ftc_controller.programs import FTC
from er_model_lab.programs import RECORDER
from er_models.errors import InputError
from er_observers.programs import OBSERVERS
from er_plant_sim.hardware.key_file import NONE as NO_KEY
from er_plant_sim.programs import BRIDGE, PLANT
from er_ros_common.arguments import Value, ros_arguments
from er_ros_common.parameter_files import check_names, given_in

from er_bringup.given import (
    STACK,
    check_clocks,
    check_source,
    corners,
    observers,
    of_corner,
    remaps,
    renamed,
)
from er_bringup.programs import ASKED, COMPOSED, CONTROLLERS, EVERY, SOURCES

STACK_PUBLISHES = (ACCELERATION, DEFLECTION, PWM_APPLIED)
"""What a vehicle stack says of a corner; it knows neither its damper's force nor the road."""
SECURED = os.environ.get("ROS_SECURITY_ENABLE") == "true"
"""Whether ROS wants an enclave for each process: that of its node in the policy of `integration/ros_sros2.py`."""


@dataclass(frozen=True)
class NodeSpec:
    """One process of the graph."""

    package: str
    executable: str
    namespace: str
    files: tuple[str, ...] = ()
    parameters: Mapping[str, Value] = field(default_factory=dict)
    corner: str = ""
    remaps: Mapping[str, str] = field(default_factory=dict)
    log_level: str = ""

    @property
    def label(self) -> str:
        """What its lines are marked with."""
        return f"{self.corner}/{self.executable}" if self.corner else self.executable

    @property
    def full_name(self) -> str:
        """Name of the node in the graph."""
        return f"/{self.namespace.strip('/')}/{self.executable}".replace("//", "/")

    def arguments(self) -> list[str]:
        """What follows the executable on its command line, but for its place."""
        return ros_arguments(
            parameters=self.parameters,
            files=self.files,
            remaps=self.remaps,
            log_level=self.log_level,
            enclave=self.full_name if SECURED else "",
        )

    def place(self) -> list[str]:
        """What puts it into its namespace, behind its arguments; a launch file's `Node` says the same."""
        return ros_arguments(namespace=self.namespace)


@dataclass(frozen=True)
class ComposedSpec(NodeSpec):
    """One process that holds several nodes."""

    parts: tuple[NodeSpec, ...] = ()

    def arguments(self) -> list[str]:
        """The command lines of its nodes, one after the other; what follows is for all of them."""
        each = [[f"{p.package}/{p.executable}", *p.arguments(), "--"] for p in self.parts]
        return [*(word for words in each for word in words), *super().arguments()]


def nodes(given: Mapping[str, str], config: Path) -> tuple[NodeSpec, ...]:
    """The processes of complete arguments, listeners first; config: folder of models, programs, gains.

    Raises:
        InputError: A file does not exist, or arguments do not go together.
    """
    found = _processes(given, config)
    named = [spec.full_name for spec in every_node(found)]
    known = [program.name for program in EVERY]
    for file in {file: None for spec in every_node(found) for file in spec.files}:
        check_names(file, named, known)
    return found


def _processes(given: Mapping[str, str], config: Path) -> tuple[NodeSpec, ...]:
    names = corners(given)
    if not names:
        recorder = (_recorder(given, _answering(given), config),) if given["record"] else ()
        return (*recorder, *_corner(given, config))
    each = [of_corner(given, names, i) for i in range(len(names))]
    check_clocks(each)
    recorder = (_recorder_of_all(given, names, each, config),) if given["record"] else ()
    parts = zip(names, (_corner(one, config) for one in each), strict=True)
    return (*recorder, *(replace(spec, corner=name) for name, specs in parts for spec in specs))


def _corner(given: Mapping[str, str], config: Path) -> tuple[NodeSpec, ...]:
    """The processes of one corner but the recorder, listeners first; a stack has sensors of its own."""
    check_source(given)
    recorded = [RECORDER] if given["record"] else []
    rest = (
        *(_answer(given, config, program) for program in _answering(given)),
        *(_source(given, config, [*recorded, *_answering(given)]) for _ in _sources(given)),
    )
    if given["composed"] == "true":
        whole = ComposedSpec(
            COMPOSED.package, COMPOSED.name, given["namespace"], parts=rest,
            log_level=_log_level(given),
        )  # fmt: skip
        return (whole,)
    return rest


def every_node(specs: Sequence[NodeSpec]) -> list[NodeSpec]:
    """The nodes of these processes."""
    return [
        part
        for spec in specs
        for part in (spec.parts if isinstance(spec, ComposedSpec) else (spec,))
    ]


def _answering(given: Mapping[str, str]) -> list[Program]:
    """Everybody who answers samples."""
    asked = [program for program in ASKED if given[program.name] == "true"]
    control = [] if given["controller"] == "none" else [CONTROLLERS[given["controller"]]]
    return [*(OBSERVERS[name] for name in observers(given)), *asked, *control]


def ends_all(spec: NodeSpec) -> bool:
    """Whether the graph is over when this process ends: it holds what measures."""
    return spec.executable in (program.name for program in (*SOURCES, COMPOSED))


def find(name: str, config: Path, *places: str) -> str:
    """Absolute path of a file given by path, or by name below the configuration.

    Raises:
        InputError: There is no such file.
    """
    tried = [Path(name), *(config / p / name for p in ("", *places))]
    tried += [config / p / f"{name}.yaml" for p in places]
    for path in tried:
        if path.is_file():
            return str(path.absolute())
    known = sorted(p.stem for place in places for p in (config / place).glob("*.yaml"))
    expected = f"a file, or one of {', '.join(known)}" if known else "a file"
    raise InputError("arguments", name, expected, "no such file")


def _source(given: Mapping[str, str], config: Path, listeners: Sequence[Program]) -> NodeSpec:
    """What measures: the plant, or the bridge to a real rig."""
    parameters: dict[str, Value] = {
        "model_file": find(given["model"], config, "vehicles"),
        "program_file": find(given["program"], config, "experiments"),
        "duration": float(given["duration"]),
        "seed": int(given["seed"]),
        "duty_source": "topic" if _commanded(given) else "program",
        "wait_for": [sum(topic in each.listens for each in listeners) for topic in SENSORS],
    }
    if listeners:
        # with several corners the recorder is in the namespace above them
        above = f"/{given['namespace'].strip('/')}".rpartition("/")[0] if given["corners"] else ""
        names = {RECORDER: f"{above}/{RECORDER.name}"} if given["corners"] else {}
        parameters["wait_for_nodes"] = [names.get(each, each.name) for each in listeners]
        if RECORDER in listeners and given["mode"] == "lockstep":
            parameters["recorder"] = names.get(RECORDER, RECORDER.name)
            parameters["recorded"] = _names((*SENSORS, *_said(listeners)))
    if given["effects_from"]:
        own = given["effects_from"].split(",")
        parameters["effects_from"] = tuple(find(file.strip(), config) for file in own)
    program, more = (BRIDGE, _bridge) if given["hardware"] else (PLANT, _plant)
    return _spec(program, given, _files(program, given, config), parameters | more(given, config))


def _files(program: Program, given: Mapping[str, str], config: Path) -> tuple[str, ...]:
    """Parameter files of a node; the last one wins."""
    own = config / "nodes" / f"{program.name}.yaml"
    corner = given["namespace"].rstrip("/").rpartition("/")[2]
    texts = [given["plant_params"]] if program in SOURCES else []
    texts += given["params_file"].replace("{corner}", corner).split(",")
    more = [find(text.strip(), config) for text in texts if text.strip()]
    return (*([str(own.absolute())] if program is not RECORDER else []), *more)


def _rate(given: Mapping[str, str], config: Path) -> dict[str, Value]:
    """The rate of the samples for who is made for one, where parameter files of what measures say it."""
    for program in _sources(given):
        spec = _spec(program, given, _files(program, given, config), {})
        rate = given_in(spec.files, spec.full_name, "rate")
        if isinstance(rate, int | float):
            return {"rate": float(rate)}
    return {}


def _sources(given: Mapping[str, str]) -> list[Program]:
    """What measures, where it is not a vehicle stack."""
    if given["hardware"] == STACK:
        return []
    return [BRIDGE] if given["hardware"] else [PLANT]


def _measured(given: Mapping[str, str]) -> list[str]:
    """Topics of what measures."""
    return _names(SENSORS if given["hardware"] != STACK else STACK_PUBLISHES)


def _said(answering: Sequence[Program]) -> list[Topic]:
    """What is said to the samples."""
    return [topic for program in answering for topic in program.said]


def _names(each: Sequence[Topic]) -> list[str]:
    return [topic.name for topic in each]


def _plant(given: Mapping[str, str], config: Path) -> dict[str, Value]:
    """What only the plant is told."""
    parameters: dict[str, Value] = {
        "mode": given["mode"],
        "rate_factor": float(given["rate_factor"]),
    }
    if given["damper"]:
        from er_plant_sim.build import car  # a kernel, which no other argument needs

        parameters["damper_file"] = find(given["damper"], config, "dampers")
        own = [find(file.strip(), config) for file in given["effects_from"].split(",") if file]
        car(find(given["model"], config, "vehicles"), str(parameters["damper_file"]), own)
    return parameters


def _bridge(given: Mapping[str, str], config: Path) -> dict[str, Value]:
    """What only the bridge is told."""
    return {
        "link": given["hardware"],
        "calibration_file": find(given["calibration"], config, "hardware"),
        "key_file": given["key"] if given["key"] in ("", NO_KEY) else find(given["key"], config),
        "road_source": given["road"],
    }


def _answer(given: Mapping[str, str], config: Path, program: Program) -> NodeSpec:
    """A node that answers samples."""
    # a stack that listens is not counted: it may come later
    obeyed = _commanded(given) and given["hardware"] != STACK and program.says is PWM_COMMAND
    users = sum(program.says in each.uses for each in _answering(given))
    parameters: dict[str, Value] = {"listeners": bool(given["record"]) + obeyed + users}
    if program.model:
        parameters["model_file"] = find(given["model"], config, "vehicles")
    if program.gains:
        name = given["gains"] if program.kind == OBSERVER else ""
        parameters["gains_file"] = find(name or program.gains, config, "gains")
    if program.rate:
        parameters |= _rate(given, config)
    if program is FTC and given["mode"] == "lockstep":
        parameters["timeout"] = 1.0  # silence is measured by a clock that has no part in it
    return _spec(program, given, _files(program, given, config), parameters | _time(given))


def _recorder(given: Mapping[str, str], answering: Sequence[Program], config: Path) -> NodeSpec:
    parameters: dict[str, Value] = {
        "out": str(Path(given["record"]).absolute()),
        "storage": given["storage"],
        "sources": [*_measured(given), *_names(_said(answering))],
    } | _noted([given])
    return _spec(RECORDER, given, _files(RECORDER, given, config), parameters)


def _recorder_of_all(
    given: Mapping[str, str],
    names: Sequence[str],
    each: Sequence[Mapping[str, str]],
    config: Path,
) -> NodeSpec:
    """One recorder for all corners."""
    answering = _answering(each[0])
    said = [*_measured(given), *_names(_said(answering))]
    nodes = [program.name for program in (*answering, *_sources(given))]
    own = [f"{node}/{end}" for node in nodes for end in ("status", "gain_info")]
    own_names = {name: remaps(one) for name, one in zip(names, each, strict=True)}

    def full(name: str, topic: str) -> str:
        new = own_names[name].get(topic, topic)  # as its corner resolves it
        return new if new.startswith("/") else f"{name}/{new}"

    parameters: dict[str, Value] = {
        "out": str(Path(given["record"]).absolute()),
        "storage": given["storage"],
        "topics": [
            *(full(name, topic) for name in names for topic in (*said, *own)),
            *dict.fromkeys(full(name, DIAGNOSTICS.name) for name in names),
        ],
        "sources": [full(name, topic) for name in names for topic in said],
    } | _noted(each)
    files = _files(RECORDER, given, config)
    return replace(_spec(RECORDER, given, files, parameters), remaps={})


def _noted(each: Sequence[Mapping[str, str]]) -> dict[str, Value]:
    """What the recorder is told of the topics of these corners that have other names."""
    names = [name for one in each for name in renamed(one)]
    return {"names": names} if names else {}


def _commanded(given: Mapping[str, str]) -> bool:
    """Whether the duty of the plant comes from the controller."""
    return given["duty"] == "command" and given["controller"] != "none"


def _spec(
    program: Program,
    given: Mapping[str, str],
    files: tuple[str, ...],
    parameters: Mapping[str, Value],
) -> NodeSpec:
    priority = int(given["priority"])
    if priority and program is not RECORDER:
        parameters = {**parameters, "priority": priority}
    if given["autostart"] == "false":
        parameters = {**parameters, "autostart": False}
    place = (program.package, program.name, given["namespace"])
    names, level = remaps(given), _log_level(given)
    return NodeSpec(*place, files, parameters, remaps=names, log_level=level)


def _log_level(given: Mapping[str, str]) -> str:
    """The level where it is not that of ROS."""
    return "" if given["log_level"] == "info" else given["log_level"]


def _time(given: Mapping[str, str]) -> dict[str, Value]:
    """Simulated time has its own pace: the age of a sample on the system clock means nothing."""
    if given["mode"] == "realtime":
        return {}
    if given["mode"] == "lockstep":
        return {"max_age": 0.0}
    # faster than real time a hold-up of the machine is no longer a silence than it is in real time
    pace = min(float(given["rate_factor"]), 1.0)
    return {"use_sim_time": True, "max_age": 0.0, "pace": pace}
