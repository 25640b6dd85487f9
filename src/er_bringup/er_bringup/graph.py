"""The graph as data: its nodes and their parameters. Launch file and `up` are made from it.

given = parse(["controller:=skyhook", "record:=/tmp/run1"])
for node in nodes(given, config):
    node.arguments()        # what follows the executable on its command line
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from difflib import get_close_matches
from pathlib import Path

from er_models.errors import InputError
from er_ros_common.arguments import Value, ros_arguments

from er_bringup.arguments import ARGUMENTS, Argument

PLANT, RECORDER = "plant", "recorder"
CONTROLLERS = {"skyhook": ("er_ftc_controller", "skyhook_controller")}
OBSERVERS = {"nlpv_polytopic": ("er_observers", "nlpv_polytopic_observer")}
PUBLISHED = ("acceleration", "deflection", "force", "road", "applied")
"""What the plant publishes, in the order of its parameter `wait_for`."""
LISTENS = {
    "skyhook_controller": ("acceleration", "deflection"),
    "nlpv_polytopic_observer": ("acceleration", "applied"),
    RECORDER: PUBLISHED,
}
"""What each executable subscribes to of that."""


@dataclass(frozen=True)
class NodeSpec:
    """One process of the graph."""

    package: str
    executable: str
    namespace: str
    files: tuple[str, ...] = ()
    parameters: Mapping[str, Value] = field(default_factory=dict)

    def arguments(self) -> list[str]:
        """What follows the executable on its command line."""
        return ros_arguments(
            parameters=self.parameters, files=self.files, namespace=self.namespace
        )


def parse(pairs: Sequence[str]) -> dict[str, str]:
    """Arguments of the form KEY:=VALUE over the defaults.

    Raises:
        InputError: A pair of another form, an unknown key, a value that is not allowed.
    """
    given: dict[str, str] = {}
    for pair in pairs:
        key, separator, value = pair.partition(":=")
        if not separator:
            raise InputError("arguments", pair, "KEY:=VALUE", "no :=")
        given[key] = value
    return complete(given)


def complete(given: Mapping[str, str]) -> dict[str, str]:
    """Checked arguments with the defaults of those not given; raises as `parse` does."""
    known = {argument.name: argument for argument in ARGUMENTS}
    for key in given:
        if key not in known:
            near = get_close_matches(key, known, n=1)
            hint = f"did you mean {near[0]}?" if near else f"known: {', '.join(known)}"
            raise InputError("arguments", key, f"a known key ({hint})", "an unknown key")
    return {key: _checked(a, given.get(key, a.default)) for key, a in known.items()}


def _checked(argument: Argument, value: str) -> str:
    if argument.choices and value not in argument.choices:
        raise InputError("arguments", argument.name, argument.expected, f"'{value}'")
    if argument.kind in (int, float):
        try:
            argument.kind(value)
        except ValueError:
            raise InputError("arguments", argument.name, argument.expected, f"'{value}'") from None
    return value


def nodes(given: Mapping[str, str], config: Path) -> tuple[NodeSpec, ...]:
    """The nodes of complete arguments, listeners first; config: folder of models, programs, gains.

    Raises:
        InputError: A file does not exist, or an observer is not known.
    """
    listeners = (*_recorder(given), *_observers(given, config), *_controller(given, config))
    return (*listeners, _plant(given, config, listeners))


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


def _plant(given: Mapping[str, str], config: Path, listeners: Sequence[NodeSpec]) -> NodeSpec:
    commanded = given["duty"] == "command" and given["controller"] != "none"
    parameters: dict[str, Value] = {
        "model_file": find(given["model"], config, "vehicles"),
        "program_file": find(given["program"], config, "experiments"),
        "duration": float(given["duration"]),
        "seed": int(given["seed"]),
        "mode": given["mode"],
        "rate_factor": float(given["rate_factor"]),
        "duty_source": "topic" if commanded else "program",
    }
    if given["damper"]:
        parameters["damper_file"] = find(given["damper"], config, "dampers")
    listened = [LISTENS[node.executable] for node in listeners]
    counts = [sum(topic in each for each in listened) for topic in PUBLISHED]
    files = [_own(PLANT, config)]
    if given["plant_params"]:
        files.append(find(given["plant_params"], config))
    return NodeSpec(
        "er_plant_sim", PLANT, given["namespace"], tuple(files), parameters | {"wait_for": counts}
    )


def _controller(given: Mapping[str, str], config: Path) -> list[NodeSpec]:
    if given["controller"] == "none":
        return []
    package, executable = CONTROLLERS[given["controller"]]
    files = (_own(executable, config),)
    return [NodeSpec(package, executable, given["namespace"], files, _time(given))]


def _observers(given: Mapping[str, str], config: Path) -> list[NodeSpec]:
    names = [name for name in given["observers"].split(",") if name not in ("", "none")]
    found = []
    for name in names:
        if name not in OBSERVERS:
            expected = f"none, or some of {', '.join(OBSERVERS)}, with commas between"
            raise InputError("arguments", "observers", expected, f"'{name}'")
        package, executable = OBSERVERS[name]
        parameters: dict[str, Value] = {
            "model_file": find(given["model"], config, "vehicles"),
            "gains_file": find(given["gains"] or name, config, "gains"),
        }
        files = (_own(executable, config),)
        found.append(
            NodeSpec(package, executable, given["namespace"], files, parameters | _time(given))
        )
    return found


def _recorder(given: Mapping[str, str]) -> list[NodeSpec]:
    if not given["record"]:
        return []
    parameters: dict[str, Value] = {
        "out": str(Path(given["record"]).absolute()),
        "storage": given["storage"],
    }
    return [NodeSpec("er_model_lab", RECORDER, given["namespace"], (), parameters)]


def _own(executable: str, config: Path) -> str:
    """Parameter file that belongs to an executable."""
    return str((config / "nodes" / f"{executable}.yaml").absolute())


def _time(given: Mapping[str, str]) -> dict[str, Value]:
    """Simulated time has its own pace: the age of a sample on the system clock means nothing."""
    if given["mode"] == "realtime":
        return {}
    simulated: dict[str, Value] = {"use_sim_time": True} if given["mode"] == "sim_time" else {}
    return simulated | {"max_age": 0.0}
