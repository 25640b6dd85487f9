"""package.xml and pyproject.toml declare what is imported, in names that rosdep and pip resolve, and agree."""

from __future__ import annotations

import ast
import sys
import xml.etree.ElementTree as ET
from importlib.metadata import packages_distributions
from itertools import chain
from pathlib import Path
from typing import Any

import pytest
from er_models.version import __version__
from er_ros_common.keys import KEYS, lacking
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
WITHOUT_KEY = {
    "asammdf",
    "compression",
    "dask",
    "distributed",
    "fsspec",
    "nicegui",
    "nptdms",
    "pyarrow",
}
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
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
            names = []
            if isinstance(node, ast.Import):
                names = [name.name for name in node.names]
            elif isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
                names = [node.module]
            for name in names:
                found.setdefault(name.split(".")[0], path.relative_to(ROOT))
    return {k: v for k, v in found.items() if k not in sys.stdlib_module_names and k != package}


@pytest.mark.parametrize("package", OURS)
def test_every_key_is_known_to_rosdep(package: str) -> None:
    assert keys(package) <= JAZZY | set(KEYS.values()) | set(OURS)
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
    brings = packages_distributions()
    for module, file in imported(package, pure=True).items():
        names = {canonicalize_name(name) for name in brings.get(module, [module])}
        assert names & wanted(package).keys() or module == "compression", f"{file}: {module}"


@pytest.mark.parametrize("package", PURE)
def test_nothing_is_asked_for_that_no_code_uses(package: str) -> None:
    """clarabel is cvxpy's solver, of plotly the script is taken, pyarrow is imported by a text, pytest tests."""
    brings = packages_distributions()
    used = {
        canonicalize_name(name)
        for module in imported(package, pure=True)
        for name in brings.get(module, [module])
    }
    assert wanted(package).keys() <= used | {
        "clarabel",
        "plotly",
        "pyarrow",
        "pytest",
        canonicalize_name(package),
    }


@pytest.mark.parametrize("package", [package for package in OURS if package != "er_damper_msgs"])
def test_colcon_finds_the_tests_of_a_package(package: str) -> None:
    """By an extra `test` with pytest; without it `colcon test` runs nothing and calls that a success."""
    folder = ROOT / "src" / package
    assert list(folder.glob("test/test_*.py"))
    assert "python3-pytest" in keys(package, "test_depend")
    if package in PURE:
        assert any(
            each.startswith("pytest") for each in project(package)["optional-dependencies"]["test"]
        )
    else:
        assert 'extras_require={"test": ["pytest"]}' in (folder / "setup.py").read_text(
            encoding="utf-8"
        )


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
