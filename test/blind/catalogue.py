"""Every effect the generator can hide: what the files in `truth/` hold."""

from __future__ import annotations

from dataclasses import replace
from importlib import import_module
from pkgutil import iter_modules

import numpy as np

from test.blind import truth
from test.blind.effect import Effect
from test.blind.errors import BlindError
from test.blind.slots import FIXED_ROWS


def _discovered() -> tuple[Effect, ...]:
    """Every `Effect` of every file in `truth/`: first those whose row seeds are known of, then others by name."""
    files = (import_module(f"{truth.__name__}.{m.name}") for m in iter_modules(truth.__path__))
    found = [each for file in files for each in vars(file).values() if isinstance(each, Effect)]
    later = sorted((e for e in found if e.slot is None), key=lambda e: e.name)
    rows = (replace(e, slot=FIXED_ROWS + k) for k, e in enumerate(later))
    return (*sorted((e for e in found if e.slot is not None), key=lambda e: e.slot), *rows)


EVERY = _discovered()
N_EFFECTS = len(EVERY)
OUTSIDE = tuple(e for e in EVERY if e.name.startswith("outside:"))
VEHICLE = tuple(e for e in EVERY if not e.shown_by_force)
"""Effects of the car: the damper force along the measured motion does not show them."""
INSIDE = tuple(e for e in EVERY if e not in OUTSIDE and e not in VEHICLE)

BY_NAME = {effect.name: effect for effect in EVERY}


def choose(effect: str | list[str] | None, rng: np.random.Generator) -> list[Effect]:
    """Effects asked for: none, one, several, or ``random`` (one of the catalogue's own).

    Raises:
        BlindError: an unknown name, or the same effect twice.
    """
    names = [] if effect is None else [effect] if isinstance(effect, str) else list(effect)
    if len(set(names)) != len(names):
        raise BlindError(f"--effect: expected different effects, found {', '.join(names)}")
    chosen = []
    for name in names:
        if name == "random":
            chosen.append(INSIDE[int(rng.integers(len(INSIDE)))])
        elif name in BY_NAME:
            chosen.append(BY_NAME[name])
        else:
            known = ", ".join(BY_NAME)
            raise BlindError(f"--effect: expected one of {known}, random or none, found {name!r}")
    return chosen
