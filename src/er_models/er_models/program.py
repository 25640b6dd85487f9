"""Experiment programs: a road and a duty with duration and seed, from a YAML file.

    schema: er_program 1
    name: chirp                          # optional, the file's name by default
    source: "thesis 3.6.1, scenario 1"   # optional
    duration: 20.0                       # s; 0 means no end
    seed: 0                              # optional; of a random road and random steps
    road: {kind: chirp, amplitude: 0.004, f0: 0.0, f1: 10.0, sweep: 20.0}
    duty: {kind: steps, low: 0.0, high: 0.3}
    moves: wheel                         # optional; damper: no car, see below

`moves: damper` is a program for a test machine: the upper end of the damper is held and the lower
one follows the road, so that the deflection is minus the road. The kinds and their settings are
the tables `er_models.road.KINDS` and `er_models.duty.KINDS`. A road may hold `peak_velocity`
instead of `factor`: `resolve` then scales it so that the passive car reaches that deflection
velocity.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

import numpy as np
import yaml

from er_models.duty import KINDS as DUTIES
from er_models.duty import duty_profile as duty
from er_models.errors import InputError
from er_models.files import write_whole
from er_models.model import Model
from er_models.road import COMMON, road_profile
from er_models.road import KINDS as ROADS
from er_models.road.peak import factor_for_peak_velocity
from er_models.shipped import file_of
from er_models.simulation import substeps
from er_models.spec import REQUIRED, Array, Kind, Number, Setting, Text, choose, settings
from er_models.yaml_file import read_yaml

__all__ = [
    "Program", "document_of", "duty", "load_program", "parse_program", "resolve", "save_program", "times",
    "within",
]  # fmt: skip

SCHEMA = "er_program 1"
LONGEST = 120.0
"""As much of a program is looked at before it is driven [s]."""
PEAK_VELOCITY = Number(
    "peak_velocity", "m/s", 0.0, 1e-6, 100.0, "peak deflection velocity of the passive car"
)
_TABLE: tuple[Setting, ...] = (
    Text("schema", REQUIRED, f"'{SCHEMA}'", (SCHEMA,)),
    Text("name", "", "name"),
    Text("source", "", "where the program comes from"),
    Number("duration", "s", REQUIRED, 0.0, 1e6, "duration; 0 for no end"),
    Number("seed", "1", 0.0, 0.0, 2.0**32, "seed of what is random"),
    Text("moves", "wheel", "what the road moves", ("wheel", "damper")),
)


@dataclass(frozen=True)
class Program:
    """Specs of road and duty as `road_profile` and `duty_profile` take them, duration [s] (0: no end), and seed."""

    road: Mapping[str, object]
    duty: Mapping[str, object]
    duration: float
    seed: int
    name: str = ""
    source: str = ""
    moves: str = "wheel"

    def signals(self, t: Array) -> tuple[Array, Array]:
        """Road [m] and duty [1] at the times t, each (n,)."""
        return self.heights(t), self.duties(t)

    def ride(self, dt: float) -> tuple[Array, Array]:
        """Road [m] at every step of the integrator, (m (n - 1) + 1,), and duty [1] at the n samples dt [s] apart."""
        t = times(self.duration, dt)
        return self.heights(within(t.size, dt)), self.duties(t)

    def heights(self, t: Array) -> Array:
        """Road [m] at the times t (n,)."""
        return road_profile(self.road, t, self.seed)

    def duties(self, t: Array) -> Array:
        """Duty [1] at the times t (n,); it has a seed of its own."""
        return duty(self.duty, t, self.seed + 1)


def times(duration: float, dt: float) -> Array:
    """Sample times of a record [s], its last sample at the duration."""
    return dt * np.arange(int(np.floor(duration / dt + 1e-9)) + 1, dtype=float)


def within(n: int, dt: float, first: int = 0) -> Array:
    """Times [s] of the integrator's steps through n samples dt [s] apart, `first` the first one: (m (n - 1) + 1,)."""
    lines = substeps(dt)
    return dt / lines * np.arange(lines * first, lines * (first + n - 1) + 1, dtype=float)


