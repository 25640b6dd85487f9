"""MATLAB files (`.mat`): version 5 by SciPy, version 7.3 (HDF5) by h5py.

Every numeric vector is a column, the columns of a matrix are `name(1)`, `name(2)`, ...; fields of a structure are
`structure.field`. Vectors of the most frequent length are the table; others (settings) are left out.
"""

from __future__ import annotations

from collections import Counter
from collections.abc import Iterator, Mapping, Sequence
from io import BytesIO
from pathlib import Path
from typing import Any

import numpy as np
from er_common.extras import extra
from er_models.errors import InputError

from er_records.provenance import digest_bytes
from er_records.readers.columns import Column
from er_records.readers.table import Numbers, Table
from er_records.record import CHANNELS, Array

HDF5 = b"\x89HDF\r\n\x1a\n"
HDF5_PLACES = (0, 512)
"""Where the mark of HDF5 stands: MATLAB writes 512 bytes of its own before it."""
WIDEST = 64
"""A matrix with more columns is no table of signals."""


def table(path: Path) -> Table:
    """The vectors of a MATLAB file.

    Raises:
        InputError: A damaged file, or one without vectors of numbers.
    """
    data = path.read_bytes()
    new = any(data[k : k + len(HDF5)] == HDF5 for k in HDF5_PLACES)
    with extra("er_records[mat]", f"{path}: MATLAB 7.3"):
        try:
            found = dict(_flat(_hdf5(data) if new else _version_5(data)))
        except (ImportError, InputError):
            raise
        except Exception as error:  # damaged files raise errors of scipy, zlib, h5py, struct ...
            why = (str(error).splitlines() or [type(error).__name__])[0]
            raise InputError(path, "", "a MATLAB file", why) from None
    lengths = Counter(y.size for y in found.values() if y.size > 1)
    if not lengths:
        raise InputError(path, "variables", f"vectors such as {', '.join(CHANNELS)}", "none")
    rows = max(lengths, key=lambda n: (lengths[n], n))
    columns = {name: y for name, y in found.items() if y.size == rows}

    def numbers(wanted: Sequence[Column]) -> Numbers:
        return [list(columns.values())[c.index] for c in wanted], []

    others = [name for name, y in found.items() if y.size != rows]
    notes = (f"variables of other lengths were left out: {', '.join(others[:8])}",) * bool(others)
    return Table(path, tuple(columns), numbers, digest_bytes(data), notes=notes)


def _version_5(data: bytes) -> Mapping[str, Any]:
    """Variables of a file of version 4 to 7.2."""
    from scipy.io import loadmat

    stored: Mapping[str, Any] = loadmat(BytesIO(data), simplify_cells=True)
    return {name: value for name, value in stored.items() if not name.startswith("__")}


def _hdf5(data: bytes) -> Mapping[str, Any]:
    """Variables of a file of version 7.3; what only MATLAB's own classes explain is left out."""
    import h5py

    def inside(group: Any) -> dict[str, Any]:
        found: dict[str, Any] = {}
        for name, item in group.items():
            if name.startswith("#"):
                continue
            if isinstance(item, h5py.Group):
                found[name] = inside(item)
            elif item.dtype.kind in "iuf" and item.attrs.get("MATLAB_class", b"") != b"char":
                found[name] = np.asarray(item).T  # MATLAB counts the first index fastest
        return found

    with h5py.File(BytesIO(data), "r") as file:
        return inside(file)


def _flat(stored: Mapping[str, Any], head: str = "") -> Iterator[tuple[str, Array]]:
    """Vectors by name, out of structures and matrices."""
    for name, value in stored.items():
        if isinstance(value, Mapping):
            yield from _flat(value, f"{head}{name}.")
            continue
        array = np.asarray(value)
        if array.dtype.kind not in "iufb":
            continue
        matrix = array.astype(np.float64)
        matrix = matrix.reshape(-1, 1) if 1 in matrix.shape or matrix.ndim < 2 else matrix
        if matrix.ndim == 2 and matrix.shape[1] == 1:
            yield f"{head}{name}", np.ascontiguousarray(matrix[:, 0])
        elif matrix.ndim == 2:
            matrix = matrix.T if matrix.shape[0] < matrix.shape[1] else matrix
            if matrix.shape[1] <= WIDEST:
                yield from ((f"{head}{name}({k + 1})", y.copy()) for k, y in enumerate(matrix.T))
