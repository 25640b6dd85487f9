"""Two corners at once, each a process of its own, with one recorder above them."""

from __future__ import annotations

from pathlib import Path

import pytest

pytest.importorskip("rclpy")

from er_records.load import load

from test.graph_help import Graph, own_domain, paced

pytestmark = pytest.mark.alone

CORNERS = ("front_left", "rear_right")
TICKS = 400


def test_each_corner_is_a_whole_graph_and_the_recording_holds_all(
    tmp_path: Path, pace: float
) -> None:
    bag = tmp_path / "bag"
    with own_domain() as env, Graph(env, tmp_path) as graph:
        status, text = graph.run(
            "up", f"corners:={','.join(CORNERS)}", "namespace:=car", "composed:=true",
            "observers:=unified", f"duration:={TICKS / 200}", "seed:=3", f"record:={bag}",
            *paced(pace), seconds=120.0,
        )  # fmt: skip
    assert status == 0, text
    assert text.count(f"finished after {TICKS} ticks") == 2
    for corner in CORNERS:
        assert f"[{corner}/composed]" in text
    records = {record.name.rpartition("/")[2]: record for record in load([bag])}
    assert set(records) == set(CORNERS)
    left, right = (records[corner] for corner in CORNERS)
    for record in (left, right):
        assert len(record.t) > 0.9 * TICKS
        assert "force_unified" in record.channels
    # each has a draw of its own
    assert left.channels["road"][100:110].tolist() != right.channels["road"][100:110].tolist()
