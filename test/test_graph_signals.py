"""Ends: Ctrl-C, SIGTERM, a killed parent, a killed recorder: nothing is left, nothing lost."""

from __future__ import annotations

import signal
from collections.abc import Iterator
from pathlib import Path
from time import monotonic, sleep

import numpy as np
import pytest

pytest.importorskip("rclpy")

from er_common.stamps import SECOND
from er_records.load import load
from er_records.readers.mcap_salvage import salvage
from er_records.recording.message_count import header_of
from er_records.repair import SHORT_GAP
from rosbags.highlevel import AnyReader

from test.graph_help import (
    Graph,
    observer_arguments,
    own_domain,
    plant_arguments,
    skyhook_arguments,
)

pytestmark = pytest.mark.alone

NODES = {
    "plant": plant_arguments("-p", "duration:=0.0"),
    "skyhook_controller": skyhook_arguments(),
    "nlpv_polytopic_observer": observer_arguments(),
}


@pytest.fixture
def graph(tmp_path: Path) -> Iterator[Graph]:
    with own_domain() as env, Graph(env, tmp_path) as made:
        yield made


def messages(bag: Path) -> int:
    """Messages in a closed recording."""
    with AnyReader([bag]) as reader:
        return sum(1 for _ in reader.messages())


def test_nodes_end_on_ctrl_c_without_a_traceback(graph: Graph) -> None:
    started = {name: graph.start(name, *arguments) for name, arguments in NODES.items()}
    for name, node in started.items():
        node.wait_for(f"[{name}]: ")
    for name, node in started.items():
        began = monotonic()
        assert node.stop() == 0, node.text
        assert monotonic() - began < 5.0, name
        assert "Traceback" not in node.text


def test_recordings_are_closed_whatever_the_signal(graph: Graph, tmp_path: Path) -> None:
    cases = {
        signal.SIGINT: "mcap",
        signal.SIGTERM: "sqlite3",
        signal.SIGHUP: "mcap",
        signal.SIGKILL: "mcap",
    }
    recorders = {
        number: graph.start("record", str(tmp_path / number.name), "--storage", storage)
        for number, storage in cases.items()
    }
    plant = graph.start("plant", *NODES["plant"], "-p", "wait_for:=[4, 4, 4, 4, 4]")
    plant.wait_for("running")
    sleep(4.5)
    for number, recorder in recorders.items():
        status = recorder.stop(number)
        if number != signal.SIGKILL:
            assert status == 0, recorder.text
            assert "Traceback" not in recorder.text
            assert messages(tmp_path / number.name) > 4 * 200
    # what a killed recorder had brought to disk can be read, is said to be incomplete, and is in pieces only where the
    # plant itself was held up: no message in between was lost
    (file,) = (tmp_path / signal.SIGKILL.name).glob("*.mcap")
    topic = "/sensors/acceleration"
    heads = [header_of(raw) for name, _, raw, _ in salvage(file).messages if name.endswith(topic)]
    found = np.array([(head.stamp, head.seq) for head in heads if head is not None])
    assert np.all(np.diff(found[:, 1]) == 1)
    held_up = np.sum(np.diff(found[:, 0]) > SHORT_GAP * SECOND / 200)
    records = load([file.parent])
    assert 1 <= len(records) <= 1 + held_up
    assert not any(record.complete for record in records)
    assert sum(record.t[-1] - record.t[0] for record in records) > 2.0


def test_one_wish_to_stop_that_arrives_as_several_signals_closes_the_recording(
    graph: Graph, tmp_path: Path
) -> None:
    recorder = graph.start("record", str(tmp_path / "bag"))
    plant = graph.start("plant", *NODES["plant"], "-p", "wait_for:=[1, 1, 1, 1, 1]")
    plant.wait_for("running")
    sleep(1.0)
    # the threads of a dying parent each have the kernel send a SIGTERM
    for _ in range(3):
        recorder.process.send_signal(signal.SIGTERM)
        sleep(0.02)
    assert recorder.end(20.0) == 0, recorder.text
    assert messages(tmp_path / "bag") > 100


def test_up_takes_everybody_down_on_ctrl_c(graph: Graph, tmp_path: Path) -> None:
    up = graph.start("up", "duration:=0", f"record:={tmp_path / 'bag'}", "observers:=none")
    up.wait_for("[plant]: running")
    sleep(1.0)
    assert up.stop() == 0, up.text
    assert "Traceback" not in up.text
    assert "[er up] SIGINT came: everything is stopped" in up.text
    assert messages(tmp_path / "bag") > 200


def test_a_killed_up_leaves_a_closed_recording(graph: Graph, tmp_path: Path) -> None:
    up = graph.start("up", "duration:=0", f"record:={tmp_path / 'bag'}", "observers:=none")
    up.wait_for("[plant]: running")
    sleep(1.0)
    up.stop(signal.SIGKILL)
    until = monotonic() + 30.0
    while not (tmp_path / "bag/metadata.yaml").exists():
        assert monotonic() < until, up.text
        sleep(0.05)
    assert messages(tmp_path / "bag") > 100


def test_the_plant_is_safe_without_its_controller_recovers_and_refuses_a_second_one(
    graph: Graph,
) -> None:
    controller = NODES["skyhook_controller"]
    plant = graph.start("plant", *NODES["plant"], "-p", "duty_source:=topic")
    plant.wait_for("safe duty: no command yet")
    first = graph.start("skyhook_controller", *controller)
    plant.wait_for("[plant]: running")
    first.stop(signal.SIGKILL)
    plant.wait_for("safe duty: the last command is too old")
    seen = plant.text.count("running")
    graph.start("skyhook_controller", *controller)
    until = monotonic() + 30.0
    while plant.text.count("running") <= seen:
        assert monotonic() < until, plant.text
        sleep(0.05)
    graph.start("skyhook_controller", *controller, "-r", "__node:=intruder")
    plant.wait_for("safe duty: two publishers command the duty")
    assert plant.stop() == 0
