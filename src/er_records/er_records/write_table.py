"""Writes columns with their units as other programs read them: CSV, Parquet, MATLAB and MF4.

The first column is the time where the table has one. `load` reads all of them again, by the contract's names.
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from io import BytesIO
from pathlib import Path

import numpy as np
from er_common.extras import extra
from er_models.errors import InputError

from er_records.record import Array
from er_records.write import finished_only

Columns = Mapping[str, tuple[Array, str]]
"""Name to samples (n,) and their unit."""


def write_table(columns: Columns, path: Path) -> None:
    """Write columns in the format of the path's suffix; the file appears when it is finished.

    Raises:
        InputError: a suffix that there is no writer for, or a place that cannot be written.
        ErError: what writes MF4 is not installed.
    """
    content = writer_of(path)(columns)
    try:
        with finished_only(path) as part:
            part.write_bytes(content)
    except OSError as error:
        found = error.strerror or str(error)
        raise InputError(path, "", "a place that can be written", found) from None


def writer_of(path: Path) -> Callable[[Columns], bytes]:
    """What makes the content of a file of this suffix; `InputError` where there is none."""
    if path.suffix.lower() not in WRITERS:
        raise InputError(path, "suffix", f"one of {', '.join(WRITERS)}", f"'{path.suffix}'")
    return WRITERS[path.suffix.lower()]


def _csv(columns: Columns) -> bytes:
    """A header with units in brackets, then numbers as short as they can be without loss; missing ones are empty."""
    lines = [",".join(f"{name} [{unit}]" for name, (_, unit) in columns.items())]
    for row in np.column_stack([samples for samples, _ in columns.values()]).tolist():
        lines.append(",".join("" if value != value else repr(value) for value in row))
    return ("\n".join(lines) + "\n").encode()


def _parquet(columns: Columns) -> bytes:
    """One column each, its unit in the metadata of the field."""
    import pyarrow as pa
    import pyarrow.parquet as pq

    fields = [
        pa.field(name, pa.float64(), metadata={"unit": unit})
        for name, (_, unit) in columns.items()
    ]
    table = pa.table([samples for samples, _ in columns.values()], schema=pa.schema(fields))
    sink = BytesIO()
    pq.write_table(table, sink, compression="zstd")
    return sink.getvalue()


def _mat(columns: Columns) -> bytes:
    """MATLAB 5: one column vector each, and their units as the fields of `units`."""
    from scipy.io import savemat

    sink = BytesIO()
    units = {name: unit for name, (_, unit) in columns.items()}
    content = {name: samples for name, (samples, _) in columns.items()} | {"units": units}
    savemat(sink, content, oned_as="column", long_field_names=True, do_compression=True)
    return sink.getvalue()


def _mf4(columns: Columns) -> bytes:
    """MF 4.10: one group of channels on the time of the first column."""
    with extra("er_records[mf4]", "MF4"):
        from asammdf import MDF, Signal

    (t, _), *_ = columns.values()
    sink = BytesIO()
    with MDF(version="4.10") as mdf:
        mdf.append([
            Signal(samples=samples, timestamps=t, name=name, unit=unit)
            for name, (samples, unit) in list(columns.items())[1:]
        ])  # fmt: skip
        mdf.save(sink)
    return sink.getvalue()


WRITERS: dict[str, Callable[[Columns], bytes]] = {
    ".csv": _csv,
    ".parquet": _parquet,
    ".mat": _mat,
    ".mf4": _mf4,
}
"""Suffix to what makes the content of such a file."""
