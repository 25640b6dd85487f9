"""The real `ros2` tools in tests: that of an apt ROS, of $ER_ROS2_TOOLS, or of sources beside the checkout.

The tools are pure Python and have no wheels. $ER_ROS2_TOOLS is the environment that holds them; else they are built
once, from the archive where there is one, into the cache.
"""

from __future__ import annotations

import hashlib
import os
import shutil
import subprocess
import sys
import tarfile
from collections.abc import Mapping
from importlib.util import find_spec
from pathlib import Path
from tempfile import TemporaryDirectory

from er_models.cache.folder import cache_folder

from test.graph_help import PROGRAMS, ROOT

SOURCES = ROOT.parent / "shared" / "ros2_tools" / "sources.tar.xz"
WANTED = (
    "osrf_pycommon",
    "launch",
    "launch_xml",
    "launch_yaml",
    "launch_ros",
    "ros2cli",
    "ros2pkg",
    "ros2launch",
    "ros2node",
    "ros2service",
    "ros2topic",
    "ros2param",
    "ros2lifecycle",
)
MISSING = "neither an apt ROS, nor $ER_ROS2_TOOLS, nor sources of ros2launch: no real launch can be tested"
COMMAND = "import sys; sys.path += {paths!r}; from ros2cli.cli import main; sys.exit(main())"
STAND_INS = {
    "composition_interfaces/__init__.py": "",
    "composition_interfaces/srv.py": """class LoadNode:
    Request = Response = None


ListNodes = UnloadNode = LoadNode
""",
    "rosidl_runtime_py/__init__.py": """
message_to_yaml = message_to_csv = message_to_ordereddict = set_message_fields = None
get_message_interfaces = get_service_interfaces = None
""",
    "rosidl_runtime_py/utilities.py": """from importlib import import_module


def get_message(name):
    package, kind, made = name.split("/")
    return getattr(import_module(f"{package}.{kind}"), made)


get_service = get_message
""",
}
"""What the tools import and no wheel holds; all that is used of it is the class of a name."""


def tools() -> list[str] | None:
    """Folders to be put on Python's path for the tools; None where there are none."""
    given = os.environ.get("ER_ROS2_TOOLS")
    if given:
        return [str(path) for path in Path(given).glob("lib/python3*/site-packages")]
    if find_spec("ros2launch"):
        return []
    return [str(_built())] if SOURCES.is_file() else None


def _built() -> Path:
    """The tools of the archive, built when they are first asked for."""
    recipe = repr((WANTED, STAND_INS)).encode()
    digest = hashlib.sha256(SOURCES.read_bytes() + recipe).hexdigest()[:12]
    place = cache_folder() / f"ros2_tools-{digest}-{sys.version_info[1]}"
    if not place.is_dir():
        with TemporaryDirectory(dir=cache_folder()) as folder:
            with tarfile.open(SOURCES) as archive:
                archive.extractall(folder, filter="data")
            made = Path(folder) / "made"
            command = [
                sys.executable,
                "-m",
                "pip",
                "-q",
                "install",
                "--no-deps",
                "--no-build-isolation",
                "--no-index",
            ]
            subprocess.run(
                [*command, "--target", made, *(Path(folder) / name for name in WANTED)], check=True
            )
            for name, text in STAND_INS.items():
                (made / name).parent.mkdir(exist_ok=True)
                (made / name).write_text(text)
            made.rename(place)
    return place


def prefix(folder: Path) -> Path:
    """What colcon would have installed, as far as launch looks for it: programs, launch files, configuration."""
    made = folder / "prefix"
    for package in {program.package for program in PROGRAMS.values()}:
        index = made / "share/ament_index/resource_index/packages"
        index.mkdir(parents=True, exist_ok=True)
        (index / package).touch()
    for program in PROGRAMS.values():
        script = made / "lib" / program.package / program.name
        script.parent.mkdir(parents=True, exist_ok=True)
        start = f"from {program.package}.executables import {program.name} as main; main()"
        script.write_text(f'#!/bin/sh\nexec "{sys.executable}" -c "{start}" "$@"\n')
        script.chmod(0o755)
    share = made / "share/er_bringup"
    (share / "launch").mkdir(parents=True)
    # a package's launch files are looked for below its folder, and links to folders are not followed
    shutil.copytree(ROOT / "config", share / "config", copy_function=os.symlink)
    for file in (ROOT / "src/er_bringup/launch").iterdir():
        (share / "launch" / file.name).symlink_to(file)
    return made


def command(paths: list[str], *words: str) -> list[str]:
    """Command line of a tool, as `ros2 WORDS`."""
    return [sys.executable, "-c", COMMAND.format(paths=paths), *words]


def environment(env: Mapping[str, str], made: Path) -> dict[str, str]:
    """Environment in which launch finds the programs of a prefix."""
    found = os.pathsep.join([str(made), *filter(None, [env.get("AMENT_PREFIX_PATH")])])
    return {
        **env,
        "AMENT_PREFIX_PATH": found,
        "ROS_LOG_DIR": str(made / "log"),
        "PYTHONUNBUFFERED": "1",
    }
