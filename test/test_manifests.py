"""package.xml and pyproject.toml declare what is imported, in names that rosdep and pip resolve, and agree."""

from __future__ import annotations

import ast
import re
import subprocess
import sys
import xml.etree.ElementTree as ET
from collections.abc import Mapping
from functools import cache
from graphlib import TopologicalSorter
from importlib.metadata import packages_distributions
from itertools import chain
from pathlib import Path
from typing import Any

import pytest
import typer
from er_common.keys import KEYS, PIP, lacking
from er_common.usage import OneLineGroup
from er_models.version import __version__
from packaging.requirements import Requirement
from packaging.utils import canonicalize_name

from test.conftest import ROOT
from test.test_layers import FINDERS, STARTERS, is_ros_file

if sys.version_info >= (3, 11):
    import tomllib
else:
    import tomli as tomllib

OURS = sorted(path.parent.name for path in (ROOT / "src").glob("*/package.xml"))
PURE = sorted(path.parent.name for path in (ROOT / "src").glob("*/pyproject.toml"))
"""Packages that are wheels, too."""
JAZZY = {
    "action_msgs", "ament_cmake", "ament_index_python", "builtin_interfaces", "control_msgs", "diagnostic_msgs",
    "geometry_msgs", "launch", "launch_ros", "lifecycle_msgs",
    "rcl_interfaces", "rclpy", "ros2launch", "rosbag2_storage_mcap", "rosgraph_msgs",
    "rosidl_default_generators", "rosidl_default_runtime", "sensor_msgs", "std_msgs",
}  # fmt: skip
"""ROS packages of Jazzy that may be needed."""
TIMEOUT = "python3-pytest-timeout"
"""What the settings of pytest ask for, and nothing imports."""
WITHOUT_KEY = {*PIP, "compression"}
"""Modules without a key, and one that Python 3.14 has: `./er setup` or pip installs them."""
PART_OF = {
    **dict.fromkeys(("rosidl_runtime_py", "rpyutils"), "rclpy"),
    **dict.fromkeys(("backports", "lz4"), "python3-rosbags-pip"),
    "threadpoolctl": "python3-sklearn",
    "joblib": "python3-sklearn",
}
"""Modules that come with another package."""


def manifest(package: str) -> ET.Element:
    return ET.parse(ROOT / "src" / package / "package.xml").getroot()


def keys(package: str, *kinds: str) -> set[str]:
    """Names in elements like <depend>; any of these kinds, or all."""
    found = [e for e in manifest(package) if e.tag.endswith("depend")]
    return {str(e.text) for e in found if not kinds or e.tag in kinds}


def project(package: str) -> dict[str, Any]:
    """The table `project` of a package's pyproject.toml."""
    text = (ROOT / "src" / package / "pyproject.toml").read_text(encoding="utf-8")
    found: dict[str, Any] = tomllib.loads(text)["project"]
    return found


def wanted(package: str) -> dict[str, Requirement]:
    """What a package's dependencies and extras ask for, by name."""
    found = project(package)
    texts = [*found["dependencies"], *chain(*found.get("optional-dependencies", {}).values())]
    return {canonicalize_name(each.name): each for each in map(Requirement, texts)}


def imported(package: str, *, pure: bool = False) -> dict[str, Path]:
    """Modules that a package's code imports, each with a file that does; pure: without what needs ROS."""
    found: dict[str, Path] = {}
    folder = ROOT / "src" / package / package
    for path in sorted(folder.rglob("*.py")):
        if pure and (is_ros_file(path) or path.name in STARTERS | FINDERS):
            continue
        for name in imported_by(path):
            found.setdefault(name.split(".")[0], path.relative_to(ROOT))
    return {k: v for k, v in found.items() if k not in sys.stdlib_module_names and k != package}


@cache
def imported_by(path: Path) -> list[str]:
    """Modules that a file imports."""
    names: list[str] = []
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            names += [name.name for name in node.names]
        elif isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
            names.append(node.module)
    return names


@cache
def installed() -> Mapping[str, list[str]]:
    """Packages that bring each module of this environment."""
    return packages_distributions()


@pytest.mark.parametrize("package", OURS)
def test_every_key_is_known_to_rosdep(package: str) -> None:
    assert keys(package) <= JAZZY | {*KEYS.values(), *OURS, TIMEOUT}
    root = manifest(package)
    assert root.get("format") == "3"
    for name in ("name", "version", "description", "maintainer", "license"):
        assert (root.findtext(name) or "").strip(), name
    assert root.findtext("name") == package
    assert root.findtext("license") == "Apache-2.0"


