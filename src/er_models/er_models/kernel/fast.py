"""How the kernel is compiled, and elementary functions faster than the C library's.

The hooks of the effects say `tanh`; the kernel puts this one in its place. It differs from the C
library's by less than 2e-16.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from typing import Any

import numba

njit: Callable[..., Any] = numba.njit
"""Untyped: the stubs of numba know only part of its options."""

_INNER: dict[str, Any] = {
    "error_model": "numpy",
    "_nrt": False,
    "no_cpython_wrapper": True,
    "no_cfunc_wrapper": True,
}
inner = njit(**_INNER)
"""For functions that only the kernel calls. Without entries for Python and C they compile twice as fast; without
counting the references to their arrays a call costs 16 ns instead of 124."""
inline = njit(forceinline=True, **_INNER)
"""For small functions on the way of every step."""
record = njit(error_model="numpy", no_cpython_wrapper=True, no_cfunc_wrapper=True)
"""As `inner`, for functions that make arrays or cut them."""
entry = njit(cache=True, nogil=True, error_model="numpy")
"""For what Python calls; kept on disk."""
batch = njit(cache=True, nogil=True, parallel=True, error_model="numpy")
"""As `entry`, over all cores."""


def _tanh(x: float) -> float:
    """Hyperbolic tangent through one exponential, a third of the C library's time."""
    e = math.exp(-2.0 * abs(x))
    return math.copysign((1.0 - e) / (1.0 + e), x)


tanh = inline(_tanh)
