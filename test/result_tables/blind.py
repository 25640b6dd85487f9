"""Scores of the lab on data of other generators, and of its peers."""

from __future__ import annotations

from test.blind_score.rows import DECIDES
from test.result_tables.given import Tables, given


def _score(name: str, command: str, *tables: str, truth: str = "test/blind") -> Tables:
    """What a score prints of data of this generator."""
    code = (*DECIDES[:2], truth)
    command = f"exec python -m test.{command}"
    return given(name, command, "blind.md", code, *tables, writes="--table FILE")


TABLES: Tables = {
    **_score("blind_score", "blind_score --seeds 53-62 --records 1 --seconds 60", "blind score"),
    **_score("blind_limit", "blind_score.limit --seeds 58 61-63", "blind limit"),
    **_score("blind_alarms", "blind_score.alarms --seeds 1-100", "blind alarms"),
    **_score(
        "blind_conditions",
        "blind_score --condition all --seeds 103 --effects none stribeck_friction rise_fall_asymmetry self_heating",
        "blind conditions",
        "blind conditions missed",
    ),
    **_score(
        "rough_score",
        "rough_score --seeds 223 --cases 100 --workers 2 --limit 300",
        "rough score",
        "rough groups",
        truth="test/rough",
    ),
    **_score(
        "rough_stability",
        "rough_stability --seeds 71 --cases 30",
        "rough stability",
        "rough stability missed",
        truth="test/rough",
    ),
    **given(
        "peers", "exec python -m test.peers --seeds 1 --complete 6", "peers.md",
        (*DECIDES[:2], "test/blind", "test/peers"), "peers", writes="> FILE",
    ),
}  # fmt: skip