@pytest.mark.parametrize("package", OURS)
def test_what_is_imported_is_declared(package: str) -> None:
    declared = keys(package, "depend", "exec_depend")
    for module, file in imported(package).items():
        if module in WITHOUT_KEY:
            continue
        key = KEYS.get(module, PART_OF.get(module, module))
        assert key in declared, f"{file} imports {module}: <depend>{key}</depend> is missing"


@pytest.mark.parametrize("package", OURS)
def test_no_python_package_is_declared_that_nothing_imports(package: str) -> None:
    used = {KEYS.get(module, module) for module in imported(package)}
    assert {key for key in keys(package, "exec_depend") if key.startswith("python3-")} <= used


def test_no_key_is_declared_twice() -> None:
    for package in OURS:
        found = [str(e.text) for e in manifest(package) if e.tag in ("depend", "exec_depend")]
        assert len(found) == len(set(found)), package


@pytest.mark.parametrize("package", OURS)
def test_every_package_has_the_version_of_the_code(package: str) -> None:
    assert manifest(package).findtext("version") == __version__


@pytest.mark.parametrize("package", OURS)
def test_nobody_is_sent_to_an_address_that_cannot_be(package: str) -> None:
    (maintainer,) = manifest(package).iter("maintainer")
    assert maintainer.get("email") == "er-damper@users.noreply.github.com"
    assert manifest(package).findtext("url") == project("er_models")["urls"]["Repository"]


@pytest.mark.parametrize("package", OURS)
def test_every_package_has_its_licence(package: str) -> None:
    assert (ROOT / "src" / package / "LICENSE").resolve() == ROOT / "LICENSE"


@pytest.mark.parametrize("package", PURE)
def test_the_project_is_the_package(package: str) -> None:
    found = project(package)
    assert found["name"] == package
    assert found["urls"] == project("er_models")["urls"]
    assert {"classifiers", "description", "keywords", "readme"} <= found.keys()


@pytest.mark.parametrize("package", PURE)
def test_every_dependency_has_a_lower_bound(package: str) -> None:
    for name, asked in wanted(package).items():
        bound = f">={__version__}" if name.startswith("er-") else ">="
        assert name == canonicalize_name(package) or str(asked.specifier).startswith(bound), asked


@pytest.mark.parametrize("package", PURE)
def test_what_pure_code_imports_is_a_dependency_or_in_an_extra(package: str) -> None:
    brings = installed()
    for module, file in imported(package, pure=True).items():
        names = {canonicalize_name(name) for name in brings.get(module, [module])}
        assert names & wanted(package).keys() or module == "compression", f"{file}: {module}"


@pytest.mark.parametrize("package", PURE)
def test_nothing_is_asked_for_that_no_code_uses(package: str) -> None:
    """clarabel is cvxpy's solver, of plotly the script is taken, pyarrow is imported by a text, and some test."""
    brings = installed()
    used = {
        canonicalize_name(name)
        for module in imported(package, pure=True)
        for name in brings.get(module, [module])
    }
    assert wanted(package).keys() <= used | {
        "clarabel",
        "plotly",
        "pyarrow",
        "hypothesis",
        "pytest",
        "pytest-timeout",
        canonicalize_name(package),
    }


@pytest.mark.parametrize("package", [package for package in OURS if package != "er_damper_msgs"])
def test_colcon_finds_the_tests_of_a_package(package: str) -> None:
    """By an extra `test` with pytest; without it `colcon test` runs nothing and calls that a success."""
    folder = ROOT / "src" / package
    assert list(folder.glob("test/test_*.py"))
    assert keys(package, "test_depend") >= {"python3-pytest", TIMEOUT}
    if package in PURE:
        assert any(
            each.startswith("pytest") for each in project(package)["optional-dependencies"]["test"]
        )
    else:
        assert 'extras_require={"test": ["pytest", "pytest-timeout"]}' in (
            folder / "setup.py"
        ).read_text(encoding="utf-8")


