"""What messages between processes travel by: UDP, as the settings of the nodes have it, or Fast DDS's shared memory."""

from __future__ import annotations

import os
import re
from pathlib import Path

from er_ros_common.dds import FILE, VARIABLE

UDP, SHARED = "udp", "shm"
TRANSPORTS = (UDP, SHARED)
LOCATORS = re.compile(r"<(defaultUnicastLocatorList)>.*?</\1>", re.S)


def settings(transport: str, folder: Path) -> Path:
    """The middleware's settings for a transport: those of the nodes, or a copy in a folder that leaves the choice open.

    Fast DDS takes shared memory within a machine where nothing is said of locators.
    """
    if transport == UDP:
        return FILE
    path = folder / "shared.xml"
    path.write_text(LOCATORS.sub("", FILE.read_text(encoding="utf-8")), encoding="utf-8")
    return path


def take(transport: str, folder: Path) -> None:
    """Have the processes that are started from now on use a transport."""
    os.environ[VARIABLE] = str(settings(transport, folder))
