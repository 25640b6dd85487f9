"""A rig behind a real wire, a pseudo terminal or UDP, gives the graph what the plant gives it."""

from __future__ import annotations

import signal
import socket
from pathlib import Path
from time import sleep
from typing import Any

import numpy as np
import pytest

pytest.importorskip("rclpy")

from rosbags.highlevel import AnyReader

from er_common import topics
from test.graph_help import CONFIG, Graph, emulator_arguments, own_domain

pytestmark = pytest.mark.alone

PUBLISHED = (
    topics.ACCELERATION, topics.DEFLECTION, topics.FORCE, topics.ROAD, topics.PWM_APPLIED
)  # fmt: skip
SAFE_DUTY = 0.1
"""That of config/nodes/hardware_bridge.yaml."""
PLAIN = "who can send to it can move the damper"
"""What both ends of a wire without authentication say of it."""
WIRE = ("--drift", "5e-5", "--jitter", "0.0003")


def read(bag: Path) -> dict[str, list[Any]]:
    """Messages of a recording by topic."""
    found: dict[str, list[Any]] = {}
    with AnyReader([bag]) as reader:
        for connection, _, data in reader.messages():
            message = reader.deserialize(data, connection.msgtype)
            found.setdefault(connection.topic, []).append(message)
    return found


def stamps(messages: list[Any]) -> np.ndarray:
    """Times of measurement [ns]."""
    return np.array([m.header.stamp.sec * 10**9 + m.header.stamp.nanosec for m in messages])


def hardware(link: str, bag: Path, *more: str) -> list[str]:
    """Arguments of `er up` for the emulator."""
    calibration = f"calibration:={CONFIG / 'hardware/device_emulator.yaml'}"
    return [f"hardware:={link}", calibration, "observers:=none", f"record:={bag}", *more]


def test_a_program_runs_over_a_serial_port(tmp_path: Path) -> None:
    bag, port = tmp_path / "bag", tmp_path / "port"
    with own_domain() as env, Graph(env, tmp_path) as graph:
        device = graph.start("device_emulator", *emulator_arguments(f"pty:{port}", *WIRE))
        device.wait_for("200 Hz")
        more = ("road:=program", "program:=bumps", "duration:=3", "seed:=4")
        status, text = graph.run("up", *hardware(f"serial:{port}", bag, *more), seconds=90.0)
        assert device.stop() == 0
        assert not port.is_symlink()
    assert status == 0, text
    assert "Traceback" not in text + device.text
    assert text.count(PLAIN) == device.text.count(PLAIN) == 1
    found = read(bag)
    for topic in PUBLISHED:
        each = found[f"/{topic.name}"]
        assert len(each) > 0.95 * 600
        good = [m for m in each if m.valid and m.status == m.STATUS_OK]
        if topic is topics.PWM_APPLIED:
            # a controller that a busy machine holds up for longer than 45 ms: safe duty until it is back, and said so
            ill = [m for m in each if m.status != m.STATUS_OK]
            for m in ill:
                safe = m.source == m.SOURCE_SAFE and m.duty == pytest.approx(SAFE_DUTY)
                # of a device that was held up for longer than 50 ms nothing is stated
                assert safe if m.valid else (m.status, m.duty) == (m.STATUS_LOST, 0.0)
        assert len(good) > (0.5 if topic is topics.PWM_APPLIED else 0.95) * 600
        steps = np.diff(stamps(good)) / np.diff([m.seq for m in good])
        assert np.median(steps) == pytest.approx(5e6, rel=1e-3)
    from er_models.files import load_model
    from er_models.program import load_program, resolve

    program = load_program(CONFIG / "experiments/bumps.yaml")
    model = load_model(CONFIG / "vehicles/inove_quarter_car.yaml")
    road, _ = resolve(program, model, 0.005).signals(0.005 * np.arange(700.0))
    followed = [m for m in found["/sensors/road"] if m.valid and m.seq > 20]

    def late(m: Any) -> int:
        """How many samples after it was due the height was reached; a busy machine is late."""
        (same,) = np.nonzero(np.abs(road[m.seq :: -1] - m.displacement) < 1.1e-6)
        return int(same[0]) if same.size else 1000

    lateness = {m.seq: late(m) for m in followed}
    assert np.mean(np.array(list(lateness.values())) < 40) > 0.9
    answered = {m.seq: m.seq - m.command_seq for m in found["/pwm/applied"] if m.command_seq}
    assert min(answered.values()) == 1
    # a height travels with a duty: where the answer to the sample before came in time, so did the height
    timely = [seq for seq in lateness if answered.get(seq) == 1]
    assert len(timely) >= 5
    assert {lateness[seq] for seq in timely} == {0}


@pytest.mark.slow
def test_a_device_over_udp_may_die_and_come_back(tmp_path: Path) -> None:
    with socket.socket(socket.AF_INET, socket.SOCK_DGRAM) as free:
        free.bind(("127.0.0.1", 0))
        link = f"udp:127.0.0.1:{free.getsockname()[1]}"
    bag = tmp_path / "bag"
    home = {"XDG_CONFIG_HOME": str(tmp_path)}
    with own_domain() as env, Graph(env | home, tmp_path) as graph:
        device = graph.start("device_emulator", *emulator_arguments(link, *WIRE, "--loss", "0.01"))
        device.wait_for("200 Hz")
        up = graph.start("up", *hardware(link, bag, "duration:=0"))
        up.wait_for("[hardware_bridge]: running")
        sleep(1.5)
        device.stop(signal.SIGKILL)
        up.wait_for("[hardware_bridge]: silent: no sample")
        graph.start("device_emulator", *emulator_arguments(link)).wait_for("200 Hz")
        sleep(2.5)
        assert up.stop() == 0, up.text
    assert "Traceback" not in up.text
    # both sides found the same key, which the first of them made
    assert f"made the key {tmp_path / 'er' / 'wire.key'}" in device.text + up.text
    assert PLAIN not in device.text + up.text
    found = read(bag)
    for topic in PUBLISHED:
        each = found[f"/{topic.name}"]
        gone = [i for i, m in enumerate(each) if m.status == m.STATUS_LOST]
        assert gone, topic.name
        after = [m for m in each[gone[0] :] if m.valid and m.status == m.STATUS_OK]
        assert len(after) > 200
        assert [m.seq for m in after] == sorted({m.seq for m in after})
        assert (np.diff(stamps(each)) > 0).all()
    # in between the controller knew, and said so
    assert any(m.source == m.SOURCE_SAFE for m in found["/pwm/command"])