def loaded(file: Path) -> set[str]:
    """Modules that a file of tests imports, without those that it skips for where they are missing."""
    tree = ast.parse(file.read_text(encoding="utf-8"))
    nodes = [*ast.walk(tree)]
    found = {name.name for node in nodes if isinstance(node, ast.Import) for name in node.names}
    found |= {str(node.module) for node in nodes if isinstance(node, ast.ImportFrom)}
    asked = [node for node in nodes if isinstance(node, ast.Call) and node.args]
    skipped = {
        node.args[0].value.partition(".")[0]
        for node in asked
        if ast.unparse(node.func) == "pytest.importorskip"
        and isinstance(node.args[0], ast.Constant)
    }
    return {name.partition(".")[0] for name in found} - skipped - sys.stdlib_module_names


@pytest.mark.parametrize("package", OURS)
def test_the_tests_of_a_package_import_what_it_declares(package: str) -> None:
    """Its own folder is all of the repository that they have under `colcon test`."""
    folder = ROOT / "src" / package / "test"
    declared = keys(package) | {package}
    for file in sorted(folder.rglob("*.py")):
        beside = {path.stem for path in (*folder.iterdir(), *file.parent.iterdir())}
        text = file.read_text(encoding="utf-8")
        assert not re.search(r"^\s*(from|import) test\b", text, re.M), f"{file} is for test/"
        for module in loaded(file) - beside:
            key = KEYS.get(module, PART_OF.get(module, module))
            assert key in declared, f"{file} imports {module}: <test_depend>{key}</test_depend>"


def test_no_package_needs_one_that_needs_it() -> None:
    TopologicalSorter({package: keys(package) & {*OURS} for package in OURS}).prepare()


@pytest.mark.slow
@pytest.mark.timeout(600)
@pytest.mark.parametrize("package", ["er_common", "er_ros_common"])
def test_colcon_runs_the_tests_of_a_package(package: str, tmp_path: Path) -> None:
    """In its own folder, without the rest of the repository."""
    words = ["--build-base", tmp_path / "build", "--install-base", ROOT / "install"]
    (tmp_path / "build" / package).mkdir(parents=True)
    tested = subprocess.run(
        [
            Path(sys.executable).parent / "colcon", "--log-base", tmp_path / "log", "test", *words,
            "--base-paths", ROOT / "src", "--packages-select", package, "--return-code-on-test-failure",
            "--pytest-args", "-m", "not slow and not alone", "-p", "no:cacheprovider", "-p", "no:xdist",
        ], cwd=tmp_path, capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert tested.returncode == 0, tested.stdout[-4000:] + tested.stderr[-2000:]
    (report,) = (tmp_path / "build" / package).glob("pytest.xml")
    (suite,) = ET.parse(report).iter("testsuite")
    assert int(str(suite.get("tests"))) > 20
    assert suite.get("errors") == suite.get("failures") == "0"


@pytest.mark.parametrize("package", OURS)
def test_every_package_has_the_changelog_that_bloom_asks_for(package: str) -> None:
    lines = (ROOT / "src" / package / "CHANGELOG.rst").read_text(encoding="utf-8").splitlines()
    title = f"Changelog for package {package}"
    assert lines[:3] == ["^" * len(title), title, "^" * len(title)]
    assert "Forthcoming" in lines
    assert any(line.startswith("* ") for line in lines)


def test_a_module_that_is_missing_is_one_line_with_the_key_of_rosdep() -> None:
    line = lacking("plant", ModuleNotFoundError("no", name="numba.core"))
    assert line == (
        "plant: needs the Python module numba: install rosdep's key python3-numba "
        "(rosdep install --from-paths src --ignore-src)"
    )
    assert lacking("plant", ModuleNotFoundError("no", name="er_plnat")) == ""
    assert lacking("er-lab", ModuleNotFoundError("no", name="pyarrow.csv")) == (
        "er-lab: needs the Python package pyarrow, for which rosdep has no key: pip install pyarrow"
    )


def test_a_command_without_a_module_ends_with_one_line(capsys: pytest.CaptureFixture[str]) -> None:
    app = typer.Typer(cls=OneLineGroup, add_completion=False)

    @app.callback()
    def either() -> None:
        """Of several commands."""

    @app.command()
    def read(module: str) -> None:
        raise ModuleNotFoundError(f"No module named {module}", name=module)

    with pytest.raises(SystemExit, match="2"):
        app(["read", "pyarrow.parquet"], prog_name="lab")
    assert capsys.readouterr().err.splitlines() == [
        "lab read: needs the Python package pyarrow, for which rosdep has no key: pip install pyarrow"
    ]
    with pytest.raises(ModuleNotFoundError):
        app(["read", "er_modles"], prog_name="lab")
