"""From a model and a wish to proved gains: one call for every observer."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from importlib import import_module
from typing import Protocol

from er_models.errors import ErError, UnknownName
from er_models.linear import LinearForm
from er_models.model import Model

from er_observers.forms import COORDINATES, form_of
from er_observers.programs import OBSERVERS
from er_observers.scaling import Scaling, scaling_of
from er_observers.synthesis import lmi, proportional_integral, unified
from er_observers.synthesis.certify import Certificate, certify
from er_observers.synthesis.lower_bound import lower_bound
from er_observers.synthesis.proof import Claim
from er_observers.synthesis.spec import (
    Output,
    Spec,
    SynthesisFailed,
    every_state,
    force_output,
    state_output,
)


class Theorem(Protocol):
    """What the file of a theorem holds: its title, and two functions."""

    THEOREM: str

    def problem(
        self, form: LinearForm, output: Output, spec: Spec, scaling: Scaling
    ) -> lmi.Problem:
        """The inequalities, for the trade-off and the lower bound."""
        ...

    def claim(self, form: LinearForm, output: Output, spec: Spec, scaling: Scaling) -> Claim:
        """Gains and what they promise; raises `SynthesisFailed` where there are none."""
        ...


THEOREMS: Mapping[str, Theorem] = {
    name: import_module(f"er_observers.synthesis.{name}") for name in OBSERVERS
}
"""The theorem behind each observer: the file of the same name."""
SPECIAL_CASES = {
    "proportional": unified.solve_proportional,
    "integral": proportional_integral.solve,
}
"""Of the unified observer (3.4): (3.5), (3.6)."""
STRUCTURES = ("full", *SPECIAL_CASES)
OUTPUTS = ("force", "states", "thesis")
"""Performance outputs: the damper force, all states of the form, z_e of (4.3)."""


@dataclass(frozen=True)
class Wish:
    """What gains are to be made for.

    force: force error that counts as one [N]; deflection: the one that counts as one [m] where its
    sensor is used, None where there is no such sensor; structure: of the unified observer.
    """

    spec: Spec = field(default_factory=Spec)
    output: str = "force"
    coordinates: str = "relative"
    force: float = 5.0
    deflection: float | None = None
    structure: str = "full"

    def __post_init__(self) -> None:
        choices = (("output", OUTPUTS), ("coordinates", COORDINATES), ("structure", STRUCTURES))
        for key, known in choices:
            found = getattr(self, key)
            if found not in known:
                raise ErError(f"{key}: expected one of {', '.join(known)}, found '{found}'")
        s = self.spec
        sizes = (
            *s.noise,
            s.radius,
            self.force,
            1.0 if self.deflection is None else self.deflection,
        )
        for key, expected, holds, found in (
            ("duty", "0 to 1, the lower first", 0.0 <= s.rho[0] < s.rho[1] <= 1.0, s.rho),
            ("noise, radius, force, deflection", "numbers above 0", min(sizes) > 0.0, sizes),
            ("decay", "a number from 0 to the radius", 0.0 <= s.decay < s.radius, s.decay),
            ("damping", "a ratio from 0 to 1", 0.0 <= s.damping < 1.0, s.damping),
        ):
            if not holds:
                raise ErError(f"{key}: expected {expected}, found {found}")


def synthesise(observer: str, model: Model, wish: Wish | None = None) -> tuple[Claim, Certificate]:
    """Gains of an observer for a vehicle, proved and certified; they may be saved with `save_gains`.

    observer: one of `OBSERVERS`, named after its theorem; wish: what the gains are made for, None: the usual.

    Raises:
        UnknownName: No such observer.
        SynthesisFailed: There are no such gains, or what the solver found is no proof; it names what fails.
        ErError: The model is no vehicle with a damper that the form can hold.
    """
    claim = solve(observer, model, wish or Wish())
    return claim, certify(claim, THEOREMS[observer].THEOREM)


def solve(observer: str, model: Model, wish: Wish) -> Claim:
    """Gains and what they promise, not yet proved; raises as `synthesise`."""
    theorem, asked = _theorem(observer), _asked(model, wish)
    if wish.structure == "full":
        return theorem.claim(*asked)
    if theorem is not unified:
        raise ErError(f"structure: expected full for {observer}, found '{wish.structure}'")
    return Claim(*asked, SPECIAL_CASES[wish.structure](*asked))


def trade_off(
    observer: str, model: Model, wish: Wish, factors: tuple[float, ...] = (0.25, 0.5, 1.0, 2.0)
) -> list[tuple[float, float]]:
    """Pole radius [1/s] and the gamma it allows, for multiples of the radius asked for."""
    problem = _problem(observer, model, wish)
    specs = [replace(problem.spec, radius=f * problem.spec.radius) for f in factors]
    return [(each.radius, lmi.smallest(replace(problem, spec=each))) for each in specs]


def least_gamma(observer: str, model: Model, wish: Wish) -> float | None:
    """Gamma that no gains of the theorem go below, see `lower_bound`; None where there is no proof."""
    try:
        return lower_bound(_problem(observer, model, wish))
    except SynthesisFailed:
        return None


def _theorem(observer: str) -> Theorem:
    """The theorem of an observer; raises `UnknownName`."""
    if observer not in THEOREMS:
        raise UnknownName("observer", observer, tuple(THEOREMS))
    return THEOREMS[observer]


def _problem(observer: str, model: Model, wish: Wish) -> lmi.Problem:
    """The inequalities of an observer's theorem."""
    return _theorem(observer).problem(*_asked(model, wish))


def _asked(model: Model, wish: Wish) -> tuple[LinearForm, Output, Spec, Scaling]:
    """Form, performance output, specification and scaling of a wish."""
    form = form_of(model, wish.coordinates, deflection=wish.deflection is not None)
    spec = wish.spec
    if wish.deflection is not None:
        spec = replace(spec, noise=(*spec.noise[:2], wish.deflection))
    return form, output_of(wish, form, model), spec, scaling_of(model, form)


def output_of(wish: Wish, form: LinearForm, model: Model) -> Output:
    """The performance output asked for; states in the sizes of the model's own motion."""
    if wish.output == "force":
        return force_output(form, wish.force)
    if wish.output == "states":
        return every_state(scaling_of(model, form).state)
    if wish.coordinates == "absolute":
        return state_output(form, ("z_def", "v_s", "v_us", "f_y"))
    return state_output(form, ("z_def", "z_def'", "f_y"))
