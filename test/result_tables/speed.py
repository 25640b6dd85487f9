"""What prediction, observers, the lab and the wire cost, and what demonstrations find."""

from __future__ import annotations

from typing import Any

from er_studies.given_out import table

from test.result_tables.given import Tables, given
from test.result_tables.measured import CODE as LAB
from test.result_tables.observers import OBSERVERS
from test.result_tables.reliability import GRAPH

MODELS = ("src/er_models/er_models", "src/er_studies/er_studies/bench/models")
DEAR = 2.0
"""Ratio from which on an effect is shown."""
PARTS = ("prediction", "ride", "batch", "length", "number", "memory", "effects", "starting")
PAGE = (
    "src/er_model_lab/er_model_lab/page", "src/er_model_lab/er_model_lab/session", "src/er_model_lab/er_model_lab/live",
    "src/er_model_lab/er_model_lab/monitor",
)  # fmt: skip
STEPS = ("observers, duty that varies", "observers, duty that switches")


def _bench(
    name: str, words: str, code: tuple[str, ...], *tables: str, page: str = "performance.md"
) -> Tables:
    return given(f"bench_{name}", f"bench {words}", page, code, *tables, writes="> FILE")


def dear_effects(values: dict[str, Any]) -> str:
    """Effects that a prediction feels."""
    head, rows = values["effects"]["head"], values["effects"]["rows"]
    return table(head[:3], [row[:3] for row in rows if float(row[2].split()[0]) >= DEAR])


def _live(later: str, hidden: str) -> Tables:
    command = f"demo --live --effect {hidden} --later {later} --seed 1"
    return given(
        f"live_{later}", command, "page.md", (*LAB, *GRAPH), f"live, {later}", writes="> FILE"
    )


_COSTS = _bench("models", "models", MODELS, *PARTS, "machine of models")
TABLES: Tables = {
    **_COSTS,
    "effects": (_COSTS["effects"][0], dear_effects),
    **_bench("observers", "observers", OBSERVERS, *STEPS, "machine of observers"),
    **_bench("jitter", "observers --jitter 20", OBSERVERS, *(f"{each}, jitter" for each in STEPS)),
    **_bench(
        "wire", "wire", ("src/er_plant_sim/er_plant_sim/hardware",), "wire", "machine of wire"
    ),
    **given(
        "demo",
        "demo --repeat 10 --seed 1000",
        "demo.md",
        (*LAB, *GRAPH),
        "demonstrations",
        writes="> FILE",
    ),
    **_bench(
        "lab", "lab minute length number --longest 120", LAB,
        "minute", "lengths", "numbers", "machine of lab", page="lab_speed.md",
    ),
    **_bench(
        "page", "page", PAGE,
        "work of the page", "figures of the live page", "machine of the page", "page in a browser", page="page.md",
    ),
    **_bench(
        "monitor", "monitor", PAGE,
        "core of the monitor", "machine of the monitor", "beside the loop", "processes beside the loop", page="page.md",
    ),
    **_live("leak", "asymmetric_damping"),
    **_live("heat", "quadratic_damping"),
    **_bench("lab_beginnings", "lab beginnings", LAB, "beginnings", page="lab_speed.md"),
    **_bench("lab_page", "lab page", LAB, "page of my rig", "machine of my rig", page="lab_speed.md"),
}  # fmt: skip
