"""Imports follow the arrows of ARCHITECTURE.md."""

import ast
import subprocess
import sys
from functools import cache
from importlib import import_module
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[1]
OURS = (
    "er_models", "er_common", "er_records", "er_model_lab", "er_observers", "er_ftc_controller",
    "er_plant_sim", "er_ros_common", "er_bringup", "er_damper_msgs", "er_studies",
)  # fmt: skip
ALLOWED = {
    "er_models": set(),
    "er_common": {"er_models"},
    "er_ros_common": {"er_models", "er_common", "er_damper_msgs"},
    "er_records": {"er_models", "er_common"},
    "er_model_lab": {"er_models", "er_common", "er_records", "er_ros_common", "er_damper_msgs"},
    "er_observers": {"er_models", "er_common", "er_ros_common", "er_damper_msgs"},
    "er_ftc_controller": {"er_models", "er_common", "er_ros_common", "er_damper_msgs"},
    "er_plant_sim": {"er_models", "er_common", "er_ros_common", "er_damper_msgs"},
    "er_bringup": set(OURS) - {"er_studies"},
    "er_studies": set(OURS),
}
ROS = {
    "builtin_interfaces", "diagnostic_msgs", "er_damper_msgs", "launch", "launch_ros", "lifecycle_msgs",
    "rcl_interfaces", "rclpy", "rosgraph_msgs", "rosidl_runtime_py", "sensor_msgs", "std_msgs",
}  # fmt: skip
FINDS = "ament_index_python"
FINDERS = {"up.py", "message_definitions.py"}
"""Files that ask where an installed file is; ROS itself they need not."""
STARTERS = {"executables.py", "record_command.py", "ros_composed.py"}
"""Files whose whole purpose is to start nodes."""
LOADERS = {"import_module"}
"""Functions that import what a text names."""
PLOTS = {"matplotlib", "plotly"}
FRAMEWORK = "nicegui"
"""What the page is made with, which nothing but the page knows."""


def modules():
    for package in ALLOWED:
        for path in sorted((ROOT / "src" / package / package).rglob("*.py")):
            yield package, path


@cache
def imports(path):
    """What a file imports: modules, and names taken from them, which may be modules; those that a text names too."""
    return (*imports_of(ast.parse(path.read_text(encoding="utf-8"))),)


def imports_of(tree):
    for node in ast.walk(tree):
        if isinstance(node, ast.Import):
            yield from (name.name for name in node.names)
        elif isinstance(node, ast.ImportFrom) and node.level == 0 and node.module:
            yield from (f"{node.module}.{name.name}" for name in node.names)
        elif isinstance(node, ast.Call) and called(node) in LOADERS and node.args:
            yield text_of(node.args[0])


def called(call):
    """Name of the function that is called, without what it stands in."""
    return getattr(call.func, "attr", getattr(call.func, "id", ""))


def text_of(node):
    """A text as far as it stands in the file; ? for what is put in."""
    parts = node.values if isinstance(node, ast.JoinedStr) else [node]
    return "".join(str(part.value) if isinstance(part, ast.Constant) else "?" for part in parts)


def is_ros_file(path):
    return path.name.startswith("ros_") or "nodes" in path.parts or "er_ros_common" in path.parts


def breaches(package, path, names):
    """What a file of a package imports against the arrows."""
    for name in names:
        head, *inner = name.split(".")
        if head in OURS and head != package and head not in ALLOWED[package]:
            yield f"{path} must not import {name}"
        if head in ROS and not is_ros_file(path):
            yield f"{path} imports ROS ({name}) outside nodes/ and ros_*.py"
        shared = head == "er_ros_common" and package != "er_bringup"
        if shared and not is_ros_file(path) and path.name not in STARTERS:
            yield f"{path} imports what nodes share ({name}); without ROS there is er_common"
        if head == FINDS and path.name not in FINDERS and not is_ros_file(path):
            yield f"{path} looks for installed files"
        shell = (head in OURS or "?" in head) and inner[:1] == ["nodes"]
        if shell and "nodes" not in path.parts and path.name not in STARTERS:
            yield f"{path} must not import the shell {name}"
        if head == "cvxpy" and "synthesis" not in path.parts:
            yield f"{path} must not import cvxpy"
        if head == FRAMEWORK and "page" not in path.relative_to(ROOT).parts:
            yield f"{path} knows the page's framework ({name})"
        if head in PLOTS and "report" not in path.parts:
            yield f"{path} must not plot"


CASES = [pytest.param(p, f, id=str(f.relative_to(ROOT / "src"))) for p, f in modules()]


@pytest.mark.parametrize(("package", "path"), CASES)
def test_imports_follow_the_arrows(package, path):
    assert [*breaches(package, path, imports(path))] == []


@pytest.mark.parametrize(
    ("code", "where"),
    [
        ("from er_ftc_controller import nodes", "control.py"),
        ("import er_ftc_controller.nodes.ftc_controller", "control.py"),
        ("from importlib import import_module\nimport_module('er_observers.law')", "control.py"),
        ("import importlib\nimportlib.import_module(f'er_observers.{name}')", "control.py"),
        ("import_module(f'{package}.nodes.{executable}')", "control.py"),
        ("import_module('er_observers.nodes.fault_estimator')", "executables.py"),
        ("from er_observers import law", "control.py"),
        ("from er_ros_common import stuck", "control.py"),
        ("from er_ros_common.entry import program", "control.py"),
        ("from sensor_msgs.msg import JointState", "control.py"),
        ("from builtin_interfaces.msg import Time", "control.py"),
        ("import rcl_interfaces", "control.py"),
        ("import cvxpy as cp", "control.py"),
        ("from matplotlib import pyplot", "control.py"),
        ("from nicegui import ui", "control.py"),
        ("from ament_index_python import get_package_share_directory", "control.py"),
    ],
)
def test_no_way_against_the_arrows_is_overlooked(code, where):
    path = ROOT / "src/er_ftc_controller/er_ftc_controller" / where
    assert len([*breaches("er_ftc_controller", path, imports_of(ast.parse(code)))]) == 1


