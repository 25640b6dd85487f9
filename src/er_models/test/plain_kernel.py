"""The composed kernel of a catalogue run by Python itself: slow, but without a compiler in between.

It lets a test change any equation and ask at once what the whole damper makes of it.
"""

from __future__ import annotations

import math
import re
from types import SimpleNamespace
from typing import Any

import numpy as np
from er_models.catalogue import Catalogue
from er_models.kernel.compose import source

_OURS = re.compile(r"^from (er_models|numba).*$", re.M)
_DECORATORS = ("entry", "inline", "inner", "linked", "once")


def plain_kernel(catalogue: Catalogue) -> Any:
    """The functions of the kernel module as attributes, uncompiled."""
    names: dict[str, Any] = {name: _same for name in _DECORATORS}
    names |= {"math": math, "np": np, "prange": range, "exp": _exp, "tanh": math.tanh}
    names["_compiled"] = lambda effect, hook: catalogue[effect].hooks[hook]
    exec(compile(_OURS.sub("", source(catalogue)), "plain kernel", "exec"), names)
    return SimpleNamespace(**names)


def _same(function: Any) -> Any:
    """In place of a compiler."""
    return function


def _exp(x: float) -> float:
    """The exponential, which does not stop where the result cannot be held."""
    return math.exp(min(x, 700.0))
