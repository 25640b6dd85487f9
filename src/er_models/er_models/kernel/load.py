"""Imports the kernel of a catalogue from a cache folder, generating and compiling it once."""

from __future__ import annotations

import importlib.util
import os
import sys
import tempfile
from functools import lru_cache
from pathlib import Path
from types import ModuleType

import numpy as np
from numpy.typing import NDArray

from er_models.catalogue import Catalogue
from er_models.kernel import hooks
from er_models.kernel.compose import fingerprint, source


def cache_folder() -> Path:
    """Folder of generated kernels: ER_CACHE_DIR, else the user's cache, else one of this process.

    The last is for where neither can be written to; it is compiled anew each time.
    """
    for name in ("ER_CACHE_DIR", "XDG_CACHE_HOME", "HOME"):
        if os.environ.get(name):
            base = Path(os.environ[name]) / (".cache" if name == "HOME" else "")
            folder = base / "er_models"
            return folder if _writable(folder) else _own_folder()
    return _own_folder()


def _writable(folder: Path) -> bool:
    """Whether files can be made in a folder, which is made when it is absent."""
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return True
    except OSError:
        return False


@lru_cache(maxsize=1)
def _own_folder() -> Path:
    """A fresh folder that nobody else can write to: code is run from it."""
    return Path(tempfile.mkdtemp(prefix="er_models_"))


@lru_cache(maxsize=8)
def kernel(catalogue: Catalogue) -> ModuleType:
    """Kernel module of a catalogue; written to the cache folder when it is new."""
    name = f"er_kernel_{fingerprint(catalogue)}"
    path = cache_folder() / f"{name}.py"
    if not path.exists():
        _write(path, source(catalogue))
    spec = importlib.util.spec_from_file_location(name, path)
    if spec is None or spec.loader is None:
        raise ImportError(f"cannot load the kernel from {path}")
    module = importlib.util.module_from_spec(spec)
    sys.modules[name] = module
    hooks.use(catalogue)
    spec.loader.exec_module(module)
    return module


def plain(samples: NDArray[np.float64]) -> NDArray[np.float64]:
    """Samples as the kernels are compiled for: contiguous and writable; a copy where they are not.

    Read-only samples are another type to Numba, and a type of its own is a compilation of its own, seconds long.
    """
    flags = samples.flags
    return samples if flags.c_contiguous and flags.writeable else np.array(samples)


def _write(path: Path, text: str) -> None:
    """Write so that a second process never sees half a file."""
    handle, temporary = tempfile.mkstemp(dir=path.parent, suffix=".tmp")
    with os.fdopen(handle, "w", encoding="utf-8") as file:
        file.write(text)
    os.replace(temporary, path)
