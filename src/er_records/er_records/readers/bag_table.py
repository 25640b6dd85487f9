"""Every number of a bag as a column `/topic.field.of.it`, for whoever asks what is in it."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import fields, is_dataclass
from pathlib import Path
from typing import Any

import numpy as np
from er_models.errors import InputError
from rosbags.highlevel import AnyReader

from er_records.provenance import digest_files
from er_records.readers.bag_files import data_files
from er_records.readers.bag_streams import stamp_ns, value_at
from er_records.readers.columns import Column
from er_records.readers.table import Numbers, Table
from er_records.record import Array

LONGEST = 32
"""Numbers of an array in a message that are columns; a longer one is an image or a cloud."""


def table(path: Path) -> Table:
    """The numbers of all topics of a recording, each with the stamps of its topic as times [s].

    Raises:
        InputError: Nothing readable in it.
    """
    samples: dict[str, list[float]] = {}
    stamps: dict[str, list[int]] = {}
    wanted: dict[str, list[str]] = {}
    try:
        with AnyReader([path]) as reader:
            for connection, arrival, raw in reader.messages():
                topic = connection.topic
                message = reader.deserialize(raw, connection.msgtype)
                if topic not in wanted:
                    wanted[topic] = list(_numbers_in(message))
                stamps.setdefault(topic, []).append(stamp_ns(message, arrival))
                for name in wanted[topic]:
                    samples.setdefault(f"{topic}.{name}", []).append(value_at(message, name))
    except Exception as error:  # damaged bags raise errors of sqlite, YAML, zstd, struct ...
        why = (str(error).splitlines() or [type(error).__name__])[0]
        raise InputError(path, "", "a readable recording", why) from None
    if not samples:
        raise InputError(path, "topics", "numbers", "none")
    first = min(each[0] for each in stamps.values())
    header = tuple(samples)

    def numbers(columns: Sequence[Column]) -> Numbers:
        return [np.asarray(samples[header[c.index]]) for c in columns], []

    def times(index: int) -> Array:
        own = np.asarray(stamps[header[index].partition(".")[0]], dtype=np.int64)
        return np.asarray((own - first) * 1e-9)

    return Table(path, header, numbers, digest_files(data_files(path)), times=times)


def _numbers_in(message: Any, head: str = "") -> Iterator[str]:
    """Places of the numbers in a message, without those of its header."""
    for each in fields(message):
        name, value = f"{head}{each.name}", getattr(message, each.name)
        if each.name in ("header", "__msgtype__"):
            continue
        if is_dataclass(value):
            yield from _numbers_in(value, f"{name}.")
        elif isinstance(value, np.ndarray) and value.dtype.kind in "iuf":
            yield from (f"{name}[{k}]" for k in range(min(value.size, LONGEST)))
        elif isinstance(value, int | float) and not isinstance(value, bool):
            yield name
