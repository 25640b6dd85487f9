"""The observers there are: name, and the module that loads their gains."""

from __future__ import annotations

from collections.abc import Callable, Mapping

from er_observers.gains import Gains
from er_observers.observers import nlpv_gridding, nlpv_polytopic, unified

OBSERVERS: Mapping[str, Callable[..., Gains]] = {
    module.NAME: module.load_gains for module in (unified, nlpv_polytopic, nlpv_gridding)
}
"""``load_gains(path, model, limits=LIMITS)`` of each observer, by its name."""
