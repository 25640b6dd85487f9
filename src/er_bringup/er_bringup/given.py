"""The arguments of the graph as they were given: complete, each checked, and checked against one another.

given = parse(["controller:=skyhook", "record:=run1"])
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from difflib import get_close_matches
from pathlib import Path

from er_common.topics import CLOCK, DIAGNOSTICS, SENSORS
from er_models.errors import InputError
from er_models.seed import OF_A_PLANT
from er_observers.programs import OBSERVERS
from er_plant_sim.hardware.link import HOST_WIRES, Address

from er_bringup.arguments import ARGUMENTS, NAME, NAMESPACE, Argument, is_name, is_namespace
from er_bringup.programs import ANSWERING

STACK = "stack"
"""Stands for hardware that is not ours: a vehicle stack publishes the sensors."""
CAR = ("front_left", "front_right", "rear_left", "rear_right")
"""The corners of a car."""
SAID = dict.fromkeys(program.says for program in ANSWERING if program.says)
TOPICS = tuple(topic.name for topic in (*SENSORS, *SAID, DIAGNOSTICS, CLOCK))
"""What can have another name."""
SIMULATED = ("mode", "rate_factor", "damper")
"""What only a simulated plant can be told."""
STACK_HAS = (
    "damper", "program", "seed", "effects_from", "calibration", "key", "road", "duty",
    "plant_params",
)  # fmt: skip
"""What nobody is told where the sensors are a vehicle stack's."""


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
    return _timed({key: _checked(a, given.get(key, a.default)) for key, a in known.items()})


def _timed(given: dict[str, str]) -> dict[str, str]:
    """With the mode that `use_sim_time` asks for, as other launch files call it."""
    asked, mode = given["use_sim_time"], given["mode"]
    if asked == "true" and mode == "realtime":
        return {**given, "mode": "sim_time"}
    if asked and asked != ("true" if mode == "sim_time" else "false"):
        expected = f"'{str(mode == 'sim_time').lower()}' beside mode:={mode}"
        raise InputError("arguments", "use_sim_time", expected, f"'{asked}'")
    return given


def _check_pace(given: Mapping[str, str]) -> None:
    """Refuse a speed that the mode does not have: a plant would, but everybody else has started then."""
    mode, factor = given["mode"], float(given["rate_factor"])
    if mode == "realtime" and factor != 1.0:
        raise InputError("arguments", "rate_factor", "1 in mode realtime", f"'{factor:g}'")
    if factor == 0.0 and mode != "lockstep":
        expected = "above 0 (0 only in mode lockstep)"
        raise InputError("arguments", "rate_factor", expected, "'0'")


def _checked(argument: Argument, value: str) -> str:
    if argument.choices and value not in argument.choices:
        raise InputError("arguments", argument.name, argument.expected, f"'{value}'")
    if argument.kind in (int, float):
        try:
            number = argument.kind(value)
        except ValueError:
            number = math.nan
        if not argument.low <= number <= argument.high:
            raise InputError("arguments", argument.name, argument.expected, f"'{value}'")
    if argument.name == "namespace" and not is_namespace(value):
        raise InputError("arguments", argument.name, NAMESPACE, f"'{value}'")
    if argument.name == "record" and value and Path(value).exists():
        expected = "a path that does not exist yet"
        raise InputError("arguments", argument.name, expected, f"'{value}', which does")
    return value


def corners(given: Mapping[str, str]) -> tuple[str, ...]:
    """Names of the corners; none where the graph has but one, without a name.

    Raises:
        InputError: A name that cannot be a namespace, or twice the same.
    """
    text = given["corners"].strip()
    names = CAR if text == "4" else tuple(name.strip() for name in text.split(",") if name.strip())
    expected = f"4, or different names of {NAME} with commas between"
    if len(set(names)) < len(names) or not all(map(is_name, names)):
        raise InputError("arguments", "corners", expected, f"'{text}'")
    return names


def of_corner(given: Mapping[str, str], names: Sequence[str], place: int) -> dict[str, str]:
    """The arguments of one corner: its namespace, its wire, its own draw of what is random, its own simulated time."""
    base, seed = given["namespace"].strip("/"), int(given["seed"])
    own = {"namespace": "/".join(part for part in (base, names[place]) if part)}
    if seed >= 0:
        if seed + len(names) - 1 > OF_A_PLANT:
            expected = (
                f"at most {OF_A_PLANT - len(names) + 1}, as each corner has a seed of its own"
            )
            raise InputError("arguments", "seed", expected, f"'{seed}'")
        own["seed"] = str(seed + place)
    for key in ("hardware", "calibration", "key"):
        if given[key] == STACK:
            continue
        texts = [text.strip() for text in given[key].split(",")]
        shared = len(texts) == 1 and (key != "hardware" or not texts[0])
        if not shared and len(texts) != len(names):
            expected = f"{len(names)} with commas between, in the order {', '.join(names)}"
            raise InputError("arguments", key, expected, f"{len(texts)}")
        own[key] = texts[0] if shared else texts[place]
    # one recorder for all, in the namespace above
    found, clock = {**given, **own}, CLOCK.name
    if len(names) > 1 and _drives_clock(given) and clock not in remaps(found):
        found["remap"] = f"{given['remap']},{clock}=/{own['namespace']}{clock}"
    return found


