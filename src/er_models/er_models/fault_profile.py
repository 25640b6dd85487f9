"""The profile of a fault over time: at once, growing, or coming and going; all fault effects share it."""

from __future__ import annotations

from math import floor

from er_models.effect import Param

TINY = 1e-9
"""An instant [s] and a rate [1/s] far below any that matters: what keeps a step from dividing by zero."""
PARAMETERS: tuple[Param, ...] = (
    Param("f", "1", 0.0, 1.0, 1.0, (0.6,), "what the fault leaves: 1 healthy, 0 all lost"),
    Param("t_0", "s", 0.0, 1e6, None, (0.0,), "when it appears", fitted=False),
    Param("t_r", "s", 0.0, 1e4, None, (0.0,), "how long it grows; 0: a step", fitted=False),
    Param("q", "1/s", 0.0, 1e3, None, (0.0,), "how often it returns; 0: it stays", fitted=False),
    Param("d", "1", 0.0, 1.0, None, (0.5,), "share of each return it is there", fitted=False),
)


def left(f: float, t_0: float, t_r: float, q: float, d: float, t: float) -> float:
    """What is left [1]: 1 without the fault, f once it is fully there; it grows anew at every return."""
    s = t - t_0
    n = floor(s * q)
    r = s - n / max(q, TINY)
    gone = s < 0.0 or (q > 0.0 and s * q - n >= d)
    return 1.0 if gone else 1.0 - (1.0 - f) * min((r + TINY) / (t_r + TINY), 1.0)
