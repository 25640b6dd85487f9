"""Where ROS writes its log files: in the home folder, which a service or a container may not have.

Without a place for them no node starts. Who has said nothing about the place gets a fresh one among the temporary
files, for this user alone; programs that are started from here write there, too.
"""

from __future__ import annotations

import os
import tempfile
from collections.abc import MutableMapping
from pathlib import Path

from er_models.errors import InputError

SAID = (("ROS_LOG_DIR", ""), ("ROS_HOME", "log"))
"""What ROS asks first, and the folder below it."""


def settle(env: MutableMapping[str, str] = os.environ) -> None:
    """Have ROS log to a folder that can be written; before anything of ROS is made.

    Raises:
        InputError: The user named a place, and nothing can be written there.
    """
    for name, below in SAID:
        if place := env.get(name):
            if not _writable(Path(place).expanduser() / below):
                raise InputError(name, "", "a folder that can be written", place)
            return
    home = env.get("HOME")
    if not home or not Path(home).is_dir() or not _writable(Path(home) / ".ros" / "log"):
        env["ROS_LOG_DIR"] = tempfile.mkdtemp(prefix="ros_log_")


def _writable(folder: Path) -> bool:
    try:
        folder.mkdir(parents=True, exist_ok=True)
    except OSError:
        return False
    return os.access(folder, os.W_OK | os.X_OK)
