"""The Python environment ``.venv``: made from pinned requirements, made anew when broken."""

from __future__ import annotations

import hashlib
import json
import os
import platform
import re
import shutil
import subprocess
import sys
import uuid
from pathlib import Path
from typing import Any

from er_workspace.layout import Layout
from er_workspace.process import run_logged, run_together, step
from er_workspace.wheels import repair_exports

STATE = "er-state.json"
PARTS = 2
"""Files of pins are installed in so many parts at once."""
PROBE = "import sys; print('%d.%d' % sys.version_info[:2])"


def read_state(layout: Layout) -> dict[str, Any]:
    """What the last complete set-up wrote into the environment; empty when there was none."""
    try:
        state = json.loads((layout.venv / STATE).read_text(encoding="utf-8"))
    except (OSError, ValueError):
        return {}
    return state if isinstance(state, dict) else {}


def requirements_hash(layout: Layout) -> str:
    """Hash of the requirement files that apply."""
    digest = hashlib.sha256()
    for path in layout.requirements():
        digest.update(path.read_bytes())
    return digest.hexdigest()


def broken(layout: Layout) -> str:
    """Why the environment must be made anew; empty when it need not."""
    state = read_state(layout)
    if not layout.venv.exists():
        return "there is none"
    if not state:
        return "it was not finished"
    if state.get("root") != str(layout.root):
        return "the checkout was moved"
    if state.get("ros") != str(layout.ros):
        return "another ROS 2 is used"
    if _version(layout) != state.get("python"):
        return "its Python is gone or another one"
    missing = sorted(set(state.get("inventory", ["?"])) - set(_inventory(layout)))
    return f"{missing[0]} is gone" if missing else ""


def outdated(layout: Layout) -> bool:
    """Whether a healthy environment lacks a changed requirement."""
    return read_state(layout).get("requirements") != requirements_hash(layout)


def make(layout: Layout, lock: int, *, clean: bool) -> None:
    """Make the environment, or bring a healthy one up to date."""
    reason = "as asked" if clean else broken(layout)
    if reason:
        with step(f"making .venv ({reason}), Python {platform.python_version()}"):
            _create(layout, lock)
    identity = (
        str(uuid.uuid4()) if reason else read_state(layout).get("identity", str(uuid.uuid4()))
    )
    (layout.venv / STATE).unlink(missing_ok=True)
    kinds = {"jazzy.txt": "ROS 2 Jazzy wheels", "lock.txt": "Python packages"}
    counts = [f"{_count(path)} {kinds[path.name]}" for path in layout.requirements()]
    with step(f"installing {' and '.join(counts)}"):
        _install(layout, lock)
    if layout.ros is None:
        repair_exports(layout)
    _write_state(layout, identity)


def setup_environment() -> dict[str, str]:
    """Environment of the set-up's own programs: nothing of another Python or ROS 2 leaks in."""
    foreign = ("PYTHON", "AMENT_", "COLCON_", "CMAKE_", "ROS_", "RMW_", "_ROS_")
    kept = {k: v for k, v in os.environ.items() if not k.startswith(foreign)}
    for name in ("LD_LIBRARY_PATH", "VIRTUAL_ENV", "PIP_USER", "PIP_TARGET", "PIP_PREFIX"):
        kept.pop(name, None)
    return kept


def _create(layout: Layout, lock: int) -> None:
    shutil.rmtree(layout.venv, ignore_errors=True)
    shared = ["--system-site-packages"] if layout.ros else []
    # not sys.executable: ./er may have been started with this very environment activated
    base = getattr(sys, "_base_executable", sys.executable)
    command: list[str | Path] = [base, "-m", "venv", *shared, layout.venv]
    run_logged(command, layout.log, setup_environment(), lock, "making .venv failed")
    (layout.venv / "COLCON_IGNORE").touch()