def resolve(program: Program, model: Model, dt: float) -> Program:
    """The program with `peak_velocity`, if it asks for one, turned into a factor for this vehicle.

    Raises `InputError` when the model is no vehicle or the road does not move it.
    """
    return resolved(program, model, dt)[0]


def resolved(program: Program, model: Model, dt: float) -> tuple[Program, Array]:
    """The same, and its road [m] as of `Program.ride`, which had to be known for that; (0,) where it had not."""
    road = dict(program.road)
    if "peak_velocity" not in road:
        return program, np.empty(0)
    peak = float(road.pop("peak_velocity"))  # type: ignore[arg-type]
    n = times(program.duration or 60.0, dt).size
    heights = road_profile(road, within(n, dt), program.seed)
    factor = factor_for_peak_velocity(model, heights, dt, peak, substeps(dt))
    return replace(program, road={**road, "factor": factor}), factor * heights


def load_program(path: str | Path) -> Program:
    """Read a program file, or the shipped experiment of a name (`iso_steps`).

    Raises `InputError` naming file, key, expected and found: no file, unknown name, broken YAML, unknown or
    missing key, value out of bounds, recorded signal that cannot be read.
    """
    path = file_of(path, "experiments")
    return parse_program(read_yaml(path, "a program file"), path)


def save_program(program: Program, path: str | Path) -> None:
    """Write a program file, whole or not at all; readable again by `load_program`."""
    text = yaml.safe_dump(document_of(program), sort_keys=False, allow_unicode=True, width=99)
    write_whole(Path(path), text)


def document_of(program: Program) -> dict[str, Any]:
    """The mapping that a program file holds, of plain numbers and text."""
    return {
        "schema": SCHEMA, "name": program.name, "source": program.source,
        "duration": program.duration, "seed": program.seed, "moves": program.moves,
        "road": _plain(program.road), "duty": _plain(program.duty),
    }  # fmt: skip


def _plain(value: object) -> Any:
    """A spec of mappings, lists, text and numbers, as YAML writes it."""
    if isinstance(value, Mapping):
        return {str(k): _plain(v) for k, v in value.items()}
    if isinstance(value, list | tuple | np.ndarray):
        return [_plain(v) for v in value]
    return value if isinstance(value, str | int) else float(value)  # type: ignore[arg-type]


def parse_program(document: object, path: Path) -> Program:
    """A program from the mapping in a program file; path: its name, and where its files lie."""
    if not isinstance(document, Mapping):
        raise InputError(path, "", "a mapping of names to values", type(document).__name__)
    top = settings(_TABLE, document, path, also=("road", "duty"))
    if top["seed"] != int(top["seed"]):
        raise InputError(path, "seed", "a whole number", top["seed"])
    return Program(
        road=_spec(document, "road", ROADS, (*COMMON, PEAK_VELOCITY), path),
        duty=_spec(document, "duty", DUTIES, (), path),
        duration=top["duration"],
        seed=int(top["seed"]),
        name=top["name"] or path.stem,
        source=top["source"],
        moves=top["moves"],
    )


def _spec(
    document: Mapping[Any, Any],
    key: str,
    kinds: Mapping[str, Kind],
    more: tuple[Setting, ...],
    path: Path,
) -> dict[str, object]:
    """One checked spec, its file made absolute, tried out at t = 0: a bad one fails here."""
    found = document.get(key)
    if found is None:
        raise InputError(path, key, f"a mapping with kind: {', '.join(kinds)}", "nothing")
    kind = choose(kinds, found, path, key)
    values = settings((*kind.settings, *more), found, path, key)
    if "peak_velocity" in found and "factor" in found:
        raise InputError(path, f"{key}.peak_velocity", "either factor or peak_velocity", "both")
    if values.get("file"):
        values["file"] = str((path.parent / values["file"]).resolve())
    try:
        kind.make(values, np.zeros(1), 0)
    except InputError as error:
        inner = error.path if values.get("file") == error.path else path
        name = error.key if inner != path else f"{key}.{error.key}"
        raise InputError(inner, name, error.expected, error.found) from error
    spec = {name: values[name] for name in found if name != "kind"}
    return {"kind": kind.name, **spec}
