"""The files of a rosbag2 recording and what its metadata.yaml says about them."""

from __future__ import annotations

import sqlite3
from collections.abc import Callable
from contextlib import closing
from pathlib import Path
from typing import Any
from urllib.parse import quote

import yaml
from er_models.errors import InputError

METADATA = "metadata.yaml"
"""Name of the file beside the data files that says what they hold."""


def data_files(path: Path) -> list[Path]:
    """Data files in the order of recording: their names are numbered without leading zeros."""
    if path.is_file():
        return [path]
    files = [item for item in path.iterdir() if item.is_file() and is_data(item)]
    if not files:
        raise InputError(path, "", "a .mcap or .db3 file beside metadata.yaml", "none")
    return sorted(files, key=lambda item: (len(item.name), item.name))


def is_data(path: Path) -> bool:
    """Whether a file holds messages, compressed as a whole or not."""
    return path.suffix in (".mcap", ".db3") or path.name.endswith((".mcap.zstd", ".db3.zstd"))


def missing_files(folder: Path, files: list[Path]) -> list[str]:
    """A sentence for each file that metadata.yaml, where readable, lists and the folder lacks."""
    have = {file.name for file in files}
    listed = [Path(str(name)).name for name in metadata(folder).get("relative_file_paths", [])]
    return [
        f"{name} is listed in metadata.yaml but missing" for name in listed if name not in have
    ]


def promised_count(file: Path, wants: Callable[[str], bool]) -> int:
    """Messages that metadata.yaml promises on the wanted topics; 0 if it does not tell."""
    info = metadata(file.parent)
    if len(info.get("relative_file_paths", [])) != 1:
        return 0
    try:
        topics = [(t["topic_metadata"]["name"], int(t["message_count"])) for t in _topics(info)]
    except (KeyError, TypeError, ValueError):
        return 0
    return sum(count for name, count in topics if wants(str(name)))


def unclosed(file: Path) -> str:
    """Why a sqlite file is one that its recorder did not close; empty where it did, or nothing tells.

    A closed one has a `metadata.yaml` beside it; a copy without is known by the record that is written into it at the
    end (rosbag2's own recorder writes an empty one at the beginning). Files before ROS 2 Iron have no such record.
    """
    if file.suffix != ".db3" or (file.parent / METADATA).exists():
        return ""
    journal = file.with_name(f"{file.name}-journal")
    if journal.exists() and journal.stat().st_size:
        return f"was never closed: {journal.name} is beside it"
    try:
        with closing(sqlite3.connect(f"file:{quote(str(file))}?immutable=1", uri=True)) as data:
            if not data.execute("SELECT 1 FROM sqlite_master WHERE name = 'metadata'").fetchone():
                return ""
            closed = [_promises(text) for (text,) in data.execute("SELECT metadata FROM metadata")]
    except sqlite3.Error:
        # whatever is wrong with it is found when its messages are read
        return ""
    return "" if any(closed) else "was never closed: it has no record of its end"


def _promises(text: str) -> bool:
    """Whether a metadata record speaks of messages; one that cannot be read may."""
    try:
        content = yaml.load(text, getattr(yaml, "CSafeLoader", yaml.SafeLoader))
        return int(content["message_count"]) > 0
    except (yaml.YAMLError, KeyError, TypeError, ValueError):
        return True


def _topics(info: dict[str, Any]) -> list[dict[str, Any]]:
    """The list of topics in the metadata."""
    return list(info.get("topics_with_message_count", []))


def metadata(folder: Path) -> dict[str, Any]:
    """Contents of metadata.yaml; empty when it is absent or damaged."""
    try:
        text = (folder / METADATA).read_text(encoding="utf-8")
        # parameters of many nodes stand in it: the parser in C is ten times as fast
        content = yaml.load(text, getattr(yaml, "CSafeLoader", yaml.SafeLoader))
        return dict(content["rosbag2_bagfile_information"])
    except (OSError, yaml.YAMLError, KeyError, TypeError, ValueError):
        return {}
