"""The programs of the package that are nodes, each declared here and nowhere else."""

from __future__ import annotations

from typing import Final

from er_common.program import Program
from er_common.topics import SENSORS

RECORDER: Final = Program(
    "recorder",
    "er_model_lab",
    "Records topics into a rosbag2 folder (MCAP or sqlite3) until it is stopped.",
    listens=SENSORS,
)
PROGRAMS: Final = (RECORDER,)
