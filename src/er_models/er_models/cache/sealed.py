"""Files that this user wrote and nobody has changed since: what may be unpickled and executed.

A file is used when it, its folder and the cache folder belong to this user or to root, when nobody else may write to
them, and when the file begins with its seal: a digest (BLAKE2b) of its name and content under the key of the cache
folder, which this user alone can read. Any other file counts as absent, and one line says so.

That keeps out what other users of the machine put there, changed or exchanged while modes allowed it, and files that
were damaged or half written. It does not keep out who may act as this user or as root, nor a whole cache folder, key
and all, that this user took over from somewhere else.
"""

from __future__ import annotations

import hashlib
import hmac
import os
import tempfile
from functools import lru_cache
from pathlib import Path

from er_models.cache.folder import tell
from er_models.cache.lock import locked
from er_models.cache.owned import OTHERS_READ, demand_owned, make_private, read_owned

SEAL = KEY = 32
"""Lengths of a seal and of the key [bytes]."""


def read(folder: Path, name: str) -> bytes | None:
    """Content of a sealed file in a folder of the cache folder; None where there is none that may be used."""
    try:
        content = memoryview(read_owned(folder / name))
        for each in (folder, folder.parent):
            demand_owned(each.stat())
        if not hmac.compare_digest(content[:SEAL], _seal(folder, name, content[SEAL:])):
            raise PermissionError(0, "it is not as this user has written it")
    except FileNotFoundError:
        return None
    except OSError as error:
        tell(folder, f"a file is not used, and made anew: {error.strerror}")
        return None
    return bytes(content[SEAL:])


def write(folder: Path, name: str, content: bytes) -> None:
    """Seal a file and put it in its place, whole at once; OSError where that cannot be."""
    make_private(folder)
    put(folder / name, _seal(folder, name, memoryview(content)) + content)


def put(path: Path, content: bytes) -> None:
    """Write a file for this user alone so that a second process never sees half of it."""
    handle, temporary = tempfile.mkstemp(dir=path.parent, suffix=".tmp")
    try:
        with os.fdopen(handle, "wb") as file:
            file.write(content)
        os.replace(temporary, path)
    except OSError:
        os.unlink(temporary)
        raise


def _seal(folder: Path, name: str, content: memoryview) -> bytes:
    place = f"{folder.name}/{name}\0".encode()
    found = hashlib.blake2b(place, key=_key(folder.parent), digest_size=SEAL)
    found.update(content)
    return found.digest()


@lru_cache
def _key(root: Path) -> bytes:
    """Key of a cache folder, the same for all processes; one of this process where none can be kept."""
    path = root / "key"
    if not (key := _found(path)):
        lock = locked(root / "key.lock")
        try:
            if not (key := _found(path)):
                put(path, key := os.urandom(KEY))
        except OSError:
            pass
        finally:
            if lock is not None:
                os.close(lock)
    return key


def _found(path: Path) -> bytes:
    """The key of this file; none where others could have read or written it."""
    try:
        key = read_owned(path, OTHERS_READ)
    except OSError:
        return b""
    return key if len(key) == KEY else b""
