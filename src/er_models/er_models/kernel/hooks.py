"""Hands the hooks of the catalogue in use to the generated kernel module."""

from __future__ import annotations

from typing import Any

from numba import njit

from er_models.catalogue import CATALOGUE, Catalogue

_in_use: list[Catalogue] = [CATALOGUE]


def use(catalogue: Catalogue) -> None:
    """Make `compiled` serve this catalogue; called just before its module is imported."""
    _in_use[0] = catalogue


def compiled(effect: str, hook: str) -> Any:
    """The hook of an effect, compiled for inlining."""
    return njit(error_model="numpy")(_in_use[0][effect].hooks[hook])
