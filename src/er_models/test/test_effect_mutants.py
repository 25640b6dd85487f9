"""Hand-worked values are worth what they notice: each hook is broken, one at a time, and its effect's values must fail.

The kernel is run by Python (`plain_kernel`), so a broken equation needs no compiler; that it computes what
the compiled one does is a test of its own.
"""

from __future__ import annotations

import dataclasses
import inspect
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import er_models.prediction
import er_models.rhs
import numpy as np
import pytest
import worked
from er_models.catalogue import CATALOGUE, Catalogue
from er_models.effect import Effect
from plain_kernel import plain_kernel

HOOKS = [(e, hook) for e in CATALOGUE.effects for hook in e.hooks]
BREAKS: dict[str, Callable[[float], float]] = {
    "negated": lambda y: -y,
    "1 % too large": lambda y: 1.01 * y,
}
HALVES = {"rate": (True, False), "drive": (False, True), "both": (True, True)}


def broken(effect: Effect, hook: str, change: Callable[..., object]) -> Catalogue:
    """The catalogue with what a hook returns changed."""
    function = effect.hooks[hook]

    def other(*arguments: float, **named: float) -> object:
        return change(function(*arguments, **named))

    other.__signature__ = inspect.signature(function)  # type: ignore[attr-defined]
    changed = dataclasses.replace(effect, hooks={**effect.hooks, hook: other})
    return Catalogue(tuple(changed if e is effect else e for e in CATALOGUE.effects))


def mutants(effect: Effect, hook: str) -> Iterator[tuple[str, Catalogue]]:
    """Every break of a hook; of a pair (rate, drive) also each half by itself."""
    for name, change in BREAKS.items():
        if hook != "relax":
            yield name, broken(effect, hook, change)
            continue
        for part, chosen in HALVES.items():
            if part != "rate" or _decays(effect, name):
                yield f"{part} {name}", broken(effect, hook, partial(_changed, change, chosen))


def _changed(
    change: Callable[[float], float], chosen: tuple[bool, bool], pair: tuple[float, float]
) -> tuple[float, ...]:
    """A pair with the chosen halves changed."""
    return tuple(change(y) if yes else y for y, yes in zip(pair, chosen, strict=True))


def _decays(effect: Effect, name: str) -> bool:
    """Whether a break of the rate of an effect's state can show: zero has none, next to zero only its sign."""
    relax: Callable[..., tuple[float, float]] = effect.hooks["relax"]  # type: ignore[assignment]
    rate = relax(*[0.7] * len(inspect.signature(relax).parameters))[0]
    return rate > 1e-9 or (rate != 0.0 and name == "negated")


def failures(name: str, catalogue: Catalogue, patch: pytest.MonkeyPatch) -> int:
    """How many of an effect's values fail with a catalogue."""
    kernel = plain_kernel(catalogue)
    with patch.context() as p, np.errstate(all="ignore"):
        for module in (er_models.prediction, er_models.rhs, worked):
            p.setattr(module, "kernel", lambda _: kernel)
        return sum(_fails(case, name, catalogue) for case in worked.of(name).WORKED)


def _fails(case: Any, name: str, catalogue: Catalogue) -> bool:
    """Whether a value fails, or cannot even be computed."""
    try:
        case.check(name, catalogue)
    except (AssertionError, ArithmeticError):
        return True
    return False


def test_python_computes_what_the_kernel_does(monkeypatch: pytest.MonkeyPatch) -> None:
    for effect in CATALOGUE.effects:
        assert failures(effect.name, CATALOGUE, monkeypatch) == 0, effect.name


@pytest.mark.parametrize(("effect", "hook"), HOOKS, ids=[f"{e.name}.{h}" for e, h in HOOKS])
def test_a_broken_hook_is_noticed(
    effect: Effect, hook: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    for how, catalogue in mutants(effect, hook):
        assert failures(effect.name, catalogue, monkeypatch) > 0, f"{hook} {how}: nobody notices"
