"""The graph with faults, beside other programs, and what it costs."""

from __future__ import annotations

from test.result_tables.given import Tables, given

GRAPH = (
    "src/er_models/er_models",
    "src/er_observers/er_observers",
    "src/er_ftc_controller/er_ftc_controller",
    "src/er_plant_sim/er_plant_sim",
    "src/er_ros_common/er_ros_common",
)


def _run(words: str, *tables: str) -> Tables:
    command = f"exec python -m test.reliability {words}"
    name = f"graph_{words.split()[0]}"
    return given(name, command, "reliability.md", GRAPH, *tables, writes="> FILE")


TABLES: Tables = {
    **_run("faults", "how soon a fault shows", "without faults"),
    **_run("silence", "after a silence"),
}
