"""Where things are in the checkout, and which ROS 2 is used."""

from __future__ import annotations

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from xml.etree import ElementTree


class Stop(Exception):
    """Ends ``./er`` with one line on stderr and an exit status."""

    def __init__(self, line: str, status: int = 2) -> None:
        super().__init__(line)
        self.status = status


@dataclass(frozen=True)
class Layout:
    """Folders of one checkout; ``ros`` is the prefix of an installed ROS 2, or None."""

    root: Path
    ros: Path | None

    @property
    def venv(self) -> Path:
        """Python environment."""
        return self.root / ".venv"

    @property
    def python(self) -> Path:
        """Interpreter of the environment."""
        return self.venv / "bin" / "python"

    @property
    def install(self) -> Path:
        """What colcon installs into."""
        return self.root / "install"

    @property
    def build(self) -> Path:
        """What colcon builds in."""
        return self.root / "build"

    @property
    def log(self) -> Path:
        """Log of the set-up, rewritten by each set-up that has something to do."""
        return self.root / "log" / "setup.log"

    def requirements(self) -> list[Path]:
        """Requirement files that make up the environment; each pin is in one of them."""
        folder = self.root / "requirements"
        wheels = [] if self.ros else [folder / "jazzy.txt"]
        return [*wheels, folder / "lock.txt"]

    def packages(self) -> dict[str, Path]:
        """Name and folder of every package below src."""
        found = {}
        for manifest in sorted((self.root / "src").glob("*/package.xml")):
            name = ElementTree.parse(manifest).findtext("name")
            if not name:
                raise Stop(f"{manifest}: expected a <name>, found none")
            found[name.strip()] = manifest.parent
        return found


def find_layout(root: Path, environ: Mapping[str, str]) -> Layout:
    """Layout of the checkout; ``ER_ROS_PREFIX`` says where to look for an installed ROS 2."""
    prefix = Path(environ.get("ER_ROS_PREFIX") or "/opt/ros/jazzy")
    return Layout(root, prefix if (prefix / "setup.bash").is_file() else None)


def work_root() -> Path:
    """Root of the checkout this file belongs to, as an absolute path without symbolic links."""
    return Path(os.path.realpath(__file__)).parents[2]
