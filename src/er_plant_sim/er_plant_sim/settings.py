"""Parameters of the plant node; those of the program come from its kinds. No ROS here."""

from __future__ import annotations

from collections.abc import Iterable
from dataclasses import dataclass, fields, make_dataclass
from difflib import get_close_matches
from typing import Any

from er_common.parameter_table import REQUIRED, param, tuning
from er_models.duty import KINDS as DUTIES
from er_models.errors import InputError
from er_models.road import FACTOR
from er_models.road import KINDS as ROADS
from er_models.spec import Number, Parts, Series, Text

from er_plant_sim.rig_parameters import RigParameters

MODES = ("realtime", "sim_time", "lockstep")
_DOT = "__"
"""Stands for the dot of a parameter's name in the name of a field."""


def _deviation(sensor: str, unit: str) -> Any:
    text = f"standard deviation of the noise of the {sensor}"
    return param(0.0, unit=unit, low=0.0, high=1e3, name=f"noise.{sensor}", text=text)


def _bias(sensor: str, unit: str) -> Any:
    text = f"constant error of the {sensor}"
    return param(0.0, unit=unit, low=-1e3, high=1e3, name=f"bias.{sensor}", text=text)


@dataclass(frozen=True, kw_only=True)
class SensorErrors:
    """Noise and constant errors of simulated sensors; the noise of the force is every rig's."""

    noise_sprung: float = _deviation("sprung_acceleration", "m/s2")
    noise_unsprung: float = _deviation("unsprung_acceleration", "m/s2")
    noise_deflection: float = _deviation("deflection", "m")
    noise_velocity: float = _deviation("deflection_velocity", "m/s")
    bias_sprung: float = _bias("sprung_acceleration", "m/s2")
    bias_unsprung: float = _bias("unsprung_acceleration", "m/s2")
    bias_deflection: float = _bias("deflection", "m")
    bias_velocity: float = _bias("deflection_velocity", "m/s")
    bias_force: float = _bias("force", "N")


@dataclass(frozen=True, kw_only=True)
class PlantParameters(RigParameters, SensorErrors):
    """Every parameter of the plant but those of the program (`road.*`, `duty.*`), which override its file."""

    damper_file: str = tuning("", text="model file whose damper replaces that of the vehicle")
    mode: str = param(
        "realtime",
        choices=MODES,
        text="pace: of the real clock, of simulated time, or of the duties that answer",
    )
    rate_factor: float = param(
        1.0, low=0.0, high=50.0, text="speed of simulated time; 0: as fast as commands come"
    )
    recorder: str = param(
        "", text="node that records, which the plant waits for; empty: no waiting"
    )
    recorded: tuple[str, ...] = param((), text="topics that must be recorded without a gap")
    duty_source: str = param(
        "program", choices=("program", "topic"), text="where the duty comes from"
    )


def table(given: Iterable[str]) -> type[Any]:
    """The parameter dataclass with those program settings that are given.

    Which settings a road or duty has depends on its kind, so only what the user names is declared.

    Raises:
        InputError: No road and no duty has a setting of that name.
    """
    given, known = tuple(given), _program_settings()
    for name in given:
        if name.startswith(("road.", "duty.")) and name not in known:
            near = get_close_matches(name, known, n=1)
            hint = f"did you mean {near[0]}?" if near else f"known: {', '.join(known)}"
            expected = f"a setting of a road or duty ({hint})"
            raise InputError("parameters", name, expected, "an unknown name")
    more = [(name, known[name]) for name in sorted(given) if name in known]
    items = [(_attribute(name), kind, declared) for name, (kind, declared) in more]
    return make_dataclass(
        "PlantParameters", items, bases=(PlantParameters,), frozen=True, kw_only=True
    )


def _program_settings() -> dict[str, tuple[Any, Any]]:
    """ROS parameter name to type and declaration, for every setting of every road and duty."""
    found: dict[str, tuple[Any, Any]] = {}
    for prefix, kinds, common in (("road", ROADS, (FACTOR,)), ("duty", DUTIES, ())):
        words = f"kind of {prefix}"
        name = f"{prefix}.kind"
        found[name] = (str, param(REQUIRED, name=name, choices=tuple(kinds), text=words))
        for kind in kinds.values():
            for setting in (*kind.settings, *common):
                if isinstance(setting, Parts):  # no parameter of ROS holds it: only a file can
                    continue
                name = f"{prefix}.{setting.name}"
                found[name] = _declared(name, setting)
    return found


def _declared(name: str, setting: Number | Text | Series) -> tuple[Any, Any]:
    """Type and declaration of a setting; its bounds are checked with the program."""
    if isinstance(setting, Text):
        return str, param(REQUIRED, name=name, text=setting.meaning)
    kind = tuple[float, ...] if isinstance(setting, Series) else float
    return kind, param(REQUIRED, name=name, unit=setting.unit, text=setting.meaning)


def program_values(parameters: PlantParameters, prefix: str) -> dict[str, Any]:
    """The given settings of the road or duty, by name."""
    start = f"{prefix}{_DOT}"
    return {
        item.name.removeprefix(start): getattr(parameters, item.name)
        for item in fields(parameters)
        if item.name.startswith(start)
    }


def _attribute(name: str) -> str:
    return name.replace(".", _DOT)
