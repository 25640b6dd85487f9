"""package.xml files that rosdep resolves: known keys only, and every ROS package that is imported."""

from __future__ import annotations

import ast
import sys
import xml.etree.ElementTree as ET
from pathlib import Path

import pytest

from test.conftest import ROOT

OURS = sorted(path.parent.name for path in (ROOT / "src").glob("*/package.xml"))
JAZZY = {
    "ament_cmake", "builtin_interfaces", "diagnostic_msgs", "launch", "launch_ros", "lifecycle_msgs",
    "rcl_interfaces", "rclpy", "ros2launch", "rosbag2_storage_mcap", "rosgraph_msgs",
    "rosidl_default_generators", "rosidl_default_runtime", "sensor_msgs", "std_msgs",
}  # fmt: skip
"""ROS packages of Jazzy that may be needed."""
SYSTEM = {
    "numpy": "python3-numpy",
    "pytest": "python3-pytest",
    "scipy": "python3-scipy",
    "serial": "python3-serial",
    "yaml": "python3-yaml",
}
"""Modules to keys of rosdep that resolve on Ubuntu 24.04 and Debian 12 (rosdistro's rosdep/python.yaml)."""
FROM_WHEELS = {
    "PIL", "asammdf", "backports", "compression", "cvxpy", "jinja2", "lz4", "matplotlib", "numba", "plotly",
    "pyarrow", "pydantic", "pysindy", "rich", "rosbags", "sklearn", "sympy", "threadpoolctl", "typer",
}  # fmt: skip
"""Modules without a key that resolves there (python3-numba has none for 24.04): `./er setup` installs them."""
PART_OF = {"ament_index_python": "rclpy", "rosidl_runtime_py": "rclpy", "rpyutils": "rclpy"}
"""Modules that come with another package."""


def manifest(package: str) -> ET.Element:
    return ET.parse(ROOT / "src" / package / "package.xml").getroot()


def keys(package: str, *kinds: str) -> set[str]:
    """Names in elements like <depend>; any of these kinds, or all."""
    found = [e for e in manifest(package) if e.tag.endswith("depend")]
    return {str(e.text) for e in found if not kinds or e.tag in kinds}


def imported(package: str) -> dict[str, Path]:
    """Modules that a package's code imports, each with a file that does."""
    found: dict[str, Path] = {}
    folder = ROOT / "src" / package / package
    for path in sorted(folder.rglob("*.py")):
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
    assert keys(package) <= JAZZY | set(SYSTEM.values()) | set(OURS)
    root = manifest(package)
    assert root.get("format") == "3"
    for name in ("name", "version", "description", "maintainer", "license"):
        assert (root.findtext(name) or "").strip(), name
    assert root.findtext("name") == package


@pytest.mark.parametrize("package", OURS)
def test_what_is_imported_is_declared(package: str) -> None:
    declared = keys(package, "depend", "exec_depend")
    for module, file in imported(package).items():
        if module in FROM_WHEELS:
            continue
        key = SYSTEM.get(module, PART_OF.get(module, module))
        assert key in declared, f"{file} imports {module}: <depend>{key}</depend> is missing"


def test_no_key_is_declared_twice() -> None:
    for package in OURS:
        found = [str(e.text) for e in manifest(package) if e.tag in ("depend", "exec_depend")]
        assert len(found) == len(set(found)), package
