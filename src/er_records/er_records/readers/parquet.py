"""Parquet: one column a channel, named as in the contract; nulls are missing samples."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path

from er_models.arrow import samples
from er_models.errors import InputError

from er_records.provenance import METADATA_KEY, digest_bytes, restore
from er_records.readers.columns import TIME, resolve, to_si
from er_records.record import Array, Record


def read(path: Path, names: Mapping[str, str] | None = None) -> list[Record]:
    """The one record of a Parquet file, with its provenance when `er_records.write` made it.

    Args:
        path: File.
        names: Contract name to column name, for files with other columns.

    Raises:
        InputError: Empty or damaged file, wrong columns, a column that is not numeric.
    """
    import pyarrow as pa
    import pyarrow.parquet as pq

    data = path.read_bytes()
    if not data:
        raise InputError(path, "", "a Parquet table", "an empty file")
    try:
        table = pq.read_table(pa.BufferReader(data))
    except (pa.ArrowException, OSError) as error:
        raise InputError(path, "", "a Parquet file", str(error).splitlines()[0]) from None
    columns, notes = resolve(path, table.column_names, names)
    channels: dict[str, Array] = {}
    for column in columns:
        values = table.column(column.index)
        kind = values.type
        if not (
            pa.types.is_floating(kind) or pa.types.is_integer(kind) or pa.types.is_decimal(kind)
        ):
            raise InputError(path, f"column '{column.name}'", "numbers", str(kind))
        raw = samples(values)
        channels[column.name], how = to_si(column, raw)
        notes += how
    t = channels.pop(TIME)
    record = Record(path.stem, t, channels, tuple(notes), True, str(path), digest_bytes(data))
    text = (table.schema.metadata or {}).get(METADATA_KEY.encode())
    return [restore(record, text.decode(), path) if text else record]
