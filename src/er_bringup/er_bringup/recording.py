"""A recording as it is played: what can be read of it, also where it is damaged, with what its recorder noted."""

from __future__ import annotations

from collections import Counter
from collections.abc import Callable, Collection, Iterator, Mapping
from dataclasses import dataclass, field
from operator import itemgetter
from pathlib import Path
from typing import Any, NamedTuple

from er_common.topics import Topic
from er_models.errors import InputError
from er_records.readers.bag_files import METADATA, data_files, unclosed
from er_records.readers.bag_names import custom_data, usual_names
from er_records.readers.mcap_salvage import salvage
from er_records.readers.rosbag import decoder, reason
from rosbags.highlevel import AnyReader

Came = tuple[str, Any, int]
"""Topic as it was recorded, message, time of arrival [ns]."""


class Source(NamedTuple):
    """Messages of a recording, or of one file of it.

    kinds, counts: type and messages of each topic; messages: those of some topics, in order of arrival.
    """

    kinds: Mapping[str, str]
    counts: Mapping[str, int]
    messages: Callable[[Collection[str]], Iterator[Came]]


@dataclass
class Bag:
    """An open recording, or what can be read of it.

    parameters: of the nodes, by full name; models: their models' hashes; names: usual names of topics that were
    recorded under others; damage: why it is not whole.
    """

    path: Path
    sources: list[Source]
    parameters: Mapping[str, Mapping[str, Any]] = field(default_factory=dict)
    models: Mapping[str, str] = field(default_factory=dict)
    names: Mapping[str, str] = field(default_factory=dict)
    damage: str = ""

    def named(self, topic: str) -> str:
        """Usual full name of a topic."""
        return self.names.get(topic, topic)

    def messages(self, names: Mapping[str, Topic]) -> Iterator[tuple[Topic, Any, int]]:
        """Topic, message and time of arrival [ns] of these full names, as they were recorded."""
        kinds = {name: topic.type_name for name, topic in names.items()}
        for source in self.sources:
            wanted = {t for t, kind in source.kinds.items() if kinds.get(self.named(t)) == kind}
            read, promised = 0, sum(source.counts[topic] for topic in wanted)
            try:
                for topic, message, arrival in source.messages(wanted):
                    read += 1
                    yield names[self.named(topic)], message, arrival
            except Exception as error:  # a damaged bag raises whatever its bytes provoke
                self.damage = self.damage or reason(error)
            else:
                # a chunk that lost its thread inside ends early without any error
                if read < promised:
                    lost = f"{read} of {promised} messages are readable"
                    self.damage = self.damage or lost

    @property
    def topics(self) -> tuple[str, ...]:
        """Full names of topics with messages in it."""
        found = (self.named(t) for s in self.sources for t, count in s.counts.items() if count)
        return tuple(sorted(set(found)))


def opened(path: Path) -> Bag:
    """A recording.

    Raises:
        InputError: Nothing of it can be read, or what its recorder noted.
    """
    if not (path.is_file() or path.is_dir()):
        found = "another kind of file" if path.exists() else "nothing there"
        raise InputError(path, "", "a rosbag2 folder or file", found)
    try:
        sources, damage = [_whole(path)], unclosed(path)
    except Exception as error:  # as above
        damage = reason(error)
        if path.is_dir() and not (path / METADATA).exists():
            damage = f"{METADATA} is missing"
        sources = [s for s in map(_file, data_files(path)) if s and any(s.counts.values())]
    if not sources:
        raise InputError(path, "", "a rosbag2 recording with messages", damage)
    bag = Bag(path, sources, damage=damage)
    custom = custom_data(path)
    bag.parameters, bag.models = custom.get("parameters", {}), custom.get("models", {})
    bag.names, _ = usual_names(path, {t: kind for s in sources for t, kind in s.kinds.items()})
    return bag


def _file(path: Path) -> Source | None:
    """What can be read of a data file; None for nothing."""
    try:
        return _whole(path)
    except Exception:  # as above
        try:
            return _salvaged(path)
        except (ValueError, OSError):
            return None


def _whole(path: Path) -> Source:
    """A recording that the ordinary reader opens."""
    reader = AnyReader([path])
    reader.open()

    def messages(wanted: Collection[str]) -> Iterator[Came]:
        connections = [c for c in reader.connections if c.topic in wanted]
        # an empty selection would mean all topics to the reader
        for c, arrival, raw in reader.messages(connections) if connections else ():
            yield c.topic, reader.deserialize(raw, c.msgtype), arrival

    kinds = {c.topic: c.msgtype for c in reader.connections}
    counts = dict.fromkeys(kinds, 0)
    for c in reader.connections:
        counts[c.topic] += c.msgcount
    return Source(kinds, counts, messages)


def _salvaged(path: Path) -> Source:
    """What is left of a damaged MCAP file; `ValueError` where it is none."""
    found = salvage(path)
    decode = decoder(found.schemas.values())
    ordered = sorted(
        ((topic, found.schemas[schema][0], raw, arrival)
         for topic, schema, raw, arrival in found.messages if schema in found.schemas),
        key=itemgetter(3),
    )  # fmt: skip

    def messages(wanted: Collection[str]) -> Iterator[Came]:
        for topic, kind, raw, arrival in ordered:
            if topic in wanted:
                yield topic, decode(raw, kind), arrival

    kinds = {topic: kind for topic, kind, _, _ in ordered}
    return Source(kinds, Counter(topic for topic, *_ in ordered), messages)
