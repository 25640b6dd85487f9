"""How the kernel is compiled."""

from __future__ import annotations

from collections.abc import Callable
from typing import Any

import numba

from er_models.cache.compiled import on_disk

njit: Callable[..., Any] = numba.njit
"""Untyped: the stubs of numba know only part of its options."""

_INNER: dict[str, Any] = {
    "error_model": "numpy",
    "fastmath": {"contract"},
    "_nrt": False,
    "no_cpython_wrapper": True,
    "no_cfunc_wrapper": True,
}
"""Products and sums may be contracted to one operation; nothing else of the arithmetic may be changed."""
inner = njit(**_INNER)
"""For functions that only the kernel calls. Without entries for Python and C they compile twice as fast; without
counting the references to their arrays a call costs 16 ns instead of 124."""
inline = njit(forceinline=True, **_INNER)
"""For small functions on the way of every step."""
once = njit(inline="always", **_INNER)
"""For functions with few callers: written into these, they are no compilation of their own."""
linked = on_disk(error_model="numpy", fastmath={"contract"}, _nrt=False)
"""For what several entries call: kept on disk, so that each process compiles only what is its own."""
entry = on_disk(nogil=True, error_model="numpy")
"""For what Python calls; kept on disk."""
