"""The pure packages as wheels: they declare what they need, hold what they ship, and run without repository and ROS."""

from __future__ import annotations

import json
import os
import re
import shutil
import subprocess
import sys
import zipfile
from collections.abc import Iterator
from importlib.metadata import distribution
from pathlib import Path

import numpy as np
import pytest
from er_common.topics import ACCELERATION, DEFLECTION, FORCE, PWM_APPLIED
from er_records.recording.bag_writer import BagWriter
from er_ros_common.builders import Tick
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name
from rclpy.serialization import serialize_message

from er_ros_common import builders
from test.conftest import ROOT
from test.sample import write_sample

pytestmark = pytest.mark.slow

PURE = (
    "er_models", "er_common", "er_records", "er_model_lab", "er_observers", "er_ftc_controller",
    "er_plant_sim",
)  # fmt: skip
WANTED = (
    "er_model_lab[bags,plots]",
    "er_observers[synthesis]",
    "er_ftc_controller",
    "er_plant_sim",
)
"""What is installed. The extra `mf4` is left out: it is large, and no script here reads MF4."""
TOPICS = (DEFLECTION, PWM_APPLIED, FORCE, ACCELERATION)
CODE = re.compile(r"^```python\n(.*?)^```", re.MULTILINE | re.DOTALL)
PLACES = """
import sys
from importlib.metadata import version
from importlib.util import find_spec

for name in sys.argv[1:]:
    assert find_spec(name).origin.startswith(sys.prefix), find_spec(name).origin
for name in ("rclpy", "er_ros_common", "er_damper_msgs"):
    assert find_spec(name) is None, name
print(*(version(name) for name in sys.argv[1:]))
"""
CHECKS = """
import json
from pathlib import Path
import pandas as pd

assert (result.verdict, result.effects) == ("missing_effect", ("coulomb_friction",)), result
assert Path("residual_maps.png").is_file() and Path("report/index.html").is_file()
assert json.loads(json.dumps(result.to_dict()))["effects"] == ["coulomb_friction"]
assert "coulomb_friction" in result.to_frame().to_string()
table = pd.read_csv("run2.csv")
one = lab.compare(lab.from_arrays(**{name: table[name] for name in table}), model)
other = lab.compare(lab.from_frame(table, names={"damper_force": "damper_force"}), model)
assert one.rmse == other.rmse == lab.compare(lab.load("run2.csv"), model).rmse
"""
"""What must hold after the code of the lab's README."""


def run(*command: str | Path, cwd: Path) -> str:
    """Standard output of a program that sees nothing of the repository; what it said where it fails."""
    kept = ("HOME", "LANG", "TMPDIR", "ER_CACHE_DIR", "XDG_CACHE_HOME")
    env = {k: v for k, v in os.environ.items() if k in kept} | {"PATH": os.defpath}
    words = [str(part) for part in command]
    done = subprocess.run(words, cwd=cwd, env=env, capture_output=True, text=True, check=False)
    assert done.returncode == 0, f"{done.stdout[-2000:]}\n{done.stderr[-4000:]}"
    return done.stdout


