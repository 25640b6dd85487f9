"""Samples of an Arrow column.

Its own `to_numpy` imports pandas wherever that is installed, which takes longer than reading an hour of data.

Source: Apache Arrow columnar format, fixed-size primitive layout (validity bitmap, then values).
"""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]


def samples(column: Any) -> Array:
    """Samples (n,) of a chunked column of numbers, NaN where there is none.

    Raises:
        pyarrow.ArrowException: The column holds something else.
    """
    parts = [_part(chunk) for chunk in column.cast("float64", safe=False).chunks if len(chunk)]
    return np.concatenate(parts) if parts else np.empty(0)


def _part(chunk: Any) -> Array:
    """Samples of one piece in memory, (n,)."""
    here = slice(chunk.offset, chunk.offset + len(chunk))
    bits, values = chunk.buffers()
    numbers = np.frombuffer(values)[here]
    if not chunk.null_count:
        return numbers
    there = np.unpackbits(np.frombuffer(bits, np.uint8), bitorder="little")[here]
    return np.where(there, numbers, np.nan)
