"""Arguments of the launch file and of `er up`, KEY:=VALUE, written down once."""

from __future__ import annotations

import math
import re
from dataclasses import dataclass

from er_models.seed import OF_A_PLANT
from er_observers.programs import OBSERVERS

from er_bringup.programs import ASKED, CONTROLLERS


@dataclass(frozen=True)
class Argument:
    """One argument; kind is what its text must mean, low and high the bounds of a number, those of the nodes."""

    name: str
    default: str
    meaning: str
    choices: tuple[str, ...] = ()
    kind: type[str] | type[int] | type[float] = str
    low: float = -math.inf
    high: float = math.inf

    @property
    def expected(self) -> str:
        """What a value must be, in words."""
        if self.choices:
            return f"one of {', '.join(each or 'nothing' for each in self.choices)}"
        if self.kind is str:
            return "a text"
        word = "an integer" if self.kind is int else "a number"
        return f"{word} in {self.low:.12g}..{self.high:.12g}"


ARGUMENTS = (
    Argument("namespace", "", "namespace of the corner, for instance front_left"),
    Argument(
        "corners",
        "",
        "corners below the namespace: 4 (front_left to rear_right), or names with commas between",
    ),
    Argument("model", "inove_quarter_car", "vehicle model: a file, or a name in config/vehicles"),
    Argument("damper", "", "model whose damper is put into the plant: an effect can hide there"),
    Argument("effects_from", "", "Python files with own effects of these models, commas between"),
    Argument("program", "iso_steps", "road and duty: a file, or a name in config/experiments"),
    Argument(
        "duration",
        "-1",
        "length of the run [s]; -1: as the program says, 0: until Ctrl-C",
        (),
        float,
        -1.0,
        1e6,
    ),
    Argument(
        "seed",
        "-1",
        "seed of road, duty and sensor noise; -1: the program's",
        (),
        int,
        -1,
        OF_A_PLANT,
    ),
    Argument(
        "mode",
        "realtime",
        "pace: of the real clock, of simulated time, or of the duties that answer",
        choices=("realtime", "sim_time", "lockstep"),
    ),
    Argument(
        "rate_factor",
        "1.0",
        "speed of simulated time; 0 in lockstep: no waiting",
        (),
        float,
        0.0,
        50.0,
    ),
    Argument(
        "hardware",
        "",
        "instead of the plant: serial:PORT[@BAUD] or udp:HOST:PORT of a rig, one a corner; stack: a vehicle's own",
    ),
    Argument(
        "calibration",
        "",
        "calibration of the rig's channels: a file, or a name in config/hardware",
    ),
    Argument(
        "key",
        "",
        "key file of the wire; none: no authentication; empty: the user's own over UDP, none over a serial port",
    ),
    Argument("road", "device", "who moves the road of a real rig", choices=("device", "program")),
    Argument("controller", "skyhook", "controller to run", choices=(*CONTROLLERS, "none")),
    Argument(
        "duty", "command", "where the duty of the plant comes from", choices=("command", "program")
    ),
    Argument("observers", ",".join(OBSERVERS), "observers to run, with commas between, or none"),
    Argument(
        "gains", "", "gains: a file, or a name in config/gains; by default those of each observer"
    ),
    *(Argument(p.name, "false", p.asked, choices=("false", "true")) for p in ASKED),
    Argument(
        "remap",
        "",
        "topics under other names, OLD=NEW with commas between; {corner} in NEW is the corner",
    ),
    Argument("record", "", "folder to be made for a recording; by default nothing is recorded"),
    Argument("storage", "mcap", "format of the recording", choices=("mcap", "sqlite3")),
    Argument(
        "composed", "false", "all but the recorder in one process", choices=("false", "true")
    ),
    Argument(
        "priority", "0", "real-time priority (SCHED_FIFO) of all but the recorder", (), int, 0, 99
    ),
    Argument(
        "plant_params",
        "",
        "parameter file for plant or bridge; its values win over those in config/nodes",
    ),
    Argument(
        "params_file",
        "",
        "parameter files for nodes by their names, commas between; {corner} in a path is the corner",
    ),
    Argument(
        "use_sim_time",
        "",
        "true: the same as mode:=sim_time; empty: as the mode says",
        choices=("", "false", "true"),
    ),
    Argument(
        "autostart",
        "true",
        "false: nodes wait for a manager (ros2 lifecycle set NODE configure)",
        choices=("false", "true"),
    ),
    Argument(
        "respawn",
        "false",
        "start nodes again that end badly, after 2 s; all but the recorder",
        choices=("false", "true"),
    ),
    Argument(
        "log_level",
        "info",
        "lowest level of the nodes' log",
        choices=("debug", "info", "warn", "error", "fatal"),
    ),
)


NAME = "letters, digits and single underscores"
NAMESPACE = f"names of {NAME} with / between"
_NAME = r"(?!\w*__)[A-Za-z_]\w*"


def is_name(text: str) -> bool:
    """Whether ROS takes a text for one part of a namespace."""
    return re.fullmatch(_NAME, text, re.ASCII) is not None


def is_namespace(text: str) -> bool:
    """Whether ROS takes a text for a namespace; empty is the root."""
    return re.fullmatch(rf"/?({_NAME}(/{_NAME})*/?)?", text, re.ASCII) is not None


def table() -> str:
    """The arguments as text, one a line, with what each may be and its default."""
    rows = [(a.name, a.meaning, _allowed(a), f"default '{a.default}'") for a in ARGUMENTS]
    widths = [max(len(row[i]) for row in rows) for i in range(3)]
    lines = (
        "  ".join([*(c.ljust(w) for c, w in zip(row, widths, strict=False)), row[3]])
        for row in rows
    )
    return "\n".join(f"  {line}" for line in lines)


def _allowed(argument: Argument) -> str:
    return "" if argument.kind is str and not argument.choices else argument.expected
