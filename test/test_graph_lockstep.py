"""Lockstep: runs with the same seed record identical messages, however long anybody is held up."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("rclpy")

from rosbags.highlevel import AnyReader

from test.graph_help import Graph, own_domain
from test.reliability.hold import MOVING, child, hold

pytestmark = pytest.mark.alone

TICKS = 600
TOPICS = (
    "/sensors/acceleration",
    "/sensors/deflection",
    "/sensors/force",
    "/sensors/road",
    "/pwm/applied",
    "/pwm/command",
    "/force/nlpv_polytopic",
)
HELD = {"recorder": 0.3, "nlpv_polytopic_observer": 0.3, "skyhook_controller": 0.3}
"""Who is held up in one of the runs, one after the other [s]: 240 ticks at the pace of the run."""


Messages = dict[str, dict[int, Any]]
"""Messages by topic and tick."""


def run(folder: Path, seed: int, held: Mapping[str, float]) -> Messages:
    """What a lockstep run of 3 s recorded, in which these programs were held up for so long [s]."""
    folder.mkdir()
    bag = folder / "bag"
    found: Messages = {topic: {} for topic in TOPICS}
    with own_domain() as env, Graph(env, folder) as graph:
        up = graph.start(
            "up", "mode:=lockstep", "rate_factor:=4.0", "observers:=nlpv_polytopic", "duration:=3.0",
            f"seed:={seed}", f"record:={bag}",
        )  # fmt: skip
        up.wait_for(MOVING)
        for program, seconds in held.items():
            hold(child(up, program), seconds)
        assert "finished" not in up.text, "it was over before everybody was held up"
        assert up.end(120.0) == 0, up.text
    assert f"finished after {TICKS} ticks" in up.text
    assert "lost nothing" in up.text
    with AnyReader([bag]) as reader:
        for connection, _, data in reader.messages():
            if connection.topic in found:
                message = reader.deserialize(data, connection.msgtype)
                if message.seq and message.status != message.STATUS_LOST:
                    found[connection.topic][message.seq] = message
    return found


@pytest.fixture(scope="module")
def twice(tmp_path_factory: pytest.TempPathFactory) -> list[Messages]:
    """Two runs with one seed, the second of them disturbed."""
    folder = tmp_path_factory.mktemp("lockstep")
    return [run(folder / name, 3, held) for name, held in (("a", {}), ("b", HELD))]


def test_same_seed_same_run(twice: list[Messages]) -> None:
    first, second = twice
    for topic in TOPICS:
        assert set(first[topic]) == set(range(1, TICKS + 1)), topic
        assert written(first[topic]) == written(second[topic]), topic
    noise = [m.force for m in first["/sensors/force"].values()]
    assert len(set(noise)) == TICKS


def test_a_tick_waits_for_the_command_that_answers_it(twice: list[Messages]) -> None:
    applied = twice[0]["/pwm/applied"].values()
    assert all(m.command_seq == m.seq for m in applied)
    # simulated time starts at zero and advances by the sample time
    stamps = [m.header.stamp.sec * 10**9 + m.header.stamp.nanosec for m in applied]
    assert stamps == [5_000_000 * k for k in range(1, TICKS + 1)]


def written(messages: dict[int, Any]) -> dict[int, str]:
    """Messages as text with all digits: those of two recordings are of different Python types."""
    return {tick: repr(message) for tick, message in messages.items()}
