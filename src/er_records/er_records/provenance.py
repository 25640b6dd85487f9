"""What is known about a record besides its samples, as text that travels inside data files."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from er_models.errors import InputError

from er_records.record import Record

METADATA_KEY = "er_record"
"""Key of the JSON in the metadata of Parquet; CSV begins with the line `# er_record {json}`."""


def digest_bytes(*parts: bytes) -> str:
    """SHA-256 of the parts one after the other, as hexadecimal digits."""
    total = hashlib.sha256()
    for part in parts:
        total.update(part)
    return total.hexdigest()


def digest_files(paths: Sequence[Path]) -> str:
    """SHA-256 of the files' contents in the order given, read in pieces."""
    total = hashlib.sha256()
    for path in paths:
        with path.open("rb") as stream:
            while piece := stream.read(1 << 20):
                total.update(piece)
    return total.hexdigest()


def content_digest(record: Record) -> str:
    """SHA-256 of the samples and channel names: equal for equal data, however they were stored."""
    total = hashlib.sha256()
    for name, samples in (("t", record.t), *sorted(record.channels.items())):
        total.update(name.encode() + b"\0")
        # every NaN counts the same, whatever its bits
        total.update(np.where(np.isnan(samples), np.nan, samples).astype("<f8").tobytes())
    return total.hexdigest()


def fingerprint(records: Sequence[Record]) -> str:
    """SHA-256 that names exactly these records: their names, origins and samples, in order."""
    parts = [f"{r.name}\0{r.digest}\0{content_digest(r)}\n".encode() for r in records]
    return digest_bytes(*parts)


def to_json(record: Record) -> str:
    """Everything but the samples, in one line of JSON."""
    return json.dumps(
        {
            "name": record.name,
            "source": record.source,
            "digest": record.digest,
            "licence": record.licence,
            "complete": record.complete,
            "scales": dict(record.scales),
            "derived": list(record.derived),
            "notes": list(record.notes),
            "content": content_digest(record),
        },
        ensure_ascii=True,
    )


def restore(record: Record, text: str, path: Path) -> Record:
    """The record with the provenance `text` (from `to_json`) that was found in `path`.

    A change of the samples since then is noted, because the old origin no longer vouches for them.

    Raises:
        InputError: The text is not what `to_json` writes.
    """
    try:
        meta: dict[str, Any] = json.loads(text)
        scales: Mapping[str, str] = {str(k): str(v) for k, v in dict(meta["scales"]).items()}
        restored = replace(
            record,
            name=str(meta["name"]),
            source=str(meta["source"]),
            digest=str(meta["digest"]),
            licence=str(meta["licence"]),
            complete=bool(meta["complete"]) and record.complete,
            scales=scales,
            derived=tuple(str(name) for name in meta["derived"] if name in record.channels),
            notes=tuple(str(note) for note in meta["notes"]) + record.notes,
        )
        content = str(meta["content"])
    except (ValueError, KeyError, TypeError) as error:
        raise InputError(path, METADATA_KEY, "the JSON this project writes", repr(error)) from None
    if content_digest(restored) != content:
        return restored.noted(f"{path.name}: the samples were changed after the file was written")
    return restored
