"""The private names of rclpy: in one file, and there in the version that it was made for."""

from __future__ import annotations

import re
from pathlib import Path

import pytest

pytest.importorskip("rclpy")

from importlib.metadata import PackageNotFoundError, version

from rclpy.lifecycle import LifecycleNode
from rclpy.lifecycle.node import LifecycleNodeMixin

from er_ros_common import private

SOURCES = Path(__file__).resolve().parents[2]
PRIVATE = re.compile(
    r"rclpy\.(\w+\.)*_\w+|rclpy\.impl\b|\b(node|self)\._(parameter_overrides|state_machine)\b|_LifecycleNodeMixin"
)


def test_private_names_stand_in_one_file() -> None:
    files = [
        f
        for f in SOURCES.glob("er_*/er_*/**/*.py")
        if PRIVATE.search(f.read_text(encoding="utf-8"))
    ]
    assert [file.name for file in files] == ["private.py"]


def test_they_are_there_and_made_for_this_rclpy() -> None:
    assert callable(LifecycleNodeMixin._LifecycleNodeMixin__on_change_state)
    assert issubclass(private.SteadyLifecycleNode, LifecycleNode)
    try:
        found = version("rclpy")
    except PackageNotFoundError:
        found = version("ros-rclpy")
    words = f"rclpy {found}: look at every name of private.py, then set MADE_FOR"
    assert tuple(map(int, found.split(".")[:2])) == private.MADE_FOR, words
