"""rosbag2 recordings (MCAP or sqlite3): one record for each namespace with the contract's topics.

Needs no ROS: message definitions are those stored in the bag. A damaged recording gives what can
still be read, marked incomplete, with the damage in its notes.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Iterable, Mapping
from contextlib import suppress
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from er_models.errors import ErError, InputError, MissingChannel
from rosbags.highlevel import AnyReader
from rosbags.typesys import (
    Stores,
    TypesysError,
    get_types_from_idl,
    get_types_from_msg,
    get_typestore,
)

from er_records.provenance import digest_files
from er_records.readers.bag_align import align
from er_records.readers.bag_files import (
    METADATA,
    data_files,
    missing_files,
    promised_count,
    unclosed,
)
from er_records.readers.bag_names import hint, usual_names
from er_records.readers.bag_streams import Collector
from er_records.readers.mcap_salvage import salvage
from er_records.readers.names import NONE, Names
from er_records.record import Record, cure

Decode = Callable[[bytes, str], object]


@dataclass(slots=True)
class Bag:
    """What was read of one recording: samples by topic, damage, and what else was seen; kinds: types by topic."""

    path: Path
    collector: Collector
    damage: list[str] = field(default_factory=list)
    notes: list[str] = field(default_factory=list)
    topics: Counter[str] = field(default_factory=Counter)
    kinds: dict[str, str] = field(default_factory=dict)

    def saw(self, kinds: Mapping[str, str]) -> None:
        """Topics with their types; those under other names are taken for the usual ones."""
        self.kinds.update(kinds)
        self.topics.update(dict.fromkeys(kinds, 0))
        names, guessed = usual_names(self.path, self.kinds)
        self.collector.rename(names)
        self.notes += [sentence for sentence in guessed if sentence not in self.notes]


def read(path: Path, names: Names = NONE) -> list[Record]:
    """Records of a rosbag2 folder or of a single `.mcap` or `.db3` file.

    names: channels that topics of others hold, `damper_force: /loadcell.wrench.force.z`.

    Raises:
        InputError: No data file, or nothing readable in it.
        MissingChannel: A whole recording without sensor topics (exit status 4).
    """
    files = data_files(path)
    bag = Bag(path, Collector(path, names))
    if path.is_dir():
        _read_folder(bag, files)
    else:
        _read_file(bag, path)
    streams = bag.collector.streams(bag.notes)
    if not streams:
        raise _nothing(bag)
    digest = digest_files(files)
    notes = (*bag.notes, *bag.damage)
    records = []
    for namespace, own in sorted(streams.items()):
        name = path.stem + (namespace if len(streams) > 1 else "")
        for record in align(name, own, str(path), digest):
            marked = _marked(record, notes, whole=not bag.damage)
            waits, scales = bag.collector.waits(namespace), bag.collector.scales
            records.append(replace(marked, waits=waits, scales=scales))
    if not records:
        raise InputError(
            path, "header stamps", "sensor topics that overlap in time", "; ".join(notes) or "none"
        )
    return records


def _nothing(bag: Bag) -> ErError:
    """The error for a recording without a single sample of the contract's sensors."""
    if bag.topics and not bag.damage:
        present = tuple(sorted(bag.topics))
        needed = f"to know the motion{hint(bag.kinds)}"
        return MissingChannel(bag.path, "sensors/deflection", needed, present, cure(bag.path))
    found = "; ".join(bag.damage) or "no message"
    return InputError(bag.path, "topics", "sensors/deflection, sensors/force ...", found)


def _marked(record: Record, notes: tuple[str, ...], *, whole: bool) -> Record:
    """The record with the notes of the whole bag, incomplete if the bag was damaged."""
    return replace(record, notes=notes + record.notes, complete=record.complete and whole)


def _read_folder(bag: Bag, files: list[Path]) -> None:
    """Read through metadata.yaml; where that fails, each data file for itself."""
    if (bag.path / METADATA).exists():
        before = bag.collector.copy()
        failure = _read_ordinary(bag, bag.path)
        if not failure:
            return
        bag.collector, bag.topics = before, Counter()
        bag.notes.append(f"the recording cannot be read as a whole ({failure})")
        bag.damage += missing_files(bag.path, files)
    else:
        bag.notes.append("metadata.yaml is missing: the data files were read one by one")
    for file in files:
        _read_file(bag, file)


