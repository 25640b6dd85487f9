"""Chapter 6 of the thesis, first part: faults of the damper, the duties that mimic them, the forces left."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from er_models.constants import SAMPLE_TIME as DT
from er_models.files import load_model
from er_models.forms.loss import Factors
from er_models.model import Array, Model
from er_models.prediction import motion, predict
from er_models.program import load_program, resolve, times
from er_models.simulation import simulate
from er_models.static_damper import HEALTHY, Domain, Mimic, StaticDamper, static_damper

DUTIES = (0.0, 1.0)
"""Limits of the duty in (6.14)."""
LEAK = Factors(leakage=0.6)
"""Fault of figure 6.12."""
POINTS = 201
EFFECTS = {
    "electrical": "electrical_fault",
    "leakage": "oil_leakage",
    "deformation": "duct_deformation",
}
"""Effect of the catalogue for each factor of (6.8)."""
SEQUENCES: dict[str, tuple[Factors, ...]] = {
    "electrical": tuple(Factors(electrical=f) for f in (1.0, 0.75, 0.5, 0.25)),
    "leakage": (Factors(leakage=0.9),),
    "deformation": (Factors(deformation=0.9),),
    "combined": (Factors(0.9, 0.95, 0.9),),
    "heavy": (LEAK,),
}
"""Faults one after the other over the record: figures 6.1-6.3, 6.4-6.6, 6.7-6.9, all three (6.8), the leak of 6.4."""


@dataclass(frozen=True, eq=False)
class Case:
    """One fault: duty that mimics it, and forces [N], (n,) each; factor (n,): the smallest of the three."""

    name: str
    mimic: Mimic
    faulty: Array
    copied: Array
    factor: Array

    @property
    def exists(self) -> float:
        """Share of the samples at which a duty mimics the fault."""
        return float(self.mimic.exists.mean())

    @property
    def worst(self) -> float:
        """Largest difference of mimic and fault where a duty exists, as a share of the faulty force's range."""
        apart = np.abs(self.copied - self.faulty)[self.mimic.exists]
        return float(apart.max(initial=0.0) / np.ptp(self.faulty))


@dataclass(frozen=True, eq=False)
class Chapter6:
    """Motion, healthy force and cases; ideal and real: velocities and healthy and leaking domains on them."""

    model: Model
    t: Array
    x: Array
    v: Array
    duty: Array
    healthy: Array
    cases: tuple[Case, ...]
    velocity: Array
    ideal: tuple[Domain, Domain]
    real: tuple[Domain, Domain]


def chapter_6(config: Path, tick: Callable[[str], None] | None = None) -> Chapter6:
    """Make all of it.

    config: folder with `vehicles/inove_quarter_car.yaml`, `dampers/inove_bingham.yaml` (the law of chapter 6) and
    `simulations/chapter_6.yaml`. Raises `InputError` for files that are not there or not good.
    """
    say = tick or (lambda _: None)
    car = load_model(config / "vehicles" / "inove_quarter_car.yaml")
    model = load_model(config / "dampers" / "inove_bingham.yaml")
    program = resolve(load_program(config / "simulations" / "chapter_6.yaml"), car, DT)
    say("riding")
    t = times(program.duration, DT)
    road, duty = program.ride(DT)
    record = simulate(car, DT, road, duty)
    x, v = record["deflection"], record["deflection_velocity"]
    cases = []
    for name, faults in SEQUENCES.items():
        say(f"fault, {name}")
        cases.append(_case(model, name, faults, (x, v, duty)))
    top, damper = model.scales.velocity, static_damper(model)
    velocity = np.linspace(-top, top, POINTS)
    return Chapter6(
        model, t, x, v, duty, predict(model, motion(DT, x, v, duty)), tuple(cases), velocity,
        ideal=_domains(damper, np.zeros(POINTS), velocity), real=_domains(damper, x, v),
    )  # fmt: skip


def _domains(damper: StaticDamper, x: Array, v: Array) -> tuple[Domain, Domain]:
    """Forces (6.14) of the healthy and of the leaking damper."""
    healthy, leaking = (damper.domain(x, v, DUTIES, left) for left in (HEALTHY, LEAK))
    return healthy, leaking


def _case(
    model: Model, name: str, faults: tuple[Factors, ...], ride: tuple[Array, Array, Array]
) -> Case:
    """A sequence of faults, each over its part of the ride (x, v, duty)."""
    damper, n = static_damper(model), ride[0].size
    parts = np.array_split(np.arange(n), len(faults))
    duty, exists, faulty, copied, factor = (np.empty(n) for _ in range(5))
    for rows, left in zip(parts, faults, strict=True):
        x, v, u = (signal[rows] for signal in ride)
        found = damper.mimic(x, v, u, left)
        duty[rows], exists[rows] = found.duty, found.exists
        faulty[rows] = predict(with_faults(model, left), motion(DT, x, v, u))
        copied[rows] = predict(model, motion(DT, x, v, found.duty))
        factor[rows] = min(left.electrical, left.leakage, left.deformation)
    return Case(name, Mimic(duty, exists.astype(bool)), faulty, copied, factor)


def with_faults(model: Model, left: Factors) -> Model:
    """The model with the effects of (6.8), there from the first instant on."""
    for factor, effect in EFFECTS.items():
        model = model.with_effect(effect, {"f": getattr(left, factor)})
    return model
