"""One cache of compiled code for all packages: what is kept depends on nothing that does not name it."""

import ast
from dataclasses import dataclass
from functools import cache
from importlib import import_module

from er_models.cache.compiled import Kept
from er_models.cache.sources import state
from numba.core.dispatcher import Dispatcher

from test.test_layers import OURS, ROOT, imports_of

BASE, MAKER = "er_models", "on_disk"


def name_of(path):
    """Name of the module in a file."""
    parts = path.relative_to(ROOT / "src").with_suffix("").parts[1:]
    return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)


@dataclass(frozen=True)
class Facts:
    """What a module does: its imports, decorators of its functions, what it calls, and whether with `cache`."""

    imports: tuple
    decorators: frozenset
    makers: frozenset
    calls: frozenset
    own_cache: bool


def called(node):
    """Name of what a decorator or an assigned value calls, or is."""
    node = node.func if isinstance(node, ast.Call) else node
    return getattr(node, "attr", getattr(node, "id", ""))


def facts(tree):
    """Facts of a module, of which the tree itself is not kept: those of all modules fill half a gigabyte."""
    nodes = list(ast.walk(tree))
    functions = [n for n in nodes if isinstance(n, ast.FunctionDef)]
    calls = [n for n in nodes if isinstance(n, ast.Call)]
    made = [n for n in nodes if isinstance(n, ast.Assign) and called(n.value) == MAKER]
    return Facts(
        imports=tuple(imports_of(tree)),
        decorators=frozenset(called(each) for n in functions for each in n.decorator_list),
        makers=frozenset(target.id for n in made for target in n.targets),
        calls=frozenset(called(n) for n in calls),
        own_cache=any(k.arg == "cache" for n in calls for k in n.keywords),
    )


@cache
def modules():
    """Facts of every module, by name."""
    return {
        name_of(path): facts(ast.parse(path.read_text(encoding="utf-8")))
        for package in OURS
        for path in (ROOT / "src" / package / package).rglob("*.py")
    }


@cache
def kept():
    """Modules with functions that are kept on disk."""
    names = {MAKER}.union(*(each.makers for each in modules().values()))
    return sorted(name for name, each in modules().items() if each.decorators & names)


def reached(module):
    """Packages of all modules that a module imports, directly or through others."""
    seen, wanted = set(), [module]
    while wanted:
        name = wanted.pop()
        while name and name not in modules():  # a name that is taken from a module
            name = name.rpartition(".")[0]
        if name and name not in seen:
            seen.add(name)
            wanted += modules()[name].imports
    return {name.split(".")[0] for name in seen}


def test_there_is_compiled_code_in_several_packages():
    assert {module.split(".")[0] for module in kept()} >= {BASE, "er_observers", "er_model_lab"}


def test_compiled_code_depends_on_its_own_package_and_the_base_alone():
    """Constants of another package would be compiled in, and their change not be noticed."""
    beyond = {module: reached(module) - {module.split(".")[0], BASE} for module in kept()}
    assert not {module: others for module, others in beyond.items() if others}


def test_each_function_is_kept_under_the_state_of_all_sources():
    for module in [m for m in kept() if not m.startswith(f"{BASE}.kernel")]:
        found = [f for f in vars(import_module(module)).values() if isinstance(f, Dispatcher)]
        assert found, module
        for function in found:
            assert isinstance(function._cache, Kept), module
            assert function._cache.cache_path.endswith(f"/{state(function.__module__)[0]}")


def test_nothing_is_kept_another_way():
    """Numba's own cache looks at one file, and unpickles whatever lies in its folder."""
    other = {"enable_caching", "load_module", "spec_from_file_location"}
    assert not [name for name, each in modules().items() if each.own_cache or each.calls & other]
