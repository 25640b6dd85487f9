"""One cache of compiled code for all packages: what is kept depends on nothing that does not name it."""

import ast
from importlib import import_module

import pytest
from er_models.cache.compiled import Kept
from er_models.cache.sources import state
from numba.core.dispatcher import Dispatcher

from test.test_layers import OURS, ROOT, imports_of

BASE, MAKER = "er_models", "on_disk"


def name_of(path):
    """Name of the module in a file."""
    parts = path.relative_to(ROOT / "src").with_suffix("").parts[1:]
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


TREES = {
    name_of(path): ast.parse(path.read_text(encoding="utf-8"))
    for package in OURS
    for path in (ROOT / "src" / package / package).rglob("*.py")
}


def called(node):
    """Name of what a decorator or an assigned value calls, or is."""
    node = node.func if isinstance(node, ast.Call) else node
    return getattr(node, "attr", getattr(node, "id", ""))


def decorators():
    """Names under which functions are kept on disk."""
    nodes = [node for tree in TREES.values() for node in ast.walk(tree)]
    made = [n for n in nodes if isinstance(n, ast.Assign) and called(n.value) == MAKER]
    return {MAKER, *(target.id for node in made for target in node.targets)}


def kept():
    """Modules with functions that are kept on disk."""
    names = decorators()
    for module, tree in TREES.items():
        functions = [node for node in ast.walk(tree) if isinstance(node, ast.FunctionDef)]
        if any(called(each) in names for node in functions for each in node.decorator_list):
            yield module


MODULES = sorted(kept())


def test_there_is_compiled_code_in_several_packages():
    assert {module.split(".")[0] for module in MODULES} >= {BASE, "er_observers", "er_model_lab"}


@pytest.mark.parametrize("module", MODULES)
def test_compiled_code_depends_on_its_own_package_and_the_base_alone(module):
    """Constants of another package would be compiled in, and their change not be noticed."""
    seen, wanted = set(), [module]
    while wanted:
        name = wanted.pop()
        while name and name not in TREES:  # a name that is taken from a module
            name = name.rpartition(".")[0]
        if name and name not in seen:
            seen.add(name)
            wanted += imports_of(TREES[name])
    assert {name.split(".")[0] for name in seen} <= {module.split(".")[0], BASE}


@pytest.mark.parametrize("module", [m for m in MODULES if not m.startswith(f"{BASE}.kernel")])
def test_each_function_is_kept_under_the_state_of_all_sources(module):
    found = [f for f in vars(import_module(module)).values() if isinstance(f, Dispatcher)]
    assert found
    for function in found:
        assert isinstance(function._cache, Kept)
        assert function._cache.cache_path.endswith(f"/{state(function.__module__)[0]}")


def test_nothing_is_kept_another_way():
    """Numba's own cache looks at one file, and unpickles whatever lies in its folder."""
    calls = [n for tree in TREES.values() for n in ast.walk(tree) if isinstance(n, ast.Call)]
    assert not [c for c in calls for k in c.keywords if k.arg == "cache"]
    assert not [
        c
        for c in calls
        if called(c) in ("enable_caching", "load_module", "spec_from_file_location")
    ]