def _read_file(bag: Bag, file: Path) -> None:
    """Read one data file; salvage a damaged MCAP, keep what a damaged sqlite file gave."""
    before = bag.collector.copy()
    count = sum(bag.topics.values())
    failure = _read_ordinary(bag, file)
    if not failure:
        why = unclosed(file)
        bag.damage += [f"{file.name} {why}"] if why else []
        return
    if file.suffix != ".mcap":
        kept = sum(bag.topics.values()) - count
        bag.damage.append(f"{file.name} is damaged ({failure}): {kept} messages read")
        return
    bag.collector = before
    try:
        kept = _read_salvaged(bag, file)
    except ValueError as error:
        bag.damage.append(f"{file.name} is damaged ({error}): 0 messages read")
        return
    total = promised_count(file, bag.collector.wants)
    of = f" of {total}" if total and total >= kept else ""
    bag.damage.append(f"{file.name} is damaged ({failure}): {kept}{of} messages salvaged")


def _read_ordinary(bag: Bag, path: Path) -> str:
    """Read with the ordinary reader; returns '' or why it failed (also when it fails half-way)."""
    read, promised = 0, 0
    try:
        with AnyReader([path]) as reader:
            bag.saw({c.topic: c.msgtype for c in reader.connections})
            wanted = [c for c in reader.connections if bag.collector.wants(c.topic)]
            promised = sum(c.msgcount for c in wanted)
            # an empty selection would mean all topics to the reader
            for connection, arrival, raw in reader.messages(wanted) if wanted else ():
                topic, kind = connection.topic, connection.msgtype
                bag.collector.add(topic, kind, reader.deserialize(raw, kind), arrival)
                bag.topics[topic] += 1
                read += 1
    except ErError:
        raise
    except Exception as error:  # damaged bags raise errors of sqlite, YAML, zstd, struct ...
        return reason(error)
    # a chunk that lost its thread inside ends early without any error
    return "" if read >= promised else f"{read} of {promised} messages are readable"


def reason(error: Exception) -> str:
    """The first line of an error, or its kind when it has no text."""
    lines = str(error).strip().splitlines()
    return (lines[0] if lines else type(error).__name__).rstrip(".")


def _read_salvaged(bag: Bag, file: Path) -> int:
    """Messages taken from a damaged MCAP file."""
    found = salvage(file)
    decode = decoder(found.schemas.values())
    kept = 0
    kinds = {schema: name for schema, (name, _, _) in found.schemas.items()}
    bag.saw({topic: kinds.get(schema, "") for topic, schema in found.channels.values()})
    for topic, schema, raw, when in found.messages:
        if not bag.collector.wants(topic) or schema not in found.schemas:
            continue
        kind = found.schemas[schema][0]
        try:
            message = decode(raw, kind)
        except Exception:  # a garbled message raises whatever its bytes provoke
            continue
        bag.collector.add(topic, kind, message, when if topic in bag.collector.asked else None)
        kept += 1
    return kept


def decoder(schemas: Iterable[tuple[str, str, str]]) -> Decode:
    """Deserializer for the definitions found in a file."""
    types: dict[str, Any] = {}
    for name, encoding, definition in schemas:
        with suppress(TypesysError):
            if encoding == "ros2msg":
                types.update(get_types_from_msg(definition, name))
            else:
                types.update(_from_idl(definition))
    store = get_typestore(Stores.EMPTY)
    store.register(types)
    return store.deserialize_cdr


def _from_idl(definition: str) -> dict[str, Any]:
    """Types of an IDL schema; rosbag2 joins several files with headed separators."""
    separator = "=" * 80 + "\n"
    parts = definition.split(separator) if definition.startswith(separator) else [definition]
    types: dict[str, Any] = {}
    for part in parts:
        if part.startswith("IDL: "):
            part = part.split("\n", 1)[1]
        if part.strip():
            types.update(get_types_from_idl(part))
    return types
