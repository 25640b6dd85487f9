"""When an effect is worth a name."""

from __future__ import annotations

from dataclasses import dataclass

from er_models.errors import InputError

from er_model_lab.smallest import SMALLEST

BAND = 0.05
"""Share [1] by which an error of what was not learnt from may grow and still counts as the same."""


@dataclass(frozen=True)
class Rule:
    """Three thresholds, all of which an effect must pass, and what is asked besides.

    false_alarm: rate at which a complete model may be given a missing effect; smallest: size as a share of the
    noise below which no effect is named, however certain: what differs so little may as well be the form of
    another law; helps: share of what is explainable that what is named must explain together; small_steps: as beside
    effects that explain a part, less steadiness is asked for, errors of a motion that is rounded at its reversals only
    where they act, and an effect whose values the data do not determine is not taken; goes_on: another search follows,
    so that nothing is exchanged while a further effect passes and more than noise is left; barred: effects that are
    not taken, as held-out data refuse them.

    Raises:
        InputError: a rate or a share that is none.
    """

    false_alarm: float = 0.01
    smallest: float = SMALLEST
    helps: float = 0.2
    small_steps: bool = False
    goes_on: bool = False
    barred: frozenset[str] = frozenset()

    def __post_init__(self) -> None:
        if not 0.0 < self.false_alarm < 1.0:
            raise InputError("false_alarm", "", "a rate above 0 and below 1", self.false_alarm)
        for name, share in (("smallest", self.smallest), ("helps", self.helps)):
            if not 0.0 <= share <= 1.0:
                raise InputError(name, "", "a share from 0 to 1", share)


RULE = Rule()
"""The rule unless another is asked for."""
