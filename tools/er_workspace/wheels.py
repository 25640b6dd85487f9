"""Repairs of the ROS 2 wheels: their CMake files name folders of the build machine."""

from __future__ import annotations

import json
import re
import subprocess

from er_workspace.layout import Layout, Stop

PLACES = (
    "import json, sysconfig, numpy; "
    "print(json.dumps([sysconfig.get_path('include'), numpy.get_include()]))"
)
NUMPY = re.compile(r"/opt/python/[^/;\"\s]+/lib/python3\.\d+/site-packages/numpy/_core/include")
PYTHON = re.compile(r"/opt/python/[^/;\"\s]+/include/python3\.\d+")


def repair(text: str, python_include: str, numpy_include: str) -> str:
    """Text of a CMake file with this machine's include folders; a second time changes nothing."""
    text = NUMPY.sub(lambda _: numpy_include, text)
    return PYTHON.sub(lambda _: python_include, text)


def repair_exports(layout: Layout) -> int:
    """Repair every CMake file the wheels brought; returns how many changed."""
    env = {"PATH": "/usr/bin:/bin", "_ROS_WHEELS_BOOTSTRAP_COMPLETE": "1"}
    done = subprocess.run(
        [layout.python, "-c", PLACES], capture_output=True, text=True, env=env, check=False
    )
    if done.returncode != 0:
        raise Stop(f"numpy does not load in .venv: {done.stderr.strip().splitlines()[-1:]}")
    python_include, numpy_include = json.loads(done.stdout)
    changed = 0
    for path in (layout.venv / "share").rglob("*.cmake"):
        before = path.read_text(encoding="utf-8")
        after = repair(before, python_include, numpy_include)
        if after != before:
            path.write_text(after, encoding="utf-8")
            changed += 1
    return changed
