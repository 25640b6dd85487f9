"""Compiled functions on disk, where each is compiled by one process: others that want it wait, and read it.

A graph starts six processes at once, three of them observers that run the same functions. Each compiled all of them,
and a first start on two cores took half as long again.
"""

from __future__ import annotations

import hashlib
import os
import pickle
import sys
from collections.abc import Callable
from pathlib import Path
from typing import Any, TypeVar, cast

import numba

from er_models.cache import sealed
from er_models.cache.folder import state_folder, tell
from er_models.cache.lock import locked
from er_models.cache.sources import state

F = TypeVar("F", bound=Callable[..., Any])
_NUMBA: Any = numba.core
"""Untyped: what a cache needs of it is typed in part."""


class Kept:
    """What a function was compiled to, for each signature a file; asked by Numba's dispatcher as its own cache is.

    Files are named after all sources (`er_models.cache.sources`) and sealed (`er_models.cache.sealed`).
    """

    def __init__(self, function: Callable[..., Any], folder: Path, own: str) -> None:
        """own: digest of a module that belongs to no package."""
        self._folder = folder
        self._lock: int | None = None
        line = function.__code__.co_firstlineno
        self._name = f"{function.__module__}.{function.__qualname__}-{line}"
        self._versions = (numba.__version__, sys.implementation.cache_tag, own)

    @property
    def cache_path(self) -> str:
        """Folder of the files."""
        return str(self._folder)

    def load_overload(self, sig: Any, target_context: Any) -> Any:
        """What is compiled for a signature; None: compile it, nobody else does meanwhile."""
        target_context.refresh()
        name = self._file(sig, target_context.codegen())
        found = sealed.read(self._folder, name)
        if found is None and self._lock is None:
            self._lock = locked(self._folder / f"{self._name}.lock")
            found = sealed.read(self._folder, name)
            if found is not None:
                self._let_go()
        if found is None:
            return None
        return _NUMBA.compiler.CompileResult._rebuild(target_context, *pickle.loads(found))

    def save_overload(self, sig: Any, result: Any) -> None:
        """Put it in, for all who wait."""
        try:
            if not result.library.has_dynamic_globals:
                name = self._file(sig, result.codegen)
                sealed.write(self._folder, name, _NUMBA.serialize.dumps(result._reduce()))
        except OSError as error:
            tell(self._folder, f"{error.strerror}: compiled code is not kept")
        finally:
            self._let_go()

    def flush(self) -> None:
        """Asked for before a function is compiled anew: the file is written over."""

    def _file(self, sig: Any, codegen: Any) -> str:
        """Name of the file of a signature."""
        what = (*_NUMBA.sigutils.normalize_signature(sig), codegen.magic_tuple(), self._versions)
        return f"{self._name}.{hashlib.sha256(repr(what).encode()).hexdigest()[:16]}.compiled"

    def _let_go(self) -> None:
        if self._lock is not None:
            os.close(self._lock)
            self._lock = None


def on_disk(**options: Any) -> Callable[[F], F]:
    """A decorator as `numba.njit` with these options, which keeps what is compiled on disk.

    Kept in memory alone is a function of no file, or one that refers to variables of another function.
    """

    def decorate(function: F) -> F:
        dispatcher: Any = numba.njit(**options)(function)
        if os.path.isfile(function.__code__.co_filename) and not function.__closure__:
            name, own = state(function.__module__)
            dispatcher._cache = Kept(function, state_folder(name), own)
        return cast(F, dispatcher)

    return decorate
