"""Error of a model on fresh data of the generator, and the least that can be asked for there."""

from __future__ import annotations

from er_models.model import Model

from test.blind.along import force_along
from test.blind.case import Case
from test.blind_score.fused import errors_on


def fresh_errors(case: Case, model: Model) -> dict[str, float | bool]:
    """Root mean square errors [N] on a case that nobody has learnt from, as of `errors_on`."""
    return errors_on(
        case.directory,
        model,
        lambda record, t, motion: force_along(case, record, motion),
        [(c["t"], c["damper_force"]) for c in case.clean],
    )
