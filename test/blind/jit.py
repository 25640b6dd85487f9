"""Numba decorators with types, and a disk cache that cannot go stale.

Numba keys its cache on the file of the cached function alone, so an edit of an effect would leave
an old integrator in use and silently produce a wrong truth. Here the cache directory carries a
hash of every source file of the generator.
"""

from __future__ import annotations

import hashlib
import shutil
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
from numpy import float64
from numpy.typing import NDArray

F = TypeVar("F", bound=Callable[..., Any])
Array = NDArray[float64]

_HERE = Path(__file__).resolve().parent


def _source_hash() -> str:
    digest = hashlib.sha1(usedforsecurity=False)
    for path in sorted(_HERE.rglob("*.py")):
        if not path.name.startswith(("test_", "short")):
            digest.update(path.read_bytes())
    return digest.hexdigest()[:16]


def _cache_directory() -> str:
    """Directory of the compiled integrator; empty where nothing can be written.

    Integrators of earlier sources can never be used again, so they are removed.
    """
    path = _HERE / "__pycache__" / f"compiled-{_source_hash()}"
    try:
        path.mkdir(parents=True, exist_ok=True)
    except OSError:
        return ""
    for old in path.parent.glob("compiled-*"):
        if old != path:
            shutil.rmtree(old, ignore_errors=True)
    return str(path)


def _inner_options() -> dict[str, Any]:
    """Options of the innermost functions.

    They allocate nothing, so counting references to their array arguments only costs time: four
    times the whole integration. The switch is private to numba, hence the trial.
    """
    options: dict[str, Any] = {"error_model": "numpy", "forceinline": True, "_nrt": False}
    try:
        numba.njit(**options)(_inner_options)
    except (KeyError, TypeError):
        del options["_nrt"]
    return options


_OPTIONS = _inner_options()


def inner(function: F) -> F:
    """Compile a function that other compiled functions call and that allocates no array."""
    return cast(F, numba.njit(**_OPTIONS)(function))


def entry(function: F) -> F:
    """Compile a function that Python calls, cached on disk under the hash of all sources."""
    directory = _cache_directory()
    if not directory:
        return cast(F, numba.njit(error_model="numpy")(function))
    settings = vars(numba.config)
    before, settings["CACHE_DIR"] = settings["CACHE_DIR"], directory
    try:
        return cast(F, numba.njit(cache=True, error_model="numpy")(function))
    finally:
        settings["CACHE_DIR"] = before
