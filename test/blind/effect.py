"""What a hidden effect is: a name, a row of parameters, and how to draw them."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from test.blind.jit import Array
from test.blind.slots import N_COLUMNS


@dataclass(frozen=True)
class Scene:
    """What the undisturbed damper does on the roads of the case; effects are placed by it.

    Attributes:
        deflection: all records joined, (n,) [m].
        hydraulic: viscous and field force, (n,) [N].
        base: k0 [N/m], c0 [N.s/m], fc [N], k1 [1/m], c1 [s/m], tau [s].
        seconds: length of a record [s].
    """

    deflection: Array
    hydraulic: Array
    base: Array
    seconds: float


@dataclass(frozen=True)
class Effect:
    """One hidden effect.

    Attributes:
        name: contract name, or ``outside:<kind>``.
        columns: symbol and unit of each parameter; the first is the strength, neutral at zero.
        typical: strength where the calibration starts.
        least, most: range of the strength's magnitude.
        draw: the other parameters from a generator and the scene.
        acts: laws by the place where they act, a key of `places.PLACES`; arguments are signals of
            `places.SIGNALS`, by name, then the columns in order. ``shown`` is what the instruments do: it changes
            the fine trajectory (m, outputs); arguments are that, its step [s] and the columns.
        slot: row of the effect table, for a law that stands in the integrator itself or that seeds are known of;
            None gives the next one.
        most_negative: largest magnitude of a negative strength; zero where it must be positive.
        shown_by_force: the force along the measured motion shows it, so that its strength can be set by what it
            leaves there; else the strength is drawn.
        hides_in_bias: the effect equals a force offset, so the base must be refitted without one.
    """

    name: str
    columns: tuple[tuple[str, str], ...]
    typical: float
    least: float
    most: float
    draw: Callable[[np.random.Generator, Scene], tuple[float, ...]]
    acts: Mapping[str, Callable[..., Any]] = field(default_factory=dict)
    slot: int | None = None
    most_negative: float = 0.0
    hides_in_bias: bool = False
    shown_by_force: bool = True

    def row(self, strength: float, shape: tuple[float, ...]) -> Array:
        """Row of the effect table, (N_COLUMNS,)."""
        row = np.zeros(N_COLUMNS)
        row[0] = strength
        row[1 : 1 + len(shape)] = shape
        return row

    def named(self, row: Array) -> dict[str, dict[str, float | str]]:
        """Parameters by symbol with unit, for the sealed truth."""
        return {
            symbol: {"value": float(value), "unit": unit}
            for (symbol, unit), value in zip(self.columns, row, strict=False)
        }


def nothing(rng: np.random.Generator, scene: Scene) -> tuple[float, ...]:
    """For effects that have a strength and no other parameter."""
    del rng, scene
    return ()


def between(rng: np.random.Generator, low: float, high: float) -> float:
    """A number drawn evenly on a logarithmic scale; both ends positive."""
    return float(np.exp(rng.uniform(np.log(low), np.log(high))))
