"""The nearest model that a law made for few effects can hold: what it cannot is left out, and named."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace

from er_models.errors import ErError
from er_models.model import Model
from er_models.static_damper import CORE


def nearest(model: Model, holds: Callable[[Model], object]) -> tuple[Model, tuple[str, ...]]:
    """The model, without those effects and measured terms that `holds` refuses with an `ErError`, and their names.

    Values stay as they are. Raises what `holds` raises where even the core terms alone are refused.
    """
    try:
        holds(model)
    except ErError:
        return _without(model, holds)
    return model, ()


def _without(model: Model, holds: Callable[[Model], object]) -> tuple[Model, tuple[str, ...]]:
    names, left_out = set(CORE), [term.name for term in model.terms]
    kept = _of(model, names)
    holds(kept)
    for name in model.effects:
        if name in names:
            continue
        more = _of(model, names | {name})
        try:
            holds(more)
        except ErError:
            left_out.append(name)
        else:
            kept, names = more, names | {name}
    return kept, tuple(left_out)


def _of(model: Model, names: set[str]) -> Model:
    """The model with these of its effects alone, in its own order."""
    effects = {name: values for name, values in model.effects.items() if name in names}
    return replace(model, effects=effects, terms=())
