"""How the loops of observers and filters are compiled, and where the result is kept.

numba looks whether the file of a function has changed, not whether those of the functions it calls
have. Compiled code is therefore kept in a folder that is named after all files that hold any.
"""

from __future__ import annotations

import hashlib
from collections.abc import Callable
from functools import lru_cache
from pathlib import Path
from typing import Any, TypeVar, cast

import numba
from er_models.compiled_once import on_disk
from er_models.kernel.load import cache_folder

F = TypeVar("F", bound=Callable[..., object])
_CONFIG: Any = numba.config
_FOLDERS = ("faults", "observers", "peers")


def compiled(function: F) -> F:
    """The function compiled, on disk where there is a place for it and in memory where not."""
    before = _CONFIG.CACHE_DIR
    _CONFIG.CACHE_DIR = str(_folder())
    try:
        return cast(F, on_disk(error_model="numpy")(function))
    except (RuntimeError, OSError):  # numba finds no folder it may write to
        return cast(F, numba.njit(error_model="numpy")(function))
    finally:
        _CONFIG.CACHE_DIR = before


@lru_cache(maxsize=1)
def _folder() -> Path:
    """Folder of this state of the sources."""
    return cache_folder() / "er_observers" / digest_of(Path(__file__).parents[1])


def digest_of(package: Path) -> str:
    """Hash of every file that may hold compiled functions."""
    total = hashlib.sha256()
    for path in sorted(p for name in _FOLDERS for p in (package / name).glob("*.py")):
        total.update(path.name.encode() + b"\0" + path.read_bytes())
    return total.hexdigest()[:16]
