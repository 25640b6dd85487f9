"""Brings measured data sets into the contract's columns, units and signs."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

from er_models.errors import InputError, UnknownName
from er_records.clean import clean
from er_records.record import Record

from er_studies.importers import mts, piston_seal, shaking_table


@dataclass(frozen=True, slots=True)
class Importer:
    """A kind of data set: its files, how to read one or a whole folder, the part a run is in."""

    pattern: str
    read_file: Callable[[Path], list[Record]]
    read_folder: Callable[[Path], list[Record]] | None = None
    part_of: Callable[[str], str] = lambda _: ""


IMPORTERS: dict[str, Importer] = {
    "mts": Importer("*Hz*.txt", mts.read, part_of=mts.split),
    "shaking_table": Importer("*.mat", shaking_table.read, shaking_table.read_folder),
    "piston_seal": Importer("*_*bar.csv", piston_seal.read),
}


def import_data(
    kind: str, path: Path, progress: Callable[[Sequence[Path]], Iterable[Path]] = iter
) -> list[Record]:
    """Checked records of a measured data set.

    Args:
        kind: A key of `IMPORTERS`.
        path: Folder of the data set, or one of its files.
        progress: Wraps the list of files, for a progress bar.

    Raises:
        UnknownName: No such kind.
        InputError: Nothing there, or a file that is not as the data set's are.
    """
    if kind not in IMPORTERS:
        raise UnknownName("kind of data", kind, tuple(IMPORTERS))
    importer = IMPORTERS[kind]
    if not path.exists():
        raise InputError(path, "", "a file or folder", "nothing there")
    if path.is_dir() and importer.read_folder is not None:
        raw = importer.read_folder(path)
    else:
        files = sorted(path.glob(importer.pattern)) if path.is_dir() else [path]
        if not files:
            raise InputError(path, "", f"files {importer.pattern}", "none")
        raw = [record for file in progress(files) for record in importer.read_file(file)]
    return [_settled(piece) for record in raw for piece in clean(record)]


def _settled(record: Record) -> Record:
    """A piece that is whole in itself: the pauses of the rig are noted, nothing is missing."""
    return replace(record, complete=True)


def part_of(kind: str, record: Record) -> str:
    """Part of its data set a record belongs to (`train`, ...); '' where the set has no parts."""
    return IMPORTERS[kind].part_of(record.name)