def _install(layout: Layout, lock: int) -> None:
    """Install all that is required, side by side: each pin stands once, and pip takes them one after the other."""
    pip: list[str | Path] = [
        layout.python,
        "-m",
        "pip",
        "--disable-pip-version-check",
        "--no-input",
        "install",
        "--no-deps",
        "--no-compile",
    ]
    env = setup_environment()
    # as URI: pip splits at spaces
    env["PIP_BUILD_CONSTRAINT"] = _pins(layout, "build-pins.txt", "setuptools", "wheel").as_uri()
    # the one that Python brings takes three times as long to read an index
    newer = _pins(layout, "pip.txt", "pip")
    if newer.stat().st_size:
        run_logged([*pip, "-r", newer], layout.log, env, lock, "installing pip failed")
    jobs = [
        ([*pip, "-r", part], f"installing {path.name} failed")
        for path in layout.requirements()
        for part in _parts(layout, path)
    ]
    run_together(jobs, layout.log, env, lock)


def _parts(layout: Layout, requirements: Path) -> list[Path]:
    """A file of pins as files in .venv that share its lines."""
    made = []
    for number, lines in enumerate(parted(requirements.read_text(encoding="utf-8")), start=1):
        part = layout.venv / f"{requirements.stem}-{number}.txt"
        part.write_text("\n".join(lines) + "\n", encoding="utf-8")
        made.append(part)
    return made


def parted(pins: str) -> list[list[str]]:
    """Lines of a file of pins in up to `PARTS` parts, about as large as each other.

    Names that begin alike stay together, as one pip puts them in order: lark and lark-parser bring the same files.
    """
    families: dict[str, list[str]] = {}
    for line in filter(_pin, pins.splitlines()):
        families.setdefault(re.split(r"[-_=]", line)[0], []).append(line)
    each = list(families.values())
    found = [[line for family in each[k::PARTS] for line in family] for k in range(PARTS)]
    return [part for part in found if part]


def _pin(line: str) -> bool:
    return bool(line.strip()) and not line.startswith("#")


def _pins(layout: Layout, name: str, *wanted: str) -> Path:
    """The lock's pins of some packages as a file in .venv, for isolated builds to keep to, or to install first."""
    lines = (layout.root / "requirements" / "lock.txt").read_text(encoding="utf-8").splitlines()
    pins = layout.venv / name
    used = [f"{line}\n" for line in lines if line.startswith(tuple(f"{n}==" for n in wanted))]
    pins.write_text("".join(used), encoding="utf-8")
    return pins


def _count(requirements: Path) -> int:
    lines = requirements.read_text(encoding="utf-8").splitlines()
    old = sys.version_info < (3, 11)
    other = 'python_version >= "3.11"' if old else 'python_version < "3.11"'
    return sum(1 for line in lines if _pin(line) and other not in line)


def _version(layout: Layout) -> str:
    # -S: without the environment's start-up hooks, which take ten times as long
    command: list[str | Path] = [layout.python, "-I", "-S", "-c", PROBE]
    try:
        done = subprocess.run(command, capture_output=True, text=True, timeout=20, check=False)
    except (OSError, subprocess.TimeoutExpired):
        return ""
    return done.stdout.strip()


def _inventory(layout: Layout) -> list[str]:
    """The two upper levels of site-packages: what a damaged environment lacks."""
    names = []
    for site in sorted((layout.venv / "lib").glob("python3.*/site-packages")):
        for top in os.scandir(site):
            if top.name == "__pycache__":
                continue
            names.append(top.name)
            if top.is_dir(follow_symlinks=False):
                inner = (e.name for e in os.scandir(top.path) if e.name != "__pycache__")
                names.extend(f"{top.name}/{name}" for name in inner)
    return sorted(names)


def _write_state(layout: Layout, identity: str) -> None:
    state = {
        "identity": identity,
        "root": str(layout.root),
        "ros": str(layout.ros),
        "python": _version(layout),
        "requirements": requirements_hash(layout),
        "inventory": _inventory(layout),
    }
    path = layout.venv / STATE
    partial = path.with_suffix(".tmp")
    partial.write_text(json.dumps(state), encoding="utf-8")
    partial.replace(path)
