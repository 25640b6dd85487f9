"""Loads measurements: finds the reader for each path, checks and repairs what it returns."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from er_common.extras import extra
from er_models.errors import InputError

from er_records.clean import clean
from er_records.copies import used_once
from er_records.provenance import fingerprint as fingerprint
from er_records.readers import csv, mat, mf4, parquet, sheet, tdms
from er_records.readers.bag_files import METADATA, is_data
from er_records.readers.names import Given, Names, names_file, names_of, parsed, read_names
from er_records.readers.table import Table
from er_records.readers.table import record as record_of
from er_records.record import Record

Reader = Callable[[Path, Names], list[Record]]


def _bag(path: Path, names: Names) -> list[Record]:
    """Records of a bag."""
    with extra("er_records[bags]", f"{path}: a bag"):
        from er_records.readers import rosbag

    return rosbag.read(path, names)


def _by(table: Callable[[Path], Table]) -> Reader:
    """The reader of a format whose files are one table each."""
    return lambda path, names: [record_of(table(path), names)]


TABLES: dict[str, Callable[[Path], Table]] = {
    ".csv": csv.table, ".tsv": csv.table, ".txt": csv.table, ".dat": csv.table, ".asc": csv.table, ".lvm": csv.table,
    ".parquet": parquet.table, ".mf4": mf4.table, ".mat": mat.table, ".tdms": tdms.table,
    ".xlsx": sheet.table, ".xls": sheet.table, ".ods": sheet.table,
}  # fmt: skip
"""Suffix to what reads the columns of a file."""
READERS: dict[str, Reader] = {
    **{suffix: csv.read if table is csv.table else _by(table) for suffix, table in TABLES.items()},
    ".mcap": _bag,
    ".db3": _bag,
}
"""Suffix to reader; a folder with metadata.yaml, .mcap or .db3 inside is a rosbag2 folder."""
NOT_ALWAYS_DATA: dict[str, Callable[[Path], bool]] = {
    **dict.fromkeys((".txt", ".dat", ".asc"), csv.is_table),
    **dict.fromkeys((".xlsx", ".xls", ".ods"), sheet.is_table),
}
"""Suffixes that notes, licences and lists of runs have, too, and what tells whether a file of a folder is data."""

BAG_SUFFIXES = (".mcap", ".db3")


def load(paths: Sequence[Path], names: Given | Names | Path | str | None = None) -> list[Record]:
    """Records of all paths, checked and repaired, in the order given (folders sorted by name), copies left out.

    names: what the files' own columns are, by channel, or a YAML file that says so (`er_records.readers.names`);
    without it a file `DATA.names.yaml` beside a data file or the `names.yaml` of its folder.

    Raises:
        InputError: A path that is absent, of unknown kind, empty, damaged, or implausible.
        MissingChannel: A recording without any sensor topic.
    """
    if not paths:
        raise InputError("DATA", "", "at least one file or folder", "none")
    own = _given(names)
    records = [piece for path in paths for raw in read(Path(path), own) for piece in clean(raw)]
    return told_apart(used_once(records))


def _given(names: Given | Names | Path | str | None) -> Names | None:
    """Names that a caller gives."""
    if isinstance(names, str | Path):
        return read_names(Path(names), lenient=True)
    return None if names is None else parsed(names, lenient=True)


def read(path: Path, names: Names | None = None) -> list[Record]:
    """Records of one path as stored: neither checked nor repaired; names: instead of those beside the files."""
    if not path.exists():
        raise InputError(path, "", "a file or folder", "nothing there")
    if path.is_dir() and not is_bag(path):
        return _read_folder(path, names)
    own = names or names_of(path)
    return [replace(record, file=str(path)) for record in _read_one(path, own)]


def _read_one(path: Path, names: Names) -> list[Record]:
    """Records of one file or rosbag2 folder."""
    if path.is_dir():
        return _bag(path, names)
    reader = READERS.get(path.suffix.lower())
    if reader is None:
        raise InputError(path, "suffix", f"one of {', '.join(READERS)}", f"'{path.suffix}'")
    if path.stat().st_size == 0:
        raise InputError(path, "", "data", "an empty file")
    return reader(path, names)


def is_bag(folder: Path) -> bool:
    """Whether a folder is a rosbag2 recording."""
    if (folder / METADATA).exists():
        return True
    return any(item.suffix in BAG_SUFFIXES for item in folder.iterdir())


def _read_folder(folder: Path, names: Names | None) -> list[Record]:
    """Records of all readable files and recordings in a folder and its folders, sorted by name."""
    wanted = recordings(folder)
    if not wanted:
        inside = ", ".join(map(_seen, sorted(folder.iterdir())[:8]))
        expected = f"files ending in {', '.join(READERS)}, or a rosbag2 folder"
        raise InputError(folder, "", expected, inside or "an empty folder")
    return [record for item in wanted for record in _read_in(folder, item, names)]


def _seen(item: Path) -> str:
    """What an item of a folder is that nothing is read from."""
    if item.is_dir():
        return f"{item.name}/"
    return f"{item.name} (no measurement)" if item.suffix.lower() in NOT_ALWAYS_DATA else item.name


def recordings(path: Path) -> list[Path]:
    """Files and rosbag2 folders that `read` takes measurements from: the path itself, or what a folder holds."""
    return list(_data_in(path)) if path.is_dir() and not is_bag(path) else [path]


def files_of(recording: Path) -> list[Path]:
    """Every file that reading a recording opens."""
    if recording.is_dir():
        inside = [f for f in recording.iterdir() if is_data(f) or f.name == METADATA]
        return inside + _mapping(recording)
    files = [recording]
    if recording.suffix in BAG_SUFFIXES:
        files.append(recording.with_name(METADATA))
    return [f for f in files if f.exists()] + _mapping(recording)


def _mapping(recording: Path) -> list[Path]:
    """The file that says what the columns of a recording are, if there is one."""
    found = names_file(recording)
    return [] if found is None else [found]


def _read_in(folder: Path, item: Path, names: Names | None) -> list[Record]:
    """Records of an item that nobody named, but the folder it lies in."""
    try:
        return read(item, names)
    except InputError as error:
        found = f"{error.found} (no measurement? then name the files of {folder} that are)"
        raise InputError(error.path, error.key, error.expected, found, error.cure) from None


def _data_in(folder: Path) -> Iterator[Path]:
    """Readable files and recordings in a folder and its folders, in order; hidden ones are left out."""
    for item in sorted(folder.iterdir()):
        if item.name.startswith("."):
            continue
        if item.is_dir() and not is_bag(item):
            yield from _data_in(item)
        elif item.is_dir() or _is_recording(item):
            yield item


def _is_recording(file: Path) -> bool:
    """Whether a file of a folder is taken for a measurement by its suffix."""
    suffix = file.suffix.lower()
    return suffix in READERS and (suffix not in NOT_ALWAYS_DATA or NOT_ALWAYS_DATA[suffix](file))


def told_apart(records: list[Record]) -> list[Record]:
    """The records with equal names told apart by their folder, then by a number."""
    by_folder = _renamed(records, lambda r, _: f"{Path(r.file or r.source).parent.name}/{r.name}")
    return _renamed(by_folder, lambda r, number: f"{r.name}~{number}")


def _renamed(records: list[Record], name: Callable[[Record, int], str]) -> list[Record]:
    """The records, those that share a name renamed by it and their number among each other."""
    counts = Counter(record.name for record in records)
    seen: Counter[str] = Counter()
    renamed = []
    for record in records:
        seen[record.name] += 1
        if counts[record.name] > 1:
            record = replace(record, name=name(record, seen[record.name]))
        renamed.append(record)
    return renamed
