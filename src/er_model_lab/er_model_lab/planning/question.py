"""The question: which two explanations are to be told apart."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

from er_models.effect import Effect
from er_models.errors import ErError
from er_models.model import Model

KINEMATIC = "velocity_lag"
"""Read off deflection and velocity alone, in any motion."""


@dataclass(frozen=True)
class Question:
    """Two effects that compete, or one against its absence (`second` None).

    base: the model with neither of them; held: values [SI] of those that the model held.
    """

    base: Model
    first: str
    second: str | None
    held: Mapping[str, Mapping[str, float]] = field(default_factory=dict)

    @property
    def names(self) -> tuple[str, ...]:
        """The effects, one or two."""
        return (self.first,) if self.second is None else (self.first, self.second)

    def effect(self, name: str) -> Effect:
        """One of the effects."""
        return self.base.catalogue[name]


def ask(model: Model, between: tuple[str, ...], reveal: str | None) -> Question:
    """The question; an effect that the model holds is taken out of it.

    Raises `ErError`: nothing or too much asked, unknown effect, the same twice, one that no
    measurement of the damper force can tell or needs to tell.
    """
    if bool(between) == (reveal is not None):
        found = "both" if between else "neither"
        raise ErError(f"plan: expected either between, two effects, or reveal, one, found {found}")
    names = between or (str(reveal),)
    for name in names:
        _can_be_asked(model, name)
    if len(names) == 2 and names[0] == names[1]:
        raise ErError(f"between: expected two different effects, found '{names[0]}' twice")
    kept = {k: v for k, v in model.effects.items() if k not in names}
    held = {k: v for k, v in model.effects.items() if k in names}
    second = names[1] if len(names) == 2 else None
    return Question(replace(model, effects=kept), names[0], second, held)


def _can_be_asked(model: Model, name: str) -> None:
    """Refuse what a measured damper force cannot decide."""
    effect = model.catalogue[name]
    if not effect.knowable:
        raise ErError(f"{name} cannot be known from these channels: {effect.unknowable_because}")
    if effect.stage == "vehicle":
        raise ErError(
            f"{name} acts in the vehicle, not in the damper: the damper force cannot show it"
        )
    if effect.stage == "core" and name != "response":
        raise ErError(
            f"{name} is a term of the damper model itself: expected an effect of the catalogue"
        )
    if name == KINEMATIC:
        raise ErError(
            f"{name} needs no plan: deflection and velocity channel show it in any motion"
        )
