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
CORNERS = (
    "bench ros --corners 4 --controller skyhook --layout processes --executor events --transport udp,shm"
    " --seconds 20 --rate 50"
)
"""Four corners, over both transports."""


def _run(words: str, *tables: str, name: str = "") -> Tables:
    command = f"exec python -m test.reliability {words}"
    name = f"graph_{name or words.split()[0]}"
    return given(name, command, "reliability.md", GRAPH, *tables, writes="> FILE")


def _bench(name: str, words: str, *tables: str, page: str = "reliability.md") -> Tables:
    return given(f"bench_{name}", words, page, GRAPH, *tables, writes="> FILE")


TABLES: Tables = {
    **_run("faults", "how soon a fault shows", "without faults"),
    **_run("silence", "after a silence"),
    **_run("kill 20", "killed processes"),
    **_run("hold 2", "recorder held up"),
    **_run("hog 10", "busy machine"),
    **_run("hog 10 40", "busy machine, priority", name="hog_priority"),
    **_run("soak 1800 40", "soak"),
    **_bench("ros", "bench ros", "loop", "", "beside plain rclpy", "aims of the loop"),
    **_bench("ros_slow", "bench ros", "loop, slow machine", "", "", "", "slow machine of the loop"),
    **_bench("ros_fast", "bench ros --rate 1000 --layout composed --executor events", "", "", "aims at 1 kHz"),
    **_bench("ros_corners", CORNERS, "loop of four corners"),
    **_bench(
        "graph", "bench graph --seconds 60 --controller", "topics of the graph", "processes of the graph",
        page="performance.md",
    ),
}  # fmt: skip
