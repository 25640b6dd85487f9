"""From a model and a wish to proved gains: one call for every observer."""

from __future__ import annotations

from dataclasses import dataclass, field, replace

from er_models.errors import ErError
from er_models.linear import LinearForm
from er_models.model import Model

from er_observers.forms import COORDINATES, form_of
from er_observers.synthesis import nlpv_gridding, nlpv_polytopic, proportional_integral, unified
from er_observers.synthesis.certify import Certificate, certify
from er_observers.synthesis.proof import Claim
from er_observers.synthesis.scaling import scaling_of
from er_observers.synthesis.spec import (
    Output,
    Spec,
    every_state,
    force_output,
    state_output,
)

THEOREMS = {each.NAME: each.THEOREM for each in (unified, nlpv_polytopic, nlpv_gridding)}
"""Title of the theorem behind each observer."""
STRUCTURES = {
    "full": unified.solve,
    "proportional": unified.solve_proportional,
    "integral": proportional_integral.solve,
}
"""The unified observer (3.4) and its special cases (3.5), (3.6)."""
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
            if getattr(self, key) not in known:
                raise ErError(
                    f"{key}: expected one of {', '.join(known)}, found '{getattr(self, key)}'"
                )


def make(observer: str, model: Model, wish: Wish) -> tuple[Claim, Certificate]:
    """Solve, prove and certify.

    Raises `SynthesisFailed`, or what the form raises for a model it cannot hold.
    """
    claim = solve(observer, model, wish)
    return claim, certify(claim, THEOREMS[observer])


def solve(observer: str, model: Model, wish: Wish) -> Claim:
    """Gains and what they promise, not yet proved; raises as `make`."""
    form = form_of(model, wish.coordinates, deflection=wish.deflection is not None)
    spec = wish.spec
    if wish.deflection is not None:
        spec = replace(spec, noise=(*spec.noise[:2], wish.deflection))
    scaling, output = scaling_of(model, form), output_of(wish, form, model)
    if observer == nlpv_gridding.NAME:
        return nlpv_gridding.claim(form, output, spec, scaling)
    theorem = nlpv_polytopic.solve
    if observer == unified.NAME:
        theorem = STRUCTURES[wish.structure]
    return Claim(form, output, spec, scaling, theorem(form, output, spec, scaling))


def output_of(wish: Wish, form: LinearForm, model: Model) -> Output:
    """The performance output asked for; states in the sizes of the model's own motion."""
    if wish.output == "force":
        return force_output(form, wish.force)
    if wish.output == "states":
        return every_state(scaling_of(model, form).state)
    if wish.coordinates == "absolute":
        return state_output(form, ("z_def", "v_s", "v_us", "f_y"))
    return state_output(form, ("z_def", "z_def'", "f_y"))