def _drives_clock(given: Mapping[str, str]) -> bool:
    """Whether a plant of ours publishes simulated time; that of a vehicle stack is one for all corners."""
    return given["mode"] == "sim_time" and not given["hardware"]


def check_clocks(each: Sequence[Mapping[str, str]]) -> None:
    """Check that no two plants publish their simulated times on one topic: everybody's would jump between them.

    Raises:
        InputError: A new name of the clock that is the same for several corners.
    """
    clock = CLOCK.name
    found = [remaps(one).get(clock, "") for one in each if _drives_clock(one)]
    for name in found:
        if name.startswith("/") and found.count(name) > 1:
            expected = f"a clock of its own for each corner in mode sim_time ({clock}=/{{corner}}{clock} for instance)"
            raise InputError("arguments", "remap", expected, f"'{name}' for all")


def observers(given: Mapping[str, str]) -> tuple[str, ...]:
    """Names of the observers.

    Raises:
        InputError: One that is not known, or twice the same; gains beside several.
    """
    each = (name.strip() for name in given["observers"].split(","))
    names = tuple(name for name in each if name not in ("", "none"))
    expected = f"none, or some of {', '.join(OBSERVERS)}, with commas between"
    for name in names:
        if name not in OBSERVERS:
            raise InputError("arguments", "observers", expected, f"'{name}'")
        if names.count(name) > 1:
            raise InputError("arguments", "observers", expected, f"'{name}' twice")
    if given["gains"] and len(names) > 1:
        expected = "one observer beside it (observers:=NAME), as gains belong to one"
        raise InputError("arguments", "gains", expected, given["observers"])
    return names


def check_source(given: Mapping[str, str]) -> None:
    """Check what is given beside hardware, of one corner.

    Raises:
        InputError: A wire that there cannot be, no calibration, or something that only a simulated plant can do.
    """
    if given["hardware"] == STACK:
        # the pace of a simulated vehicle is told, for the silence of its sensors
        keys = STACK_HAS if given["mode"] == "sim_time" else ("rate_factor", *STACK_HAS)
        _nothing_else(given, keys, "hardware:=stack: a vehicle has its own")
        if given["mode"] == "lockstep":
            expected = "'realtime' or 'sim_time' beside hardware:=stack, which waits for nobody"
            raise InputError("arguments", "mode", expected, "'lockstep'")
        if float(given["duration"]) > 0.0:
            expected = "0 or -1 beside hardware:=stack, which ends with Ctrl-C"
            raise InputError("arguments", "duration", expected, f"'{given['duration']}'")
    elif given["hardware"]:
        Address(given["hardware"], HOST_WIRES, "arguments: hardware")
        _nothing_else(given, SIMULATED, "hardware: a real rig has its own")
        if not given["calibration"]:
            expected = "the calibration of the rig beside hardware"
            raise InputError("arguments", "calibration", expected, "nothing")
    else:
        _check_pace(given)


def _nothing_else(given: Mapping[str, str], keys: Sequence[str], why: str) -> None:
    """Refuse arguments that would do nothing."""
    for argument in ARGUMENTS:
        value, kind = given[argument.name], argument.kind
        if argument.name in keys and kind(value) != kind(argument.default):
            expected = f"'{argument.default}' beside {why}"
            raise InputError("arguments", argument.name, expected, f"'{value}'")


def renamed(given: Mapping[str, str]) -> list[str]:
    """Full names of topics that have others, USUAL=OTHER, as a recorder notes them; raises as `remaps` does."""
    base = f"/{given['namespace'].strip('/')}".rstrip("/")
    found = remaps(given).items()
    return [
        f"{base}/{old}={new if new.startswith('/') else f'{base}/{new}'}"
        for old, new in found
        if not old.startswith("/")
    ]


def remaps(given: Mapping[str, str]) -> dict[str, str]:
    """New names of topics by their old ones, which are without the namespace.

    Raises:
        InputError: No pair, a topic that there is not or that is there twice, a name that ROS does not take.
    """
    namespace = given["namespace"].strip("/")
    corner, within = namespace.rpartition("/")[2], f"/{namespace}/" if namespace else "/"
    found: dict[str, str] = {}
    for pair in (pair.strip() for pair in given["remap"].split(",")):
        if not pair:
            continue
        old, separator, new = (part.strip() for part in pair.partition("="))
        if not (separator and old and new):
            raise InputError("arguments", "remap", "OLD=NEW with commas between", f"'{pair}'")
        old = old if old in TOPICS else old.removeprefix(within)
        new = new.replace("{corner}", corner)
        if old not in TOPICS:
            near = get_close_matches(old, TOPICS, n=1)
            hint = f"did you mean {near[0]}?" if near else f"known: {', '.join(TOPICS)}"
            raise InputError("arguments", "remap", f"a topic of the graph ({hint})", f"'{old}'")
        if not is_namespace(new) or new.endswith("/"):
            raise InputError("arguments", "remap", f"a topic, {NAMESPACE}", f"'{new}' for {old}")
        if old in found or new in found.values():
            raise InputError("arguments", "remap", "each topic once", f"'{pair}'")
        found[old] = new
    for old, new in found.items():
        other = new if new in TOPICS else new.removeprefix(within)
        if other != old and other in TOPICS and other not in found:
            expected = "a name that no other topic of the graph has"
            raise InputError("arguments", "remap", expected, f"'{new}' for {old}")
    return found
