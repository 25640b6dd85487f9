"""Parquet: one column a channel, named as in the contract; nulls are missing samples."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path

from er_models.arrow import samples
from er_models.errors import InputError

from er_records.provenance import METADATA_KEY, digest_bytes
from er_records.readers.columns import Column
from er_records.readers.table import Numbers, Table
from er_records.record import cure


def table(path: Path) -> Table:
    """The columns of a Parquet file, with the provenance that `er_records.write` stored.

    Raises:
        InputError: Empty or damaged file; where they are read, a column that is not numeric.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    data = path.read_bytes()
    if not data:
        raise InputError(path, "", "a Parquet table", "an empty file")
    try:
        stored = pq.ParquetFile(pa.BufferReader(data)).read()  # read_table imports pandas
    except (pa.ArrowException, OSError) as error:
        raise InputError(path, "", "a Parquet file", str(error).splitlines()[0]) from None

    def numbers(columns: Sequence[Column]) -> Numbers:
        found = []
        for column in columns:
            values = stored.column(column.index)
            kind, types = values.type, pa.types
            if not (types.is_floating(kind) or types.is_integer(kind) or types.is_decimal(kind)):
                key = f"column '{column.name}'"
                raise InputError(path, key, "numbers", str(kind), cure(path))
            found.append(samples(values))
        return found, []

    text = (stored.schema.metadata or {}).get(METADATA_KEY.encode(), b"").decode()
    return Table(path, tuple(stored.column_names), numbers, digest_bytes(data), provenance=text)
