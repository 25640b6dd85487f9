"""Imports follow the arrows of ARCHITECTURE.md."""

import ast
import subprocess
import sys
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
OURS = (
    "er_models", "er_model_lab", "er_observers", "er_ftc_controller", "er_plant_sim",
    "er_ros_common", "er_bringup", "er_damper_msgs",
)  # fmt: skip
ALLOWED = {
    "er_models": set(),
    "er_ros_common": {"er_models", "er_damper_msgs"},
    "er_model_lab": {"er_models", "er_ros_common", "er_damper_msgs"},
    "er_observers": {"er_models", "er_ros_common", "er_damper_msgs"},
    "er_ftc_controller": {"er_models", "er_ros_common", "er_damper_msgs"},
    "er_plant_sim": {"er_models", "er_ros_common", "er_damper_msgs"},
    "er_bringup": set(OURS),
}
ROS = {
    "rclpy",
    "rosidl_runtime_py",
    "diagnostic_msgs",
    "std_msgs",
    "er_damper_msgs",
    "rosgraph_msgs",
    "launch",
    "lifecycle_msgs",
    "launch_ros",
}
STARTERS = {"record_command.py"}
"""Commands whose whole purpose is to start a node."""
PLOTS = {"matplotlib", "plotly"}


def modules():
    for package in ALLOWED:
        for path in sorted((ROOT / "src" / package / package).rglob("*.py")):
            yield package, path


def imports(path):
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            yield from (name.name for name in node.names)
        elif isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
            yield node.module


def is_ros_file(path):
    return path.name.startswith("ros_") or "nodes" in path.parts or "er_ros_common" in path.parts


CASES = [pytest.param(p, f, id=str(f.relative_to(ROOT / "src"))) for p, f in modules()]


@pytest.mark.parametrize(("package", "path"), CASES)
def test_imports_follow_the_arrows(package, path):
    for name in imports(path):
        head = name.split(".")[0]
        if head in OURS and head != package:
            assert head in ALLOWED[package], f"{path} must not import {name}"
        if head in ROS and package != "er_bringup":
            assert is_ros_file(path), f"{path} spells ROS ({name}) outside nodes/ and ros_*.py"
        if ".nodes" in name and head in OURS:
            allowed = "nodes" in path.parts or path.name in STARTERS
            assert allowed, f"{path} must not import the shell {name}"
        if head == "cvxpy":
            assert "synthesis" in path.parts, f"{path} must not import cvxpy"
        if head in PLOTS:
            assert "report" in path.parts or path.name.startswith("card"), f"{path} must not plot"


def test_the_pure_library_needs_no_ros():
    """A file that pip installs alone must not reach for anything but the field's libraries."""
    heads = {n.split(".")[0] for p, f in modules() if p == "er_models" for n in imports(f)}
    foreign = {h for h in heads if h not in sys.stdlib_module_names and h != "er_models"}
    assert foreign <= {"numpy", "scipy", "numba", "yaml", "sympy", "matplotlib", "pyarrow"}, (
        foreign
    )


HEAVY = {
    "asammdf", "clarabel", "cvxpy", "jinja2", "matplotlib", "mcap", "pandas", "plotly", "pyarrow", "pydantic", "rich",
    "rosbags", "scipy.integrate", "scipy.interpolate", "scipy.optimize", "scipy.signal", "scipy.sparse", "scipy.stats",
    "sklearn", "typer",
}  # fmt: skip
"""What belongs to the lab, to syntheses and to reports, and takes longer to import than a node."""
LOOP = ("er_plant_sim", "er_observers", "er_ftc_controller")
"""Packages whose nodes the control loop waits for."""


def imported_with(*names):
    """What else is loaded with these modules."""
    script = f"import sys, {', '.join(names)}; print(*sys.modules)"
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    return set(done.stdout.split())


def test_a_node_of_the_loop_is_there_soon():
    nodes = [f"{p}.nodes.{f.stem}" for p, f in modules() if p in LOOP and "nodes" in f.parts]
    assert imported_with(*nodes) & HEAVY == set()


def test_the_lab_says_what_it_can_do_at_once():
    """Its help, a list of effects and a wrong usage wait for nothing that only a command needs."""
    assert imported_with("er_model_lab.cli") & HEAVY == {"typer", "rich"}
