"""What must be on the machine before the set-up; one line for the first thing missing."""

from __future__ import annotations

import os
import platform
import shutil
import sys
import sysconfig
from pathlib import Path

from er_workspace.layout import Layout, Stop

TOOLS = {"git": "git", "g++": "g++"}


def check() -> None:
    """Raise Stop naming the Debian/Ubuntu package of the first missing tool."""
    for tool, package in TOOLS.items():
        if shutil.which(tool) is None:
            raise Stop(f"{tool} is missing; install it: sudo apt install {package}")
    version = ".".join(platform.python_version_tuple()[:2])
    try:
        import ensurepip  # noqa: F401  (Debian ships it apart from Python)
        import venv  # noqa: F401
    except ImportError:
        line = f"{sys.executable} cannot make environments (ensurepip or venv is missing)"
        raise Stop(
            f"{line}; install it: sudo apt install python3-venv (or python{version}-venv)"
        ) from None
    headers = Path(sysconfig.get_path("include"))
    if not (headers / "Python.h").is_file():
        line = f"{headers / 'Python.h'} is missing"
        raise Stop(f"{line}; install it: sudo apt install python3-dev (or python{version}-dev)")


def use_ros_python(layout: Layout) -> None:
    """Start over on the Python an installed ROS 2 was built for, where that is another one."""
    if layout.ros is None:
        return
    versions = sorted(p.name for p in (layout.ros / "lib").glob("python3.*") if p.is_dir())
    wanted = f"/usr/bin/{versions[-1]}" if versions else sys.executable
    if os.path.realpath(wanted) == os.path.realpath(sys.executable):
        return
    if not os.access(wanted, os.X_OK):
        raise Stop(f"{layout.ros} was built for {wanted}, which is not there")
    os.execv(wanted, [wanted, "-I", "-B", *sys.argv])
