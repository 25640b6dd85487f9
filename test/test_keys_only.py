"""What rosdep's keys give is enough: packages built from package.xml alone start every executable."""

from __future__ import annotations

import os
import subprocess
import sys
from collections.abc import Iterable
from importlib.metadata import PackageNotFoundError, distribution, packages_distributions
from pathlib import Path
from xml.etree import ElementTree as ET

import pytest

pytest.importorskip("rclpy")

from er_bringup.programs import EVERY
from er_common.keys import KEYS, PIP
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from test.conftest import ROOT
from test.sample import write_sample
from test.test_wheels import linked, named

pytestmark = [pytest.mark.slow, pytest.mark.timeout(1200)]
MESSAGES = "er_damper_msgs"
"""Compiled as ever: it is no Python that anything of a key could be missing in."""


def asked() -> set[str]:
    """Keys of all packages, without those of their tests and ours."""
    manifests = (ROOT / "src").glob("*/package.xml")
    found = (e for path in manifests for e in ET.parse(path).getroot())
    keys = {str(e.text) for e in found if e.tag in ("depend", "exec_depend")}
    return {key for key in keys if not key.startswith("er_")}


def brought(keys: Iterable[str]) -> set[str]:
    """Names of the distributions that these keys install, with what those ask for."""
    modules = {key: module for module, key in KEYS.items()}
    known = packages_distributions()
    left = [(name, "") for key in keys for name in known.get(modules.get(key, key), ())]
    found: set[tuple[str, str]] = set()
    while left:
        name, extra = left.pop()
        if (name, extra) in found:
            continue
        try:
            texts = distribution(name).requires or []
        except PackageNotFoundError:  # for another system
            continue
        found.add((name, extra))
        needed = [Requirement(text) for text in texts]
        for each in needed:
            if not each.marker or each.marker.evaluate({"extra": extra}):
                left += named(each)
    return {canonicalize_name(name) for name, _ in found}


@pytest.fixture(scope="module")
def place(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An environment of what the keys give, and an install of all packages beside it."""
    folder = tmp_path_factory.mktemp("keys")
    subprocess.run(
        [sys.executable, "-m", "venv", "--without-pip", folder / "env"], check=True, cwd=folder
    )
    (site,) = folder.glob("env/lib/python*/site-packages")
    for name in sorted({"setuptools", *brought(asked())}):
        linked(name, site)
    words = ["--build-base", folder / "build", "--install-base", folder / "install"]
    built = subprocess.run(
        [
            Path(sys.executable).parent / "colcon", "--log-base", folder / "log", "build", *words,
            "--base-paths", ROOT / "src", "--packages-skip", MESSAGES,
        ], cwd=folder, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert built.returncode == 0, built.stderr[-3000:]
    return folder


def run(place: Path, *words: str | Path) -> subprocess.CompletedProcess[str]:
    """A program of the packages, which sees no Python module but those of the keys and ours."""
    paths = [*(place / "install").glob("*/lib/python*/site-packages")]
    paths += (ROOT / "install" / MESSAGES).glob("lib/python*/site-packages")
    env = {**os.environ, "PYTHONPATH": os.pathsep.join(map(str, paths))}
    env["AMENT_PREFIX_PATH"] = os.pathsep.join(
        [*map(str, (place / "install").glob("er_*")), os.environ["AMENT_PREFIX_PATH"]]
    )
    command = [str(word) for word in (place / "env/bin/python", *words)]
    return subprocess.run(
        command, cwd=place, env=env, capture_output=True, text=True, check=False, timeout=300
    )


def test_every_executable_starts(place: Path) -> None:
    code = f"from importlib.util import find_spec as f; print([*filter(f, {PIP})])"
    assert run(place, "-c", code).stdout.strip() == "[]"
    for program in EVERY:
        script = place / "install" / program.package / "lib" / program.package / program.name
        done = run(place, script, "--help")
        assert (done.returncode, done.stderr) == (0, ""), f"{program.name}: {done.stderr}"
        assert program.name in done.stdout


@pytest.mark.parametrize(
    "words",
    [("check", "run.csv"), ("open", "--no-browser"), ("fleet", "data", "--out", "t.parquet")],
)
def test_what_has_no_key_is_missed_in_one_line(place: Path, words: tuple[str, ...]) -> None:
    (place / "data").mkdir(exist_ok=True)
    for name in ("run.csv", "data/run.csv"):
        write_sample(place / name, seed=1, seconds=4.0)
    model = ("--model", "inove_guo") if words[0] == "fleet" else ()
    (lab,) = (place / "install/er_model_lab").glob("**/er-lab")
    done = run(place, lab, *words, *model)
    assert done.returncode == 2, done.stdout + done.stderr
    (line,) = done.stderr.strip().splitlines()
    assert "needs the Python package" in line
    assert "pip install" in line