@pytest.fixture(scope="module")
def wheels(tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """A wheel of each package, made without the index from a copy: pip leaves a folder `build` beside the sources."""
    place = tmp_path_factory.mktemp("wheels")
    left_out = shutil.ignore_patterns("__pycache__", "build", "test")
    for package in PURE:
        shutil.copytree(ROOT / "src" / package, place / "src" / package, ignore=left_out)
    pip = (sys.executable, "-m", "pip", "wheel", "--no-deps", "--no-index", "--no-build-isolation")
    run(*pip, "-w", place / "dist", *(place / "src" / package for package in PURE), cwd=place)
    made = {path.name.split("-")[0]: path for path in (place / "dist").glob("*.whl")}
    assert made.keys() == set(PURE)
    return made


def inside(wheel: Path, ending: str) -> str:
    """Text of the one file of a wheel whose name ends so."""
    with zipfile.ZipFile(wheel) as archive:
        (name,) = (name for name in archive.namelist() if name.endswith(ending))
        return archive.read(name).decode()


def required(name: str, wheels: dict[str, Path]) -> list[Requirement]:
    """What a wheel of ours, or else an installed distribution, declares that it needs."""
    ours = {canonicalize_name(package): wheel for package, wheel in wheels.items()}
    if name in ours:
        lines = inside(ours[name], ".dist-info/METADATA").splitlines()
        texts = [line.split(": ", 1)[1] for line in lines if line.startswith("Requires-Dist: ")]
    else:
        texts = distribution(name).requires or []
    return [Requirement(text) for text in texts]


def declared(wheels: dict[str, Path]) -> set[str]:
    """Names of all distributions that `WANTED` asks for, and of what those ask for, without ours."""
    left = [each for text in WANTED for each in named(Requirement(text))]
    found: set[tuple[str, str]] = set()
    while left:
        name, extra = left.pop()
        if (name, extra) not in found:
            found.add((name, extra))
            for asked in required(name, wheels):
                if not asked.marker or asked.marker.evaluate({"extra": extra}):
                    left += named(asked)
    return {name for name, _ in found} - {canonicalize_name(package) for package in wheels}


def named(asked: Requirement) -> list[tuple[str, str]]:
    """Name with each extra that is asked for, and with none."""
    return [(canonicalize_name(asked.name), extra) for extra in ("", *asked.extras)]


def linked(name: str, site: Path) -> None:
    """Bring an installed distribution into another environment, file by file."""
    files = distribution(name).files
    assert files, name
    for file in files:
        if ".." not in file.parts and "__pycache__" not in file.parts:
            place = site / file
            place.parent.mkdir(parents=True, exist_ok=True)
            if not place.is_symlink():  # two list the same setup.py
                place.symlink_to(file.locate())


@pytest.fixture(scope="module")
def empty(wheels: dict[str, Path], tmp_path_factory: pytest.TempPathFactory) -> Path:
    """An environment of the wheels and of what they declare: what they forgot to declare is not there.

    What is not ours is linked from the environment of the tests, so that no index is needed; pip checks it.
    """
    home = tmp_path_factory.mktemp("empty") / "env"
    run(sys.executable, "-m", "venv", "--without-pip", home, cwd=home.parent)
    (site,) = home.glob("lib/python*/site-packages")
    for name in sorted({"pip", *declared(wheels)}):
        linked(name, site)
    dist = next(iter(wheels.values())).parent
    pip = (home / "bin/python", "-m", "pip", "--no-input")
    run(*pip, "install", "--no-index", "--find-links", dist, *WANTED, cwd=home.parent)
    run(*pip, "check", cwd=home.parent)
    return home


def test_programs_of_nodes_are_in_no_wheel(wheels: dict[str, Path]) -> None:
    with zipfile.ZipFile(wheels["er_plant_sim"]) as archive:
        assert not [name for name in archive.namelist() if name.endswith("entry_points.txt")]
    points = inside(wheels["er_model_lab"], ".dist-info/entry_points.txt")
    assert points.split() == ["[console_scripts]", "er-lab", "=", "er_model_lab.cli.app:main"]


@pytest.mark.parametrize("package", PURE)
def test_every_file_that_is_no_code_is_in_the_wheel(package: str, wheels: dict[str, Path]) -> None:
    with zipfile.ZipFile(wheels[package]) as archive:
        held = set(archive.namelist())
    assert f"{package}-0.2.0.dist-info/licenses/LICENSE" in held
    assert {str(p.relative_to(ROOT / "src" / package)) for p in files(package)} <= held


def files(package: str) -> Iterator[Path]:
    """Files of a package that are kept, with those behind links."""
    for folder, _, names in os.walk(ROOT / "src" / package / package, followlinks=True):
        if not folder.endswith("__pycache__"):
            yield from (Path(folder, name) for name in names)


def test_the_packages_are_those_of_the_wheels_and_nothing_needs_ros(empty: Path) -> None:
    assert run(empty / "bin/python", "-c", PLACES, *PURE, cwd=empty).split() == ["0.2.0"] * len(
        PURE
    )


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a recording and a table of a damper with Coulomb friction."""
    place = tmp_path_factory.mktemp("data")
    write_sample(place / "run2.csv", seed=2, seconds=10.0)
    rows = np.genfromtxt(write_sample(place / "run1.csv", seed=1, seconds=10.0), delimiter=",")[1:]
    bag = BagWriter(place / "bag")
    links = [bag.topic(f"/{topic.name}", topic.type_name) for topic in TOPICS]
    for k, (_, x, v, u, force, sprung, unsprung) in enumerate(rows.tolist(), start=1):
        tick = Tick(5_000_000 * k, k)
        messages = (
            builders.suspension_deflection(tick, x, v),
            builders.pwm_duty(tick, u),
            builders.damper_force(tick, force),
            builders.suspension_acceleration(tick, sprung, unsprung),
        )
        for link, message in zip(links, messages):
            bag.write(link, 5_000_000 * k, serialize_message(message))
    bag.close({})
    next((place / "bag").glob("*.mcap")).rename(place / "run1.mcap")
    return place


@pytest.fixture
def measured(data: Path, tmp_path: Path) -> Path:
    """A folder of its own with those measurements."""
    for name in ("run1.mcap", "run2.csv"):
        shutil.copy(data / name, tmp_path)
    return tmp_path


@pytest.mark.parametrize("package", PURE)
def test_the_code_of_the_readme_runs(package: str, empty: Path, measured: Path) -> None:
    text = (ROOT / "src" / package / "README.md").read_text(encoding="utf-8")
    (code,) = CODE.findall(text)
    more = CHECKS if package == "er_model_lab" else ""
    (measured / "example.py").write_text(code + more, encoding="utf-8")
    run(empty / "bin/python", "-W", "error", "example.py", cwd=measured)


def test_the_command_diagnoses_without_the_repository(empty: Path, measured: Path) -> None:
    words = ("run1.mcap", "run2.csv", "--model", "inove_guo", "--json", "result.json")
    run(empty / "bin/er-lab", "diagnose", *words, cwd=measured)
    result = json.loads((measured / "result.json").read_text(encoding="utf-8"))
    assert (result["verdict"], result["effects"]) == ("missing_effect", ["coulomb_friction"])
    card = run(empty / "bin/er-lab", "effects", "coulomb_friction", cwd=measured)
    assert "Coulomb friction" in card
