"""Log files of ROS: a program starts also where there is no home to write to."""

from __future__ import annotations

import os
import subprocess
import sys
from pathlib import Path

import pytest
from er_models.errors import InputError
from er_ros_common.log_place import settle

INIT = """
from er_ros_common import log_place
log_place.settle()
import rclpy
rclpy.init()
rclpy.create_node("quiet").get_logger().info("here")
"""


@pytest.mark.parametrize("home", [None, "", "/nonexistent/home", "/proc"])
def test_without_a_home_there_is_another_place(home: str | None, tmp_path: Path) -> None:
    env = {k: v for k, v in os.environ.items() if k not in ("HOME", "ROS_LOG_DIR", "ROS_HOME")}
    env |= {"TMPDIR": str(tmp_path), "ROS_AUTOMATIC_DISCOVERY_RANGE": "LOCALHOST"}
    if home is not None:
        env["HOME"] = home
    done = subprocess.run(
        [sys.executable, "-c", INIT], env=env, capture_output=True, text=True, check=False
    )
    assert done.returncode == 0, done.stderr
    assert "here" in done.stderr
    assert any(tmp_path.rglob("*.log"))
    (folder,) = tmp_path.iterdir()
    assert folder.stat().st_mode & 0o077 == 0


def test_nobody_can_foretell_the_other_place(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
    found = []
    for _ in range(2):
        settle(env := {"HOME": "/proc"})
        found.append(env["ROS_LOG_DIR"])
    assert len({*found}) == 2


def test_a_home_that_can_be_written_is_left_as_it_is(tmp_path: Path) -> None:
    env = {"HOME": str(tmp_path)}
    settle(env)
    assert env == {"HOME": str(tmp_path)}


@pytest.mark.parametrize("name", ["ROS_LOG_DIR", "ROS_HOME"])
def test_a_place_that_was_asked_for_is_used_or_named(name: str, tmp_path: Path) -> None:
    settle(env := {name: str(tmp_path / "mine")})
    assert env == {name: str(tmp_path / "mine")}
    with pytest.raises(InputError, match=f"{name}: expected a folder that can be written, found"):
        settle({name: "/proc/nope"})