def test_the_pure_library_needs_no_ros():
    """What pip installs alone must not reach for anything but the field's libraries."""
    heads = {n.split(".")[0] for p, f in modules() if p == "er_models" for n in imports(f)}
    ours = {
        "er_models",
        "?",
    }  # what is imported by a name that a variable holds stands in the file that gives it
    foreign = heads - ours - sys.stdlib_module_names
    assert foreign == {"numpy", "scipy", "numba", "yaml", "pyarrow"}, (
        foreign
    )  # pyarrow for tables alone


HEAVY = {
    "asammdf", "clarabel", "cvxpy", "dask", "distributed", "fsspec", "jinja2", "matplotlib", "mcap", "nicegui",
    "pandas", "plotly", "pyarrow", "pydantic", "rich", "rosbags", "scipy.integrate", "scipy.interpolate",
    "scipy.optimize", "scipy.signal",
    "scipy.sparse", "scipy.stats", "sklearn", "typer",
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


def made_of(*packages):
    """What the programs of packages are made of, and the node around cores."""
    each = (program for p in packages for program in import_module(f"{p}.programs").PROGRAMS)
    return ["er_ros_common.core_node", *(program.path for program in each)]


def test_a_node_of_the_loop_is_there_soon():
    assert imported_with(*made_of(*LOOP)) & HEAVY == set()


def test_an_observer_waits_for_no_linear_algebra_of_scipy():
    """It takes a third of its start; NumPy's is there anyway."""
    assert "scipy.linalg" not in imported_with(*made_of("er_observers"))


def test_skyhook_waits_for_no_compiler():
    """Numba doubles its memory, and half of its start is that import."""
    assert imported_with("er_ftc_controller.ros_skyhook") & {"numba", "scipy"} == set()


def test_the_lab_says_what_it_can_do_at_once():
    """Its help, a list of effects and a wrong usage wait for nothing that only a command needs."""
    assert imported_with("er_model_lab.cli.app") & HEAVY == {"typer", "rich"}


def blocks(package):
    """Which blocks of a package, folders and files at its top, each block imports."""
    home = ROOT / "src" / package / package
    graph = {}
    for path in sorted(home.rglob("*.py")):
        block = path.relative_to(home).parts[0].removesuffix(".py")
        inner = (n.split(".")[1] for n in imports(path) if n.startswith(f"{package}."))
        known = {i for i in inner if (home / i).is_dir() or (home / f"{i}.py").exists()}
        graph.setdefault(block, set()).update(known - {block})
    return graph


def files(package):
    """Which files of a package each file imports, wherever in it: at its top, for types alone or inside a function."""
    home = ROOT / "src" / package
    found = {module_of(p.relative_to(home)): p for p in sorted((home / package).rglob("*.py"))}
    return {
        name: {m for m in (file_of(n, found) for n in imports(path)) if m not in {name, None}}
        for name, path in found.items()
    }


def module_of(path):
    """Name of the module that a file is."""
    return ".".join(path.with_suffix("").parts).removesuffix(".__init__")


def file_of(name, known):
    """The file that holds what is imported: a module, or that from which a name is taken; None of another package."""
    return (
        name if name in known else next((m for m in [name.rpartition(".")[0]] if m in known), None)
    )


def circle(graph):
    """What is left once whoever imports nothing left, or is imported by nobody left, is taken away again and again."""
    while True:
        graph = {b: seen & graph.keys() for b, seen in graph.items()}
        wanted = set().union(*graph.values())
        kept = {b: seen for b, seen in graph.items() if seen and b in wanted}
        if len(kept) == len(graph):
            return graph
        graph = kept


@pytest.mark.parametrize("package", sorted(ALLOWED))
@pytest.mark.parametrize("parts", [blocks, files])
def test_what_a_package_is_made_of_imports_one_way(parts, package):
    assert circle(parts(package)) == {}


def test_a_circle_is_found():
    assert circle({"a": {"b"}, "b": {"c", "d"}, "c": {"b"}, "d": set()}).keys() == {"b", "c"}


@pytest.mark.parametrize(
    "back",
    [
        "from er_models.one import x",
        "import er_models.one",
        "from er_models import one",
        "from typing import TYPE_CHECKING\nif TYPE_CHECKING:\n    from er_models.one import x",
        "def f():\n    from er_models.one import x",
        "from importlib import import_module\nimport_module('er_models.one')",
    ],
)
def test_no_circle_of_files_is_overlooked(back, tmp_path, monkeypatch):
    monkeypatch.setitem(globals(), "ROOT", tmp_path)
    home = tmp_path / "src/er_models/er_models"
    home.mkdir(parents=True)
    for name, code in {
        "one": "from er_models.two import y",
        "two": back,
        "three": "x = 1",
    }.items():
        (home / f"{name}.py").write_text(code, encoding="utf-8")
    (home / "__init__.py").touch()
    assert circle(files("er_models")).keys() == {"er_models.one", "er_models.two"}
