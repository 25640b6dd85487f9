"""Versions of what made a recording."""

from __future__ import annotations

import os
import platform
import subprocess
from functools import cache
from importlib.metadata import PackageNotFoundError, version
from pathlib import Path

PACKAGES = (
    "er_models",
    "er_plant_sim",
    "er_observers",
    "er_ftc_controller",
    "er_records",
    "er_model_lab",
    "rosbags",
    "numpy",
)


def versions() -> dict[str, str]:
    """Versions by name: packages, Python, ROS 2, and the commit of the source, if any."""
    found = {"python": platform.python_version(), "ros": os.environ.get("ROS_DISTRO", "unknown")}
    for name in PACKAGES:
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "not installed"
    commit = _commit()
    return found | ({"commit": commit} if commit else {})


@cache
def _commit() -> str:
    """Commit of this checkout, with a + where files were changed; empty elsewhere."""
    here = Path(os.path.realpath(__file__)).parent
    ask = [
        "git",
        "-C",
        str(here),
        "describe",
        "--always",
        "--abbrev=12",
        "--dirty=+",
        "--exclude=*",
    ]
    try:
        done = subprocess.run(ask, capture_output=True, text=True, timeout=5.0, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return ""
    return done.stdout.strip() if done.returncode == 0 else ""
