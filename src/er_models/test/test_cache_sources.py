"""Compiled code is named after all sources it can depend on: that of changed sources is compiled anew."""

from __future__ import annotations

import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from er_models.cache.sources import digest

import er_models

PACKAGE = Path(er_models.__file__).parent
OUTER = """
from er_models.cache.compiled import on_disk
from {place} import FACTOR, inner

@on_disk()
def outer(x):
    return FACTOR * inner(x)
"""
INNER = """
from er_models.cache.compiled import on_disk

FACTOR = {factor}

@on_disk()
def inner(x):
    return x + {shift}
"""
PROGRAM = """
import numba.core.event as event

with event.install_recorder("numba:compile") as compiled:
    from {package}.outer import outer
    print(outer(1.0), sum(e.is_start for _, e in compiled.buffer))
"""


def write(root: Path, folder: str, factor: float = 2.0, shift: float = 1.0) -> None:
    """A package whose function uses a constant and a function of a module that lies in a folder of its own."""
    shutil.rmtree(root / "small", ignore_errors=True)
    (root / "small" / folder).mkdir(parents=True)
    place = ".".join(("small", *Path(folder).parts, "kernel"))
    (root / "small" / "__init__.py").touch()
    (root / "small" / "outer.py").write_text(OUTER.format(place=place), encoding="utf-8")
    inner = INNER.format(factor=factor, shift=shift)
    (root / "small" / folder / "kernel.py").write_text(inner, encoding="utf-8")


def outcome(root: Path, package: str = "small") -> tuple[float, int]:
    """What the package's function gives in a process of its own, and how many functions that compiled.

    Python takes bytecode for that of its source by size and whole second: a file written twice in one would be old.
    """
    places = {
        "ER_CACHE_DIR": str(root / "cache"),
        "PYTHONPATH": paths(root),
        "PYTHONDONTWRITEBYTECODE": "1",
    }
    done = subprocess.run(
        [sys.executable, "-c", PROGRAM.format(package=package)], capture_output=True, text=True, check=True,
        env=os.environ | places,
    )  # fmt: skip
    assert done.stderr == ""
    value, compiled = done.stdout.split()
    return float(value), int(compiled)


def paths(root: Path) -> str:
    """Where modules are looked for: first of all here."""
    return os.pathsep.join([str(root), *filter(None, sys.path)])


@pytest.mark.slow
def test_what_a_changed_module_gives_is_never_the_old_value(tmp_path: Path) -> None:
    """The file of the function itself stays as it is; the folder is any, also one below another."""
    write(tmp_path, "a/b")
    assert outcome(tmp_path) == (4.0, 2)
    assert outcome(tmp_path) == (4.0, 0)
    write(tmp_path, "a/b", shift=10.0)
    assert outcome(tmp_path) == (22.0, 2)
    write(tmp_path, "a/b", factor=3.0, shift=10.0)
    assert outcome(tmp_path) == (33.0, 2)
    write(tmp_path, "c", factor=3.0, shift=20.0)
    assert outcome(tmp_path) == (63.0, 2)
    write(tmp_path, "a/b")
    assert outcome(tmp_path) == (4.0, 0)


def test_a_change_in_the_base_package_counts_for_every_other(tmp_path: Path) -> None:
    write(tmp_path, "a")
    shutil.copytree(PACKAGE, tmp_path / "er_models", ignore=shutil.ignore_patterns("__pycache__"))
    (tmp_path / "er_models" / "new").mkdir()
    (tmp_path / "er_models" / "new" / "numbers.py").write_text("FACTOR = 5.0\n", encoding="utf-8")
    outer = tmp_path / "small" / "outer.py"
    text = outer.read_text(encoding="utf-8").replace("import FACTOR, inner", "import inner")
    outer.write_text("from er_models.new.numbers import FACTOR\n" + text, encoding="utf-8")
    assert outcome(tmp_path) == (10.0, 2)
    (tmp_path / "er_models" / "new" / "numbers.py").write_text("FACTOR = 7.0\n", encoding="utf-8")
    assert outcome(tmp_path) == (14.0, 2)


def fresh(folder: Path) -> str:
    """The digest as another process would find it."""
    return digest.__wrapped__(str(folder))


def test_every_file_of_a_package_counts_wherever_it_lies(tmp_path: Path) -> None:
    """Its content, its place and that it is there; nothing else does."""
    copy = tmp_path / "copy"
    shutil.copytree(PACKAGE, copy, ignore=shutil.ignore_patterns("__pycache__"))
    before = fresh(copy)
    assert before == fresh(PACKAGE)
    found = {before}
    files = sorted(copy.rglob("*.py"))
    for path in files:
        content = path.read_bytes()
        path.write_bytes(content + b"\n")
        found.add(fresh(copy))
        path.write_bytes(content)
    assert len(found) == len(files) + 1
    kernel = next(path for path in files if "on_disk" in path.read_text(encoding="utf-8"))
    (copy / "elsewhere" / "deep").mkdir(parents=True)
    kernel.rename(copy / "elsewhere" / "deep" / kernel.name)
    found.add(fresh(copy))
    with (copy / "elsewhere" / "deep" / kernel.name).open("a", encoding="utf-8") as file:
        file.write("CONSTANT = 2.0\n")
    found.add(fresh(copy))
    assert len(found) == len(files) + 3
    (copy / "__pycache__").mkdir()
    (copy / "__pycache__" / "a.py").touch()
    (copy / "model.yaml").touch()
    assert fresh(copy) in found
