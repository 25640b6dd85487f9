"""Where compiled code is kept: it is executed, so nobody else may write there."""

from __future__ import annotations

import atexit
import contextlib
import logging
import os
import shutil
import tempfile
from functools import lru_cache
from pathlib import Path

from er_models.cache.owned import OTHERS_READ, demand_owned, make_private

STATES = 20
"""States of a package's sources that are kept, those last used: of the last changes, and of other checkouts."""
_LOG = logging.getLogger(__name__)


def cache_folder() -> Path:
    """Folder of compiled code, `er_models` in ER_CACHE_DIR, else in the user's cache; writable by this user alone.

    Without a home, or where that folder belongs to somebody else or cannot be written to (one line says so), it is
    the folder of this login (XDG_RUNTIME_DIR), else one of this process, which its end removes.
    """
    base = os.environ.get("ER_CACHE_DIR") or os.environ.get("XDG_CACHE_HOME")
    if not base and (home := os.environ.get("HOME")):
        base = os.path.join(home, ".cache")
    return _settled(os.path.abspath(base)) if base else _private()


def state_folder(name: str) -> Path:
    """Folder in the cache folder for a state of a package's sources, named `package-digest`; made where it can be."""
    return _made(cache_folder() / name)


@lru_cache
def _made(folder: Path) -> Path:
    try:
        make_private(folder)
        os.utime(folder)
    except OSError as error:
        tell(folder, f"{error.strerror}: compiled code is not kept")
        return folder
    with contextlib.suppress(OSError):  # another process may remove the same ones
        states = folder.parent.glob(f"{folder.name.rpartition('-')[0]}-*")
        for old in sorted(states, key=lambda each: each.stat().st_mtime)[:-STATES]:
            shutil.rmtree(old, ignore_errors=True)
    return folder


@lru_cache
def _settled(base: str) -> Path:
    """The folder in this place, or another one where it is of no use; found out once."""
    folder = Path(base) / "er_models"
    try:
        make_private(folder)
    except OSError as error:
        other = _private()
        tell(folder, f"{error.strerror}; compiled code is kept in {other}")
        return other
    return folder


@lru_cache
def _private() -> Path:
    """A folder of this login, or a fresh one of this process; both nobody else can even look into."""
    if given := os.environ.get("XDG_RUNTIME_DIR"):
        try:
            demand_owned(os.stat(given), OTHERS_READ)
            make_private(folder := Path(given) / "er_models")
        except OSError:
            pass
        else:
            return folder
    folder = Path(tempfile.mkdtemp(prefix="er_models_"))
    atexit.register(_remove, folder, os.getpid())
    return folder


def _remove(folder: Path, owner: int) -> None:
    """Remove a folder at the end of the process that made it, not at that of its children."""
    if os.getpid() == owner:
        shutil.rmtree(folder, ignore_errors=True)


@lru_cache
def tell(place: Path, reason: str) -> None:
    """Say in one line, and once, what is wrong with a file or folder of the cache."""
    _LOG.warning("%s: %s", place, reason)
