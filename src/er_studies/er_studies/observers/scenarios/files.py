"""Scenario files.

schema: er_scenario 1
title: ISO road with noise, Skyhook
source: "thesis 5.3.2"
program:                       # as a program file without its schema; seed is that of the first road
  duration: 15.0
  seed: 1
  road: {kind: iso8608, peak_velocity: 0.15}
  duty: {kind: constant, level: 0.0}
skyhook: {low: 0.0, high: 0.3} # optional: the duty comes from (3.81) instead
seeds: 20
start: thesis                  # thesis, equal, drawn or own
sensors: {noise: 0.025, bias: 0.0, delay: 0.0, duty_step: 0.0}
plant: {model: ../vehicles/inove_stand_in.yaml, spread: 0.1, effects: {coulomb_friction: {F_c: 1.0}}}
windows:
  - {begin: 0.0, end: 15.0, table: "5.3", published: {unified: 0.0142}}
variants:                      # optional: one scenario each, named FILE/VARIANT, with a plant of its own
  friction: {effects: {coulomb_friction: {F_c: 1.0}}}
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from er_models.catalogue import CATALOGUE
from er_models.errors import InputError, UnknownName
from er_models.program import SCHEMA as PROGRAM_SCHEMA
from er_models.program import Program, parse_program
from er_models.spec import REQUIRED, Number, Setting, Text, settings
from er_models.yaml_file import read_yaml
from er_observers.programs import OBSERVERS

from er_studies.observers.scenarios.scenario import Plant, Scenario, Sensors, Skyhook, Window

SCHEMA = "er_scenario 1"
_DUTY = "duty, 0 to 1"
_TABLE: tuple[Setting, ...] = (
    Text("schema", REQUIRED, f"'{SCHEMA}'", (SCHEMA,)),
    Text("title", REQUIRED, "what is driven"),
    Text("source", "", "where the scenario comes from"),
    Number("seeds", "1", 1.0, 1.0, 1000.0, "number of roads"),
    Text("start", "equal", "initial error", ("thesis", "equal", "drawn", "own")),
)
_SECTIONS = ("program", "skyhook", "sensors", "plant", "windows", "variants")
_SKYHOOK: tuple[Setting, ...] = (
    Number("low", "duty", 0.0, 0.0, 1.0, _DUTY),
    Number("high", "duty", REQUIRED, 0.0, 1.0, _DUTY),
)
_SENSORS: tuple[Setting, ...] = (
    Number("noise", "m/s2", 0.025, 0.0, 100.0, "standard deviation"),
    Number("bias", "m/s2", 0.0, -100.0, 100.0, "offset, of opposite sign on the two"),
    Number("delay", "s", 0.0, 0.0, 0.5, "delay of both accelerometers"),
    Number("duty_step", "duty", 0.0, 0.0, 1.0, "step of the applied duty"),
)
_PLANT: tuple[Setting, ...] = (
    Text("model", "", "vehicle model file"),
    Number("spread", "1", 0.0, 0.0, 0.9, "relative error of every parameter"),
)
_WINDOW: tuple[Setting, ...] = (
    Number("begin", "s", REQUIRED, 0.0, 1e6, "begin"),
    Number("end", "s", REQUIRED, 0.0, 1e6, "end"),
    Text("table", "", "name in the thesis"),
)


def load_scenarios(folder: str | Path) -> tuple[Scenario, ...]:
    """Every scenario of a folder, by name; `InputError` when it holds none or one is wrong."""
    files = sorted(Path(folder).glob("*.yaml"))
    if not files:
        raise InputError(folder, "", "a folder with scenario files (*.yaml)", "none")
    return tuple(s for file in files for s in load_scenario(file))


def choose_scenarios(found: Sequence[Scenario], names: Sequence[str]) -> tuple[Scenario, ...]:
    """Those of these names, or of files of these names; all where none is given."""
    known = tuple(dict.fromkeys(n for s in found for n in (s.name.split("/")[0], s.name)))
    for name in names:
        if name not in known:
            raise UnknownName("scenario", name, known)
    return tuple(s for s in found if not names or {s.name, s.name.split("/")[0]} & set(names))


def load_scenario(path: str | Path) -> tuple[Scenario, ...]:
    """The scenario of a file, or its variants.

    Raises `InputError` naming file, key, expected and found.
    """
    path = Path(path)
    document = read_yaml(path, "a scenario file")
    if not isinstance(document, Mapping):
        raise InputError(path, "", "a mapping of names to values", type(document).__name__)
    top = settings(_TABLE, document, path, also=_SECTIONS)
    program = _program(document.get("program"), path)
    skyhook = document.get("skyhook")
    scenario = Scenario(
        name=path.stem,
        title=top["title"],
        program=program,
        windows=_windows(document.get("windows"), program, path),
        seeds=int(top["seeds"]),
        start=top["start"],
        skyhook=None if skyhook is None else Skyhook(**_section(_SKYHOOK, skyhook, path, "skyhook")),
        plant=_plant(document.get("plant", {}), path, "plant"),
        sensors=_sensors(document.get("sensors", {}), path),
    )  # fmt: skip
    if scenario.skyhook is not None and scenario.sensors.duty_step > 0.0:
        expected = "no step with skyhook, whose duties are two"
        raise InputError(path, "sensors.duty_step", expected, scenario.sensors.duty_step)
    return _variants(scenario, document.get("variants"), path)


def _section(
    table: tuple[Setting, ...], found: object, path: Path, key: str, also: tuple[str, ...] = ()
) -> dict[str, Any]:
    """One checked section."""
    if not isinstance(found, Mapping):
        raise InputError(path, key, "a mapping of names to values", type(found).__name__)
    return settings(table, found, path, key, also)


def _program(found: object, path: Path) -> Program:
    """The drive."""
    if not isinstance(found, Mapping):
        raise InputError(path, "program", "road, duty and duration", type(found).__name__)
    program = parse_program({"schema": PROGRAM_SCHEMA, **found}, path)
    if program.duration <= 0.0:
        raise InputError(path, "program.duration", "more than 0 s", program.duration)
    return program


def _windows(found: object, program: Program, path: Path) -> tuple[Window, ...]:
    """When errors count."""
    if not isinstance(found, list) or not found:
        raise InputError(path, "windows", "a list of begin and end", repr(found))
    windows = []
    for i, one in enumerate(found):
        key = f"windows[{i}]"
        read = _section(_WINDOW, one, path, key, also=("published",))
        if not read["begin"] < read["end"] <= program.duration:
            expected = f"begin < end <= duration ({program.duration:g} s)"
            raise InputError(path, key, expected, f"{read['begin']:g} to {read['end']:g} s")
        table = tuple(Number(o, "1", 0.0, 1e-6, 1.0, "published NRMSE") for o in OBSERVERS)
        given = one.get("published", {})
        published = _section(table, given, path, f"{key}.published")
        kept = {name: float(published[name]) for name in OBSERVERS if name in given}
        windows.append(Window(read["begin"], read["end"], read["table"], kept))
    return tuple(windows)


def _sensors(found: object, path: Path) -> Sensors:
    """What is wrong with the sensors."""
    return Sensors(**_section(_SENSORS, found, path, "sensors"))


def _plant(found: object, path: Path, key: str) -> Plant:
    """The car that is driven, its file made absolute."""
    read = _section(_PLANT, found, path, key, also=("effects",))
    effects: dict[str, dict[str, float]] = {}
    for name, values in (dict(found).get("effects") or {}).items():  # type: ignore[call-overload]
        if name not in {e.name for e in CATALOGUE.effects}:
            raise UnknownName("effect", str(name), tuple(e.name for e in CATALOGUE.effects))
        table = tuple(
            Number(q.name, q.unit, 0.0, -1e9, 1e9, "value") for q in CATALOGUE[name].parameters
        )
        where = f"{key}.effects.{name}"
        given = {} if values is None else values
        full = _section(table, given, path, where)
        effects[name] = {k: full[k] for k in given}
    model = str((path.parent / read["model"]).resolve()) if read["model"] else ""
    return Plant(model, read["spread"], effects)


def _variants(scenario: Scenario, found: object, path: Path) -> tuple[Scenario, ...]:
    """One scenario per variant, or the scenario itself where there are none."""
    if found is None:
        return (scenario,)
    if not isinstance(found, Mapping) or not found:
        raise InputError(path, "variants", "a mapping of names to plants", repr(found))
    return tuple(
        replace(
            scenario,
            name=f"{scenario.name}/{name}",
            title=f"{scenario.title}: {str(name).replace('_', ' ')}",
            plant=_plant(plant, path, f"variants.{name}"),
        )
        for name, plant in found.items()
    )
