"""Lockstep: two runs with the same seed give identical messages, however busy the machine."""

from __future__ import annotations

from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("rclpy")

from rosbags.highlevel import AnyReader

from test.graph_help import Graph, own_domain

pytestmark = pytest.mark.alone

TICKS = 600
TOPICS = (
    "/sensors/acceleration",
    "/sensors/deflection",
    "/sensors/force",
    "/sensors/road",
    "/pwm/applied",
    "/pwm/command",
)


Messages = dict[str, dict[int, Any]]
"""Messages by topic and tick."""


def run(folder: Path, seed: int) -> Messages:
    """What a lockstep run of 3 s recorded."""
    folder.mkdir()
    bag = folder / "bag"
    found: Messages = {topic: {} for topic in TOPICS}
    with own_domain() as env, Graph(env, folder) as graph:
        status, text = graph.run(
            "up", "mode:=lockstep", "rate_factor:=2.0", "observers:=none", "duration:=3.0",
            f"seed:={seed}", f"record:={bag}", seconds=120.0,
        )  # fmt: skip
    assert status == 0, text
    assert f"finished after {TICKS} ticks" in text
    with AnyReader([bag]) as reader:
        for connection, _, data in reader.messages():
            if connection.topic in found:
                message = reader.deserialize(data, connection.msgtype)
                if message.seq and message.status != message.STATUS_LOST:
                    found[connection.topic][message.seq] = message
    return found


@pytest.fixture(scope="module")
def twice(tmp_path_factory: pytest.TempPathFactory) -> list[Messages]:
    """Two runs with one seed."""
    folder = tmp_path_factory.mktemp("lockstep")
    return [run(folder / name, 3) for name in ("a", "b")]


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
