"""Files and folders of this user: what nobody else can have put something into."""

from __future__ import annotations

import os
import stat
import tempfile
from collections.abc import Collection
from pathlib import Path

OTHERS_READ, OTHERS_WRITE, ALL_WRITE = 0o077, 0o022, 0o002
"""Bits of a mode: what others than the owner may do; what everybody on the machine may do."""


def read_owned(
    path: Path, refused: int = OTHERS_WRITE, also: Collection[int] = (), largest: int = 1 << 28
) -> bytes:
    """Content of an ordinary file of this user or of root, looked at and read through one handle.

    refused: bits its mode must not have; also: further owners; largest: its size at most [bytes].

    Raises:
        OSError: It cannot be read, and PermissionError with the reason where it must not be.
    """
    handle = os.open(path, os.O_RDONLY | os.O_NOFOLLOW | os.O_NONBLOCK | os.O_CLOEXEC)
    with os.fdopen(handle, "rb", closefd=True) as file:
        found = os.fstat(handle)
        if not stat.S_ISREG(found.st_mode):
            raise PermissionError(0, "it is no ordinary file")
        demand_owned(found, refused, also)
        content = file.read(largest + 1)
    if len(content) > largest:
        raise PermissionError(0, f"it has more than {largest} bytes")
    return content


def demand_owned(
    found: os.stat_result, refused: int = OTHERS_WRITE, also: Collection[int] = ()
) -> None:
    """Raise PermissionError where somebody else owns it, or where its mode has one of the refused bits."""
    if found.st_uid not in {0, os.geteuid(), *also}:
        raise PermissionError(0, "it belongs to another user")
    if found.st_mode & refused:
        raise PermissionError(0, "others may write to it")


def make_private(folder: Path) -> None:
    """Make a folder to which this user alone may write, or close one of this user's to others.

    Raises:
        OSError: It cannot be written to, and PermissionError where it belongs to somebody else.
    """
    folder.parent.mkdir(parents=True, exist_ok=True)
    folder.mkdir(mode=0o700, exist_ok=True)
    if {folder.lstat().st_uid, folder.stat().st_uid} != {os.geteuid()}:
        raise PermissionError(0, "it belongs to another user")
    if folder.stat().st_mode & OTHERS_WRITE:
        folder.chmod(0o700)
    with tempfile.TemporaryFile(dir=folder):
        pass
