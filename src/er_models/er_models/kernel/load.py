"""Imports the kernel of a catalogue from a cache folder, generating and compiling it once."""

from __future__ import annotations

import importlib.util
import os
import sys
import tempfile
from functools import lru_cache
from pathlib import Path
from types import ModuleType

from er_models.catalogue import Catalogue
from er_models.kernel import hooks
from er_models.kernel.compose import fingerprint, source


def cache_folder() -> Path:
    """Folder of generated kernels: ER_CACHE_DIR, else the user's cache, else a temporary one."""
    choices = [os.environ.get("ER_CACHE_DIR"), os.environ.get("XDG_CACHE_HOME")]
    base = next((Path(c) for c in choices if c), Path.home() / ".cache")
    folder = base / "er_models"
    try:
        folder.mkdir(parents=True, exist_ok=True)
        with tempfile.TemporaryFile(dir=folder):
            return folder
    except OSError:
        fallback = Path(tempfile.gettempdir()) / f"er_models_{os.getuid()}"
        fallback.mkdir(parents=True, exist_ok=True)
        return fallback


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


def _write(path: Path, text: str) -> None:
    """Write so that a second process never sees half a file."""
    handle, temporary = tempfile.mkstemp(dir=path.parent, suffix=".tmp")
    with os.fdopen(handle, "w", encoding="utf-8") as file:
        file.write(text)
    os.replace(temporary, path)
