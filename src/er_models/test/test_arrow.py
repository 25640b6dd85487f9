"""Samples of Arrow columns: pieces, missing ones, kinds; and no pandas for it."""

from __future__ import annotations

import subprocess
import sys

import numpy as np
import pytest
from er_models.arrow import samples

pa = pytest.importorskip("pyarrow")


@pytest.mark.parametrize("kind", ["float64", "float32", "int64", "uint8"])
@pytest.mark.parametrize("missing", [[], [0], [2, 9], list(range(12))])
@pytest.mark.parametrize("pieces", [1, 2, 5])
def test_they_are_those_of_arrow_itself(kind: str, missing: list[int], pieces: int) -> None:
    values = [None if k in missing else 7 * k % 11 for k in range(12)]
    chunks = [pa.array(part.tolist(), kind) for part in np.array_split(np.array(values), pieces)]
    column = pa.chunked_array(chunks, kind)
    np.testing.assert_array_equal(samples(column), column.to_numpy().astype(float))
    sliced = column.slice(3, 8)  # which begins within a byte of the bits that say what is there
    np.testing.assert_array_equal(samples(sliced), sliced.to_numpy().astype(float))


def test_an_empty_column_has_none() -> None:
    assert samples(pa.chunked_array([], "float64")).shape == (0,)
    assert samples(pa.chunked_array([[], []], "float64")).shape == (0,)


@pytest.mark.parametrize("column", [[["a"]], [[{"a": 1.0}]]])
def test_another_kind_is_refused(column: list[list[object]]) -> None:
    with pytest.raises(pa.ArrowException):
        samples(pa.chunked_array(column))


def test_pandas_is_not_imported() -> None:
    program = (
        "import sys, pyarrow, pyarrow.csv as csv\n"
        "from er_models.arrow import samples\n"
        "table = csv.read_csv(pyarrow.BufferReader(b'a,b\\n1,\\n2,3.5\\n'))\n"
        "print(samples(table.column('b')), 'pandas' in sys.modules)\n"
    )
    ran = subprocess.run(
        [sys.executable, "-c", program], capture_output=True, text=True, check=True
    )
    assert ran.stdout == "[nan 3.5] False\n"
