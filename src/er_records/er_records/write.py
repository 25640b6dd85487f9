"""Writes records so that `load` restores them whole: samples, notes, scales, origin and licence.

A file appears only when it is finished: it is written beside its place and then renamed.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

import numpy as np

from er_records.provenance import METADATA_KEY, to_json
from er_records.record import Record


@contextmanager
def finished_only(path: Path) -> Iterator[Path]:
    """A temporary path that becomes `path` when the block ends, and vanishes when it fails."""
    path.parent.mkdir(parents=True, exist_ok=True)
    # the process id keeps two writers of the same file apart
    part = path.with_name(f".{path.name}.{os.getpid()}.part")
    try:
        yield part
        os.replace(part, path)
    finally:
        part.unlink(missing_ok=True)


def write_parquet(record: Record, path: Path) -> None:
    """Write one record as Parquet; the provenance is JSON in the schema's metadata."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    table = pa.table({"t": record.t, **dict(record.channels)})
    table = table.replace_schema_metadata({METADATA_KEY: to_json(record)})
    with finished_only(path) as part:
        pq.write_table(table, part, compression="zstd")


def write_csv(record: Record, path: Path) -> None:
    """Write one record as CSV; numbers are as short as they can be without loss.

    The first line is a comment that holds the provenance; missing samples are empty cells.
    """
    columns = {"t": record.t, **dict(record.channels)}
    with finished_only(path) as part, part.open("w", encoding="utf-8", newline="\n") as stream:
        stream.write(f"# {METADATA_KEY} {to_json(record)}\n")
        stream.write(",".join(columns) + "\n")
        for row in np.column_stack(list(columns.values())).tolist():
            stream.write(",".join("" if value != value else repr(value) for value in row) + "\n")
