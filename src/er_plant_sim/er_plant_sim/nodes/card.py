"""``plant --help``: topics, parameters, and the settings of every road and duty."""

from __future__ import annotations

from er_models.duty import KINDS as DUTIES
from er_models.road import KINDS as ROADS
from er_models.spec import REQUIRED, Kind, Number, Parts, Setting, Text
from er_ros_common.help import Card

from er_common import topics
from er_plant_sim.programs import PLANT
from er_plant_sim.settings import PlantParameters


def _kind(prefix: str, kind: Kind) -> str:
    settings = ", ".join(_setting(setting) for setting in kind.settings)
    return f"  {prefix}.kind:={kind.name}  {kind.title}; {settings or 'no settings'}"


def _setting(setting: Setting) -> str:
    if isinstance(setting, Parts):
        return f"{setting.name} (in a program file)"
    unit = "" if isinstance(setting, Text) or setting.unit == "1" else f" {setting.unit}"
    if setting.default is REQUIRED:
        return f"{setting.name} (required)"
    shown = f"{setting.default:g}" if isinstance(setting, Number) else setting.default
    return f"{setting.name} {shown}{unit}"


_PROGRAM = "\n".join(
    [
        "the program is a file, or these parameters, or a file with some of these on top:",
        *(_kind("road", kind) for kind in ROADS.values()),
        *(_kind("duty", kind) for kind in DUTIES.values()),
        "each setting is a parameter: road.amplitude, duty.hold_min; road.factor scales any road",
    ]
)

CARD = Card(
    PLANT,
    PlantParameters,
    subscribes=(topics.PWM_COMMAND,),
    publishes=(*topics.SENSORS, topics.CLOCK, topics.STATUS, topics.DIAGNOSTICS),
    more=(_PROGRAM,),
)
