"""Files of control scenarios: a road, limits of the duty, and faults that come during the run.

schema: er_control_scenario 1
title: ISO road, 60 % of the oil left
source: "thesis 6.4.2"
program:                       # as a program file without its schema; seed is that of the first road
  duration: 17.0
  seed: 1
  road: {kind: iso8608, peak_velocity: 0.15}
  duty: {kind: constant, level: 0.0}
seeds: 20
duty_max: 1.0                  # greatest duty of the LPV controllers
latency: 0                     # samples from measurement to duty
window: {begin: 7.0, end: 17.0}
faults:                        # one run each, named FILE/FAULT
  leakage: {oil_leakage: {f: 0.6, t_0: 2.0}}
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from er_models.constants import SAMPLE_TIME as DT
from er_models.errors import InputError, UnknownName
from er_models.fault_profile import PARAMETERS
from er_models.model import Array, Model, Values
from er_models.program import SCHEMA as PROGRAM_SCHEMA
from er_models.program import Program, parse_program, resolve
from er_models.spec import REQUIRED, Number, Setting, Text, settings
from er_models.yaml_file import read_yaml

from er_studies.control.closed_loop import FAULTS

SCHEMA = "er_control_scenario 1"
_TABLE: tuple[Setting, ...] = (
    Text("schema", REQUIRED, f"'{SCHEMA}'", (SCHEMA,)),
    Text("title", REQUIRED, "what is driven"),
    Text("source", "", "where the scenario comes from"),
    Number("seeds", "1", 1.0, 1.0, 1000.0, "number of roads"),
    Number("duty_max", "duty", REQUIRED, 0.0, 1.0, "greatest duty"),
    Number("latency", "samples", 0.0, 0.0, 4.0, "from measurement to duty"),
)
_WINDOW: tuple[Setting, ...] = (
    Number("begin", "s", REQUIRED, 0.0, 1e6, "begin of what counts"),
    Number("end", "s", REQUIRED, 0.0, 1e6, "end of what counts"),
)
_SECTIONS = ("program", "window", "faults")


@dataclass(frozen=True)
class Scenario:
    """A drive over `seeds` roads, and by name the faults it is driven with."""

    name: str
    title: str
    source: str
    program: Program
    seeds: int
    duty_max: float
    latency: int
    window: tuple[float, float]
    faults: Mapping[str, Values]

    def road(self, model: Model, number: int) -> Array:
        """Heights of road `number`, as of `Program.ride`, scaled by the healthy car."""
        program = replace(self.program, seed=self.program.seed + number)
        return resolve(program, model, DT).ride(DT)[0]

    def car(self, model: Model, fault: str) -> Model:
        """The car with the effects of a fault."""
        for name, values in self.faults[fault].items():
            model = model.with_effect(name, values)
        return model


def load_scenarios(folder: str | Path, only: Sequence[str] = ()) -> tuple[Scenario, ...]:
    """Scenarios of a folder, or those of these names.

    Raises `InputError` naming file, key, expected and found, `UnknownName` for a name that is none.
    """
    files = {file.stem: file for file in sorted(Path(folder).glob("*.yaml"))}
    if not files:
        raise InputError(folder, "", "a folder with control scenarios (*.yaml)", "none")
    for name in only:
        if name not in files:
            raise UnknownName("control scenario", name, tuple(files))
    return tuple(load_scenario(file) for name, file in files.items() if not only or name in only)


def load_scenario(path: str | Path) -> Scenario:
    """The scenario of a file; raises as `load_scenarios`."""
    path = Path(path)
    document = read_yaml(path, "a control scenario")
    if not isinstance(document, Mapping):
        raise InputError(path, "", "a mapping of names to values", type(document).__name__)
    top = settings(_TABLE, document, path, also=_SECTIONS)
    program = _program(_section(document, "program", path), path)
    window = settings(_WINDOW, _section(document, "window", path), path, "window")
    begin, end = window["begin"], window["end"]
    if not begin < end <= program.duration:
        expected = f"begin < end <= duration ({program.duration:g} s)"
        raise InputError(path, "window", expected, f"{begin:g} to {end:g} s")
    faults = {
        str(name): _effects(values, path, f"faults.{name}")
        for name, values in _section(document, "faults", path).items()
    }
    return Scenario(
        path.stem, top["title"], top["source"], program, int(top["seeds"]), top["duty_max"],
        int(top["latency"]), (begin, end), faults,
    )  # fmt: skip


def _section(document: Mapping[Any, Any], key: str, path: Path) -> Mapping[Any, Any]:
    """A mapping that must be there and hold something."""
    found = document.get(key)
    if not isinstance(found, Mapping) or not found:
        raise InputError(path, key, "a mapping of names to values", repr(found))
    return found


def _program(found: Mapping[Any, Any], path: Path) -> Program:
    """The drive."""
    program = parse_program({"schema": PROGRAM_SCHEMA, **found}, path)
    if program.duration <= 0.0:
        raise InputError(path, "program.duration", "more than 0 s", program.duration)
    return program


def _effects(found: object, path: Path, key: str) -> dict[str, dict[str, float]]:
    """Faults with their profiles; empty for the healthy car."""
    if found is None:
        return {}
    if not isinstance(found, Mapping):
        raise InputError(path, key, "a mapping of faults to values", repr(found))
    table = tuple(Number(q.name, q.unit, 0.0, q.low, q.high, q.meaning) for q in PARAMETERS)
    effects = {}
    for name, values in found.items():
        if name not in FAULTS:
            raise UnknownName("fault", str(name), FAULTS)
        if not isinstance(values, Mapping):
            raise InputError(path, f"{key}.{name}", "a mapping of names to values", repr(values))
        full = settings(table, values, path, f"{key}.{name}")
        effects[str(name)] = {k: full[k] for k in values}
    return effects
