"""The mask of a model: which effects are on, and which places of the composed damper can be passed over at once.

A branch costs half a nanosecond even where it is predicted, and a catalogue has fifty effects. So the first
core effect of a hook stands alone, all others behind one mask for the hook, and hooks that few models use
behind one mask for a run of them.
"""

from __future__ import annotations

from collections.abc import Iterable
from functools import lru_cache

import numpy as np
from numpy.typing import NDArray

from er_models.catalogue import Catalogue
from er_models.effect import HOOKS, Effect
from er_models.kernel.order import reads, relaxes_at, turns_with_the_yield

ALONE = ("target", "response_time", "force")
"""Hooks of which the first core effect stands alone: nearly every model has it."""
LAG = "lag"
"""Mask of a yield force with a response time, whichever effect gives it."""
FIELD = "field"
"""Mask of a duty whose chains take that time to form, where an effect acts with them."""
TERMS = "terms"
"""Mask of measured terms."""
TURN = "turn"
"""Mask of lags whose pace depends on where they are."""
RUNS: dict[str, tuple[str, ...]] = {
    "early": (
        "duty", "passive_stiffness", "passive_damping", "yield_scale", "shift_deflection", "shift_velocity",
        "flow_deflection", "flow_velocity",
    ),
    "yield": ("target", "viscous_scale", "stiffness_scale"),
    "pace": ("tau_scale", "response_time"),
    "act": ("states", "force"),
    "end": ("limit", "late", "sense"),
    LAG: (),
    FIELD: (),
    TERMS: (),
    TURN: (),
}  # fmt: skip
"""Places of `kernel.order.ORDER` that follow one another."""


def of_hook(catalogue: Catalogue, hook: str) -> int:
    """Place in the mask that says whether any effect uses a hook, but for the one that stands alone."""
    return len(catalogue.effects) + tuple(HOOKS).index(hook)


def of_run(catalogue: Catalogue, run: str) -> int:
    """Place in the mask that says whether any effect acts in a run of hooks, but for those that stand alone."""
    return len(catalogue.effects) + len(HOOKS) + tuple(RUNS).index(run)


@lru_cache(maxsize=8)
def _alone(catalogue: Catalogue) -> dict[str, Effect]:
    """The core effects that stand alone, by their hook."""
    core = [e for e in reversed(catalogue.effects) if e.stage == "core"]
    return {hook: e for e in core for hook in e.hooks if hook in ALONE}


def stands_alone(catalogue: Catalogue, effect: Effect, hook: str) -> bool:
    """Whether an effect's hook stands before the mask of the hook."""
    return _alone(catalogue).get(hook) is effect


def mask(
    catalogue: Catalogue, used: Iterable[Effect], terms: frozenset[str] = frozenset()
) -> NDArray[np.uint8]:
    """Mask of a model of these effects (n_effects + n_hooks + n_runs,); terms: signals that measured terms read."""
    used = tuple(used)
    on = np.zeros(len(catalogue.effects) + len(HOOKS) + len(RUNS), np.uint8)
    for effect in used:
        on[catalogue.effects.index(effect)] = 1
        more = {hook for hook in effect.hooks if not stands_alone(catalogue, effect, hook)}
        for hook in more:
            on[of_hook(catalogue, hook)] = 1
        for run, places in RUNS.items():
            on[of_run(catalogue, run)] |= not {*more, relaxes_at(effect)}.isdisjoint(places)
        on[of_run(catalogue, LAG)] |= "response_time" in effect.hooks
    on[of_run(catalogue, TERMS)] = bool(terms)
    on[of_run(catalogue, TURN)] = turns_with_the_yield(used)
    end, early = of_run(catalogue, "end"), of_run(catalogue, "early")
    on[end] |= on[early] or bool(terms)  # which may read the rest of the force, and add to it
    field = reads(used, "u_f") or "u_f" in terms
    on[of_run(catalogue, FIELD)] = on[of_run(catalogue, LAG)] and field
    on[of_run(catalogue, "act")] |= on[of_run(catalogue, FIELD)]
    return on
