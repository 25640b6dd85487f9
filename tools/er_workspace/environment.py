"""The environment commands run in: computed once after a build, applied to every command."""

from __future__ import annotations

import json
import os
import subprocess
import sys
from collections.abc import Mapping
from pathlib import Path

from er_workspace.layout import Layout, Stop
from er_workspace.venv import setup_environment

FILE = ".er-environment.json"
BYTECODE = "bytecode"
"""Folder in .venv where Python keeps what it compiled."""
PATHS = ("PATH", "PYTHONPATH", "LD_LIBRARY_PATH", "AMENT_PREFIX_PATH", "CMAKE_PREFIX_PATH")


def base_environment(layout: Layout) -> dict[str, str]:
    """Environment to build in: the .venv in front, the ROS 2 of its wheels or of the prefix."""
    env = setup_environment()
    env["VIRTUAL_ENV"] = str(layout.venv)
    env["PATH"] = f"{layout.venv / 'bin'}{os.pathsep}{env.get('PATH', os.defpath)}"
    if layout.ros is not None:
        return _sourced(layout.ros / "setup.bash", env)
    libraries = [
        layout.venv / "lib",
        *sorted((layout.venv / "lib").glob("python3.*/site-packages/ros_*.libs")),
    ]
    env["LD_LIBRARY_PATH"] = os.pathsep.join(map(str, libraries))
    # the wheels would set LD_LIBRARY_PATH themselves and start the interpreter a second time
    env["_ROS_WHEELS_BOOTSTRAP_COMPLETE"] = "1"
    env["AMENT_PREFIX_PATH"] = env["CMAKE_PREFIX_PATH"] = str(layout.venv)
    env["ROS_DISTRO"], env["ROS_VERSION"], env["ROS_PYTHON_VERSION"] = "jazzy", "2", "3"
    return env


def record(layout: Layout) -> None:
    """Source the built workspace once and keep what it set.

    Raises:
        Stop: the workspace's set-up script fails, or forgets a package.
    """
    script = layout.install / "local_setup.bash"
    # colcon's script does not quote the interpreter, and ours lies below the checkout's name
    before = base_environment(layout) | {"COLCON_PYTHON_EXECUTABLE": sys.executable}
    after = _sourced(script, before)
    found = after.get("AMENT_PREFIX_PATH", "").split(os.pathsep)
    missing = [n for n in layout.packages() if str(layout.install / n) not in found]
    if missing:
        raise Stop(f"{script} does not set up {missing[0]}; a folder name it cannot cope with?")
    kept = {k: v for k, v in after.items() if k in PATHS or setup_environment().get(k) != v}
    for name in ("PWD", "OLDPWD", "SHLVL", "_", "COLCON_PYTHON_EXECUTABLE"):
        kept.pop(name, None)
    tail = setup_environment().get("PATH", os.defpath)
    kept["PATH"] = kept["PATH"].removesuffix(tail).rstrip(os.pathsep)
    (layout.install / FILE).write_text(json.dumps(kept, indent=1), encoding="utf-8")


def command_environment(layout: Layout, environ: Mapping[str, str]) -> dict[str, str]:
    """Environment of a command: the caller's, the workspace in front, other ROS 2 taken out."""
    kept = json.loads((layout.install / FILE).read_text(encoding="utf-8"))
    foreign = [p for p in environ.get("AMENT_PREFIX_PATH", "").split(os.pathsep) if p]
    env = {k: v for k, v in environ.items() if k not in ("PYTHONHOME", "VIRTUAL_ENV")}
    for name, value in kept.items():
        own = value.split(os.pathsep)
        theirs = [p for p in environ.get(name, "").split(os.pathsep) if p and p not in own]
        if name in ("AMENT_PREFIX_PATH", "CMAKE_PREFIX_PATH"):
            theirs = []
        elif name in ("PYTHONPATH", "LD_LIBRARY_PATH"):
            theirs = [p for p in theirs if not any(Path(p).is_relative_to(f) for f in foreign)]
        env[name] = os.pathsep.join([*own, *theirs]) if name in PATHS else value
    if layout.ros is None:
        # the wheels bring Fast DDS only
        env.pop("RMW_IMPLEMENTATION", None)
    env.setdefault("ROS_AUTOMATIC_DISCOVERY_RANGE", "LOCALHOST")
    # without compiled modules a node spends more than half of its start on compiling Numba's; whoever forbids
    # them means those beside the sources
    env.pop("PYTHONDONTWRITEBYTECODE", None)
    env.setdefault("PYTHONPYCACHEPREFIX", str(layout.venv / BYTECODE))
    return env


def _sourced(script: Path, env: Mapping[str, str]) -> dict[str, str]:
    """Environment after sourcing a bash script."""
    command = ["bash", "-c", 'source "$1" >/dev/null && env -0', "bash", str(script)]
    done = subprocess.run(command, capture_output=True, env=dict(env), check=False)
    if done.returncode != 0:
        last = done.stderr.decode(errors="replace").strip().splitlines()[-1:] or ["no message"]
        raise Stop(f"{script} failed: {last[0]}")
    pairs = (item.partition("=") for item in done.stdout.decode().split("\0") if item)
    return {name: value for name, _, value in pairs}
