"""Hands the hooks that cannot be written into their place to the generated kernel module."""

from __future__ import annotations

from types import BuiltinFunctionType, FunctionType
from typing import Any

from er_models.catalogue import CATALOGUE, Catalogue
from er_models.kernel.elementary import FASTER
from er_models.kernel.fast import inline

_in_use: list[Catalogue] = [CATALOGUE]


def use(catalogue: Catalogue) -> None:
    """Make `compiled` serve this catalogue; called just before its module is imported."""
    _in_use[0] = catalogue


def compiled(effect: str, hook: str) -> Any:
    """The hook of an effect, compiled for inlining, with its helpers and faster elementary functions."""
    return inline(with_compiled_names(_in_use[0][effect].hooks[hook]))


def with_compiled_names(function: Any) -> FunctionType:
    """The function again, with what it calls replaced by what can be compiled."""
    names = dict(function.__globals__)
    for name in function.__code__.co_names:
        value = names.get(name)
        if isinstance(value, FunctionType):
            names[name] = inline(with_compiled_names(value))
        elif isinstance(value, BuiltinFunctionType):
            names[name] = FASTER.get(value, value)
    return FunctionType(function.__code__, names, function.__name__, function.__defaults__)
