"""Where recordings lie: on this machine, or behind a URL that fsspec reads; each is fetched where it is worked on."""

from __future__ import annotations

import tempfile
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from er_common.extras import extra
from er_models.errors import ErError, InputError
from er_records.load import READERS, files_of
from er_records.provenance import digest_files

LASTING = (FileNotFoundError, IsADirectoryError, NotADirectoryError, PermissionError)
"""What an operating system says that will be the same another time."""


class Unreachable(ErError):
    """A recording that cannot be had now, but perhaps another time: a network, a full disk, a file that changes."""


def is_url(path: str) -> bool:
    """Whether a path names its protocol, as s3:// does."""
    return "://" in path


def filesystem(url: str) -> tuple[Any, str]:
    """The file system of a URL, and the path in it.

    Raises:
        ErError: fsspec is not installed.
        InputError: There is no such protocol, or what reads it is not installed.
    """
    with extra("er_model_lab[fleet]", f"{url}: a URL"):
        from fsspec.core import url_to_fs
    try:
        found: tuple[Any, str] = url_to_fs(url)
    except (ImportError, ValueError) as error:
        protocol = url.partition("://")[0]
        expected = f"a protocol that fsspec reads, with its package installed ({protocol})"
        raise InputError(url, "", expected, " ".join(str(error).split())) from None
    return found


def is_folder(files: Any, inner: str) -> bool:
    """Whether a path of a file system is a folder; a name like a file's is one, since HTTP would send all of it."""
    return Path(inner).suffix.lower() not in READERS and bool(files.isdir(inner))


@contextmanager
def reached(path: str) -> Iterator[None]:
    """What a file system says within it becomes an error of the recording.

    Raises:
        InputError: It is not there, or may not be read.
        Unreachable: It cannot be had now.
    """
    try:
        yield
    except ErError:
        raise
    except Exception as error:  # each protocol has its own
        raise _unread(path, error) from None


@contextmanager
def local(path: str) -> Iterator[Path]:
    """The recording as a file or folder of this machine; what is fetched for it vanishes again.

    Raises:
        InputError: It is not there, or may not be read.
        Unreachable: It cannot be fetched now.
    """
    if not is_url(path):
        yield Path(path)
        return
    files, inner = filesystem(path)
    with tempfile.TemporaryDirectory(prefix="er_fleet_") as folder:
        target = Path(folder, Path(inner).name)
        with reached(path):
            if is_folder(files, inner):
                files.get(inner, str(target), recursive=True)
            else:
                files.get_file(inner, str(target))
        yield target


def token(path: str) -> str:
    """What changes when a recording is written anew, without reading it; "" where nothing tells."""
    try:
        if is_url(path):
            files, inner = filesystem(path)
            return (
                _http_token(files.info(inner))
                if "http" in files.protocol
                else str(files.ukey(inner))
            )
        found = [each.stat() for each in files_of(Path(path))]
    except Exception:  # each protocol has its own; whoever reads the recording says what is wrong
        return ""
    return " ".join(f"{s.st_ino}:{s.st_size}:{s.st_mtime_ns}" for s in found)


def _http_token(info: dict[str, Any]) -> str:
    """What a server says of the state of a file; fsspec's own key of a URL never changes."""
    told = [
        str(info[key]) for key in ("ETag", "Content-MD5", "Digest", "Last-Modified") if key in info
    ]
    return " ".join([*told, str(info.get("size"))]) if told else ""


def content(place: Path) -> str:
    """SHA-256 of every file that reading a recording opens.

    Raises:
        InputError: It is not there, or may not be read.
        Unreachable: It cannot be read now.
    """
    try:
        files = files_of(place)
        if not files:
            raise InputError(place, "", "a recording", "nothing there")
        return digest_files(sorted(files))
    except OSError as error:
        raise _unread(place, error) from None


def _unread(path: str | Path, error: Exception) -> ErError:
    """What a file system says of a recording: for good, or for now."""
    own = error.strerror if isinstance(error, OSError) else None
    said = own or " ".join(str(error).split()) or type(error).__name__
    if isinstance(error, LASTING):
        return InputError(path, "", "a recording that can be read", said)
    return Unreachable(f"{path}: {said}")
