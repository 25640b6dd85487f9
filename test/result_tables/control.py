"""Controllers beside their peers, with loads and late samples, and on the whole car."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numpy as np
from er_studies.control import contest, robust, whole_car

from test.result_tables.stored import Run

CODE = (
    "src/er_models/er_models",
    "src/er_ftc_controller/er_ftc_controller",
    "src/er_studies/er_studies/control",
)
PEERS = Run("control_peers", "control peers", "control_comparison.md", CODE)
ROBUST = Run(
    "control_robust",
    "control robust --seeds 3",
    "control_comparison.md",
    (*CODE, "src/er_observers/er_observers"),
)
CAR = Run("control_car", "control car --seeds 3 --first 100", "car.md", CODE)


def peers(values: dict[str, Any]) -> str:
    """Every controller on every kind of road, with every fault."""
    lines = [contest.Line(*names, np.array(change)) for *names, change in values["lines"]]
    return contest.markdown(lines) + "\n"


def tones(values: dict[str, Any]) -> str:
    """Ours, tone by tone."""
    return contest.tones_markdown({hertz: row for hertz, row in values["tones"]}) + "\n"


def other_loads(values: dict[str, Any]) -> str:
    """Ours beside a constant duty, told neither of the load nor of the lateness."""
    return robust.markdown(values["cases"], values["constant"]) + "\n"


def car(values: list[Any]) -> str:
    """Controllers of the whole car."""
    return whole_car.markdown([(ride, law, np.array(row)) for ride, law, row in values]) + "\n"


TABLES: dict[str, tuple[Run, Callable[[Any], str]]] = {
    "peers": (PEERS, peers),
    "tones": (PEERS, tones),
    "other loads": (ROBUST, other_loads),
    "car": (CAR, car),
}
