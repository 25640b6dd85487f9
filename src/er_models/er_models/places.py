"""Where results go: places that can be written, and that are none of what the command reads or else writes."""

from __future__ import annotations

import tempfile
from collections.abc import Callable, Hashable, Mapping, Sequence
from pathlib import Path

from er_models.errors import InputError


def writable(
    files: Mapping[str, Path | None],
    report: Path | None = None,
    read: Mapping[str, Sequence[Path]] | None = None,
    opened: Callable[[str, Path], Sequence[Path]] = lambda _, path: (path,),
) -> None:
    """Refuse places that cannot be written, or must not be, before minutes are spent on what would go there.

    files: option to the file it writes; report: folder of the report; read: argument or option to the paths it reads;
    opened: every file that reading such a path, given to such an argument, opens. Nothing is left behind, also no
    folder.

    Raises:
        InputError: A place is a folder, takes no file, is read, or is that of two results.
    """
    taken = _taken(read or {}, opened)
    for option, path in files.items():
        if path is not None:
            if path.is_dir():
                raise InputError(path, option, "a file name", "a folder")
            _take(taken, path, option, path)
            _may_write(path, option, path.parent)
    if report is not None:
        for place in (report, report / "index.html"):
            _take(taken, place, "--report", report)
        _may_write(report, "--report", report)


def _take(taken: dict[Hashable, tuple[str, str]], place: Path, option: str, named: Path) -> None:
    """Take a place for an option, under which the path `named` was given; refuse one that is taken."""
    before, what = taken.setdefault(_identity(place), (option, "the same place"))
    if before != option:
        raise InputError(named, option, f"another place than {before}", what)


def _taken(
    read: Mapping[str, Sequence[Path]], opened: Callable[[str, Path], Sequence[Path]]
) -> dict[Hashable, tuple[str, str]]:
    """What is read: identity to the argument it belongs to, and what to say of a result that goes there."""
    found: dict[Hashable, tuple[str, str]] = {}
    for argument, paths in read.items():
        for path in paths:
            for place in opened(argument, path):
                what = "the same place" if place == path else f"{place}, which is read"
                found.setdefault(_identity(place), (argument, what))
    return found


def _identity(path: Path) -> Hashable:
    """The same for two paths to one file, whatever links lead there."""
    try:
        found = path.stat()
    except OSError:
        return path.resolve()
    return found.st_dev, found.st_ino


def _may_write(path: Path, option: str, folder: Path) -> None:
    """Whether the nearest folder that exists takes a file."""
    while not folder.exists() and folder != folder.parent:
        folder = folder.parent
    try:
        with tempfile.TemporaryFile(dir=folder):
            pass
    except OSError as error:
        found = error.strerror or str(error)
        raise InputError(
            path, option, "a folder that can be written", f"{found} ({folder})"
        ) from None
