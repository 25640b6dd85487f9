"""Hands the hooks of the catalogue in use to the generated kernel module."""

from __future__ import annotations

import math
from types import FunctionType
from typing import Any

from numba import njit

from er_models.catalogue import CATALOGUE, Catalogue
from er_models.kernel import fast

_in_use: list[Catalogue] = [CATALOGUE]
_FASTER = {math.tanh: fast.tanh}


def use(catalogue: Catalogue) -> None:
    """Make `compiled` serve this catalogue; called just before its module is imported."""
    _in_use[0] = catalogue


def compiled(effect: str, hook: str) -> Any:
    """The hook of an effect, compiled for inlining, with faster elementary functions."""
    function = _in_use[0][effect].hooks[hook]
    assert isinstance(function, FunctionType)
    names = {k: _FASTER.get(v, v) if callable(v) else v for k, v in function.__globals__.items()}
    faster = FunctionType(function.__code__, names, function.__name__, function.__defaults__)
    return njit(error_model="numpy", forceinline=True)(faster)
