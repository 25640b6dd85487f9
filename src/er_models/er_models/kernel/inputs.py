"""Inputs between their samples: motion by cubic pieces, the duty held."""

from __future__ import annotations

import math

from er_models.kernel.fast import inline, inner

# --- below this line: compiled with the composed equations ---
ROUNDING = 1e-9
"""Share of a sample by which a delay may miss a whole number through rounding."""


@inline
def hermite(y0, d0, y1, d1, h, s):
    """Cubic through values and slopes at both ends of an interval of length h, at s in [0, 1]."""
    s2 = s * s
    s3 = s2 * s
    return (
        (2.0 * s3 - 3.0 * s2 + 1.0) * y0
        + (s3 - 2.0 * s2 + s) * h * d0
        + (3.0 * s2 - 2.0 * s3) * y1
        + (s3 - s2) * h * d1
    )


@inline
def cubic(y0, d0, y1, d1, h):
    """Coefficients of the same cubic in powers of s, lowest first."""
    rise, e0, e1 = y1 - y0, h * d0, h * d1
    return y0, e0, 3.0 * rise - 2.0 * e0 - e1, e0 + e1 - 2.0 * rise


@inline
def at(c, s):
    """Value of a cubic of four coefficients."""
    return c[0] + s * (c[1] + s * (c[2] + s * c[3]))


@inner
def split(lag):
    """Whole samples of a delay (in samples) and where within a sample interval the duty changes."""
    whole = math.floor(lag + ROUNDING)
    return whole, lag - whole if lag - whole > ROUNDING else 0.0


@inner
def between(y, s):
    """Value of a series (n,), n > 1, at s samples from its start: cubic between samples, held beyond the ends."""
    n = y.shape[0]
    s = min(max(s, 0.0), n - 1.0)
    i = min(int(s), n - 2)
    y0, y1 = y[i], y[i + 1]
    m0 = 0.5 * (y1 - y[i - 1]) if i > 0 else y1 - y0
    m1 = 0.5 * (y[i + 2] - y0) if i + 2 < n else y1 - y0
    return hermite(y0, m0, y1, m1, 1.0, s - i)


@inner
def delayed(y, d, out):
    """Series y shifted later by d samples; the ends are held."""
    for k in range(y.shape[0]):
        out[k] = between(y, k - d)
