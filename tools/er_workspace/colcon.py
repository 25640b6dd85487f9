"""The build of the workspace with colcon, and how to tell that it is current."""

from __future__ import annotations

import hashlib
import os
import shutil
from pathlib import Path

from er_workspace import environment, scripts, venv
from er_workspace.layout import Layout, Stop
from er_workspace.process import run_logged, step

STAMP = ".er-stamp"
FOUNDATION = ".er-foundation"
PACKAGING = (
    "package.xml",
    "setup.py",
    "setup.cfg",
    "pyproject.toml",
    "CMakeLists.txt",
    "*/programs.py",
    "action/*.action",
    "msg/*.msg",
    "srv/*.srv",
)
INSTALLED = ("resource/*", "launch/*", "config/**/*")


def current(layout: Layout) -> bool:
    """Whether the build matches the packaging, the messages and the environment, and its programs can be started."""
    stamp = layout.install / STAMP
    if not stamp.is_file() or not (layout.install / environment.FILE).is_file():
        return False
    if stamp.read_text(encoding="utf-8") != _foundation(layout) + _content(layout):
        return False
    share = (layout.install / name / "share" / name for name in layout.packages())
    if not all((folder / "package.xml").is_file() for folder in share):
        return False
    return not scripts.unstartable(layout)


def build(layout: Layout, lock: int) -> None:
    """Build what changed; start clean after an interrupted build or with another environment."""
    foundation, content = _foundation(layout), _content(layout)
    mark = layout.build / FOUNDATION
    if not mark.is_file() or mark.read_text(encoding="utf-8") != foundation:
        shutil.rmtree(layout.build, ignore_errors=True)
        shutil.rmtree(layout.install, ignore_errors=True)
    shutil.rmtree(layout.log.parent / "colcon", ignore_errors=True)
    _drop_removed(layout)
    layout.build.mkdir(exist_ok=True)
    mark.unlink(missing_ok=True)
    (layout.install / STAMP).unlink(missing_ok=True)
    with step(f"building {len(layout.packages())} packages"):
        env = _tools(environment.base_environment(layout))
        try:
            run_logged(_command(layout), layout.log, env, lock, "the build failed")
        except Stop:
            # a mistake in a source file: what was built stays good, unlike after an interruption
            mark.write_text(foundation, encoding="utf-8")
            raise
        scripts.mend(layout)
        environment.record(layout)
    mark.write_text(foundation, encoding="utf-8")
    (layout.install / STAMP).write_text(foundation + content, encoding="utf-8")


def _tools(env: dict[str, str]) -> dict[str, str]:
    """Environment with Ninja on every core.

    Left to itself colcon also bounds the machine's load by the number of cores: what the set-up ran until now counts,
    and Ninja then goes on with one job at a time.
    """
    jobs = env.get("MAKEFLAGS") or f"-j{os.cpu_count() or 1}"
    return env | {"CMAKE_GENERATOR": "Ninja", "MAKEFLAGS": jobs}


def _command(layout: Layout) -> list[str | Path]:
    colcon: list[str | Path] = [layout.python, layout.venv / "bin" / "colcon"]
    colcon += ["--log-base", layout.log.parent / "colcon", "build", "--symlink-install"]
    colcon += ["--base-paths", layout.root / "src"]
    colcon += ["--build-base", layout.build, "--install-base", layout.install]
    colcon += ["--parallel-workers", "2"]
    colcon += ["--event-handlers", "console_cohesion+", "parallel_status-"]
    # the code of messages copies a few numbers: -O3 takes 1.4 times as long to build, and as long to run
    colcon += ["--cmake-args", "-DCMAKE_BUILD_TYPE=Release", "-DBUILD_TESTING=OFF"]
    colcon += [f"-DCMAKE_{language}_FLAGS_RELEASE=-O1 -DNDEBUG" for language in ("C", "CXX")]
    return [*colcon, f"-DPython3_EXECUTABLE={layout.python}"]


def _foundation(layout: Layout) -> str:
    """What makes a whole build void when it changes: the environment and the place."""
    return f"{venv.read_state(layout).get('identity')} {layout.root} {layout.ros}\n"


def _content(layout: Layout) -> str:
    """Hash of every file whose change needs a build; names alone of files installed as links."""
    digest = hashlib.sha256()
    for package in layout.packages().values():
        for pattern in PACKAGING:
            for path in sorted(package.glob(pattern)):
                digest.update(f"{path.relative_to(layout.root)}\n".encode() + path.read_bytes())
        for pattern in INSTALLED:
            for path in sorted(package.glob(pattern)):
                digest.update(f"{path.relative_to(layout.root)}\n".encode())
    return digest.hexdigest() + "\n"


def _drop_removed(layout: Layout) -> None:
    """Forget packages that are no longer in the sources, or they would still be found."""
    names = set(layout.packages())
    for folder in (layout.build, layout.install):
        for path in folder.glob("er_*") if folder.is_dir() else ():
            if path.is_dir() and path.name not in names:
                shutil.rmtree(path)
