"""What the kernel must know of a model besides its values: masks, and the states in use."""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache
from typing import NamedTuple

import numpy as np
from numpy.typing import NDArray

from er_models.catalogue import Catalogue
from er_models.kernel.mask import mask
from er_models.kernel.order import (
    caught,
    feeds_back,
    reads,
    reads_yield_early,
    slides,
)

ZERO, HEAT, CAUGHT, SLIDES = 1, 2, 3, 4
"""Marks in `at_rest` of a state that begins at zero, of one that goes on from one record to the next, and of one that
settles, but may begin wherever a contact or friction catches it, behind a play or without one."""


class Layout(NamedTuple):
    """on: mask (`kernel.mask`); slots: states in use; links: those of them that feed back.

    at_rest (n_states,): `ZERO`, `HEAT`, `CAUGHT`, `SLIDES`, or 0 for a state that begins settled.
    """

    on: NDArray[np.uint8]
    slots: NDArray[np.int64]
    links: NDArray[np.int64]
    at_rest: NDArray[np.uint8]


def responds(c: Catalogue, names: Iterable[str]) -> bool:
    """Whether the yield force of a model of these effects lags."""
    return any("response_time" in c[name].hooks for name in names)


@lru_cache(maxsize=256)
def layout(
    c: Catalogue, names: frozenset[str], plant: bool, terms: frozenset[str] = frozenset()
) -> Layout:
    """Layout of a model of these effects; plant: without the maps from measured to true motion.

    terms: signals that its measured terms read.

    The arrays are shared: whoever writes takes copies.
    """
    used = [e for e in c.effects if e.name in names and not (plant and e.maps_motion)]
    lags = responds(c, names)
    slots, links, rest = set(), set(), np.zeros(c.n_states, np.uint8)
    if lags:
        slots.add(c.slots["response"])
    if reads_yield_early(used):
        slots.add(c.slots["response"])
        links.add(c.slots["response"])
    if "lagged" in terms:
        slots.add(c.lagged)
    if lags and (reads(used, "u_f") or "u_f" in terms):
        slots.add(c.formed)
    if reads(used, "f_r"):
        links.add(c.rest)  # in series: f_r follows only from the motion that is left to the damper
    for effect in used:
        if effect.has_state:
            slots.add(c.slots[effect.name])
            warms = effect.stage == "heat"
            settled = SLIDES if slides(effect) else CAUGHT * caught(effect)
            rest[c.slots[effect.name]] = (
                (HEAT if warms else ZERO) if effect.initial == "zero" else settled
            )
        if feeds_back(effect):
            links.add(c.slots[effect.name])
    return Layout(mask(c, used, terms), _sorted(slots), _sorted(links), rest)


def _sorted(slots: set[int]) -> NDArray[np.int64]:
    """Slots in order."""
    return np.array(sorted(slots), np.int64)
