"""Settings of the middleware: ours, unless the user has others."""

import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

import pytest

from er_ros_common import dds
from test.graph_help import own_domain


def test_the_users_own_settings_win(tmp_path: Path) -> None:
    for env in ({dds.VARIABLE: "mine.xml"}, {}):
        given = dict(env)
        (tmp_path / dds.OWN).write_text("")
        dds.settle(given, tmp_path)
        assert given == env
    (tmp_path / dds.OWN).unlink()
    given = {}
    dds.settle(given, tmp_path)
    file = Path(given[dds.VARIABLE])
    (period,) = ElementTree.parse(file).findall(".//{*}heartbeatPeriod")
    assert [(part.tag.rpartition("}")[2], part.text) for part in period] == [
        ("nanosec", "100000000")
    ]
    (deaf,) = ElementTree.parse(file).findall(".//{*}nackSupressionDuration")
    assert [part.text for part in deaf] == ["20000000"]


LISTENING = """
from er_ros_common import dds
dds.settle()
import time
import rclpy
from pathlib import Path
rclpy.init()
node = rclpy.create_node("listening")
time.sleep(0.5)  # a thread gives itself its name
print(*sorted(path.read_text().strip() for path in Path("/proc/self/task").glob("*/comm")))
"""
"""The threads of a node; those of Fast DDS that listen are named after transport and port."""


def test_nobody_listens_at_shared_memory() -> None:
    command = [sys.executable, "-c", LISTENING]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    transports = {name.split(".")[1] for name in done.stdout.split() if name[-1:].isdigit()}
    assert "udp" in transports
    assert "shm" not in transports


TALK = """
from er_ros_common import dds
dds.settle()
import sys, time
import rclpy
from pathlib import Path
from rclpy.qos import QoSProfile
from std_msgs.msg import String

def waits():
    threads = [p for p in Path("/proc/self/task").iterdir() if p.joinpath("comm").read_text().startswith("dds.ev")]
    words = [line for p in threads for line in p.joinpath("status").read_text().splitlines()]
    return sum(int(line.split()[1]) for line in words if line.startswith("voluntary"))

rclpy.init()
node = rclpy.create_node(sys.argv[1])
topics = [f"talk_{i}" for i in range(4)]
if sys.argv[1] == "listener":
    ends = [node.create_subscription(String, t, lambda m: None, QoSProfile(depth=10)) for t in topics]
    rclpy.spin(node)
ends = [node.create_publisher(String, t, QoSProfile(depth=10)) for t in topics]
while not all(end.get_subscription_count() for end in ends):
    time.sleep(0.05)
time.sleep(1.0)  # greetings are over
before, begin = waits(), time.monotonic()
for _ in range(200):
    for end in ends:
        end.publish(String(data="a"))
    time.sleep(0.005)
print((waits() - before) / (time.monotonic() - begin))
"""
"""A talker (200 messages at four topics) says how often a second its thread of timers fell asleep; a listener."""


def wakes(settings: Path) -> float:
    """How often a second the timers' thread wakes of a talker with these settings."""
    with own_domain() as domain:
        env = {**domain, dds.VARIABLE: str(settings)}
        command = [sys.executable, "-c", TALK]
        listener = subprocess.Popen([*command, "listener"], env=env)
        try:
            done = subprocess.run(
                [*command, "talker"],
                capture_output=True,
                text=True,
                check=True,
                env=env,
                timeout=60,
            )
        finally:
            listener.kill()
            listener.wait()
    return float(done.stdout)


@pytest.mark.slow
def test_a_message_wakes_no_timer(tmp_path: Path) -> None:
    """Where lacks are not ignored for a while, the thread of the timers wakes for nearly every one of 800 messages."""
    text = dds.FILE.read_text(encoding="utf-8")
    assert text.count("<nanosec>20000000</nanosec>") == 1
    plain = tmp_path / "plain.xml"
    plain.write_text(text.replace("<nanosec>20000000</nanosec>", "<nanosec>0</nanosec>"))
    ours, theirs = zip(*((wakes(dds.FILE), wakes(plain)) for _ in range(3)), strict=True)
    assert sum(ours) < 0.75 * sum(theirs), (ours, theirs)
