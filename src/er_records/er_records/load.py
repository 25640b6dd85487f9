"""Loads measurements: finds the reader for each path, checks and repairs what it returns."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

import yaml
from er_common.extras import extra
from er_models.errors import InputError

from er_records.clean import clean
from er_records.copies import used_once
from er_records.provenance import fingerprint as fingerprint
from er_records.readers import columns, csv, mf4, parquet
from er_records.readers.bag_files import METADATA, is_data
from er_records.record import Record

Reader = Callable[[Path, Mapping[str, str] | None], list[Record]]


def _bag(path: Path, _: Mapping[str, str] | None = None) -> list[Record]:
    """Records of a bag."""
    with extra("er_records[bags]", f"{path}: a bag"):
        from er_records.readers import rosbag

    return rosbag.read(path)


READERS: dict[str, Reader] = {
    ".csv": csv.read,
    ".tsv": csv.read,
    ".parquet": parquet.read,
    ".mf4": mf4.read,
    ".mcap": _bag,
    ".db3": _bag,
}
"""Suffix to reader; a folder with metadata.yaml, .mcap or .db3 inside is a rosbag2 folder."""

BAG_SUFFIXES = (".mcap", ".db3")


def load(paths: Sequence[Path]) -> list[Record]:
    """Records of all paths, checked and repaired, in the order given (folders sorted by name), copies left out.

    A file `DATA.names.yaml` beside a data file maps contract names to the names in that file.

    Raises:
        InputError: A path that is absent, of unknown kind, empty, damaged, or implausible.
        MissingChannel: A recording without any sensor topic.
    """
    if not paths:
        raise InputError("DATA", "", "at least one file or folder", "none")
    records = [piece for path in paths for raw in read(Path(path)) for piece in clean(raw)]
    return told_apart(used_once(records))


def read(path: Path) -> list[Record]:
    """Records of one path as stored: neither checked nor repaired."""
    if not path.exists():
        raise InputError(path, "", "a file or folder", "nothing there")
    if path.is_dir() and not is_bag(path):
        return _read_folder(path)
    return [replace(record, file=str(path)) for record in _read_one(path)]


def _read_one(path: Path) -> list[Record]:
    """Records of one file or rosbag2 folder."""
    if path.is_dir():
        return _bag(path)
    reader = READERS.get(path.suffix.lower())
    if reader is None:
        raise InputError(path, "suffix", f"one of {', '.join(READERS)}", f"'{path.suffix}'")
    if path.stat().st_size == 0:
        raise InputError(path, "", "data", "an empty file")
    return reader(path, _names(path))


def is_bag(folder: Path) -> bool:
    """Whether a folder is a rosbag2 recording."""
    if (folder / METADATA).exists():
        return True
    return any(item.suffix in BAG_SUFFIXES for item in folder.iterdir())


def _read_folder(folder: Path) -> list[Record]:
    """Records of all readable files and recordings in a folder and its folders, sorted by name."""
    wanted = recordings(folder)
    if not wanted:
        inside = ", ".join(
            item.name + "/" * item.is_dir() for item in sorted(folder.iterdir())[:8]
        )
        expected = f"files ending in {', '.join(READERS)}, or a rosbag2 folder"
        raise InputError(folder, "", expected, inside or "an empty folder")
    return [record for item in wanted for record in _read_in(folder, item)]


def recordings(path: Path) -> list[Path]:
    """Files and rosbag2 folders that `read` takes measurements from: the path itself, or what a folder holds."""
    return list(_data_in(path)) if path.is_dir() and not is_bag(path) else [path]


def files_of(recording: Path) -> list[Path]:
    """Every file that reading a recording opens."""
    if recording.is_dir():
        return [f for f in recording.iterdir() if is_data(f) or f.name == METADATA]
    files = [recording, _names_file(recording)]
    if recording.suffix in BAG_SUFFIXES:
        files.append(recording.with_name(METADATA))
    return [f for f in files if f.exists()]


def _read_in(folder: Path, item: Path) -> list[Record]:
    """Records of an item that nobody named, but the folder it lies in."""
    try:
        return read(item)
    except InputError as error:
        found = f"{error.found} (no measurement? then name the files of {folder} that are)"
        raise InputError(error.path, error.key, error.expected, found) from None


def _data_in(folder: Path) -> Iterator[Path]:
    """Readable files and recordings in a folder and its folders, in order; hidden ones are left out."""
    for item in sorted(folder.iterdir()):
        if item.name.startswith("."):
            continue
        if item.is_dir() and not is_bag(item):
            yield from _data_in(item)
        elif item.is_dir() or item.suffix.lower() in READERS:
            yield item


def _names(path: Path) -> Mapping[str, str] | None:
    """Contract name to name in the file, from the YAML file beside it; None when there is none."""
    beside = _names_file(path)
    if not beside.exists():
        return None
    try:
        names = yaml.safe_load(beside.read_text(encoding="utf-8"))
    except (yaml.YAMLError, UnicodeDecodeError) as error:
        raise InputError(beside, "", "YAML", " ".join(str(error).split())) from None
    if not isinstance(names, dict) or not all(
        isinstance(key, str) and isinstance(value, str) for key, value in names.items()
    ):
        raise InputError(beside, "", "lines 'deflection: name in the file'", type(names).__name__)
    return names


def _names_file(path: Path) -> Path:
    """Where the names of a data file's columns are looked for."""
    return path.with_name(path.name + columns.NAMES_SUFFIX)


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
