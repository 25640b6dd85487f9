"""Settings of the middleware: ours, unless the user has others."""

import subprocess
import sys
from pathlib import Path
from xml.etree import ElementTree

from er_ros_common import dds


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
