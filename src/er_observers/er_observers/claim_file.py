"""A claim as sections of a gain file, and back."""

from __future__ import annotations

from typing import Any

import numpy as np
from er_models.errors import InputError
from er_models.linear import LinearForm

from er_observers.gain_file import Document, flat
from er_observers.synthesis.proof import Claim
from er_observers.synthesis.scaling import Scaling
from er_observers.synthesis.spec import LIPSCHITZ, SLOPE, Output, Solution, Spec

_SECTORS = {sector.name: sector for sector in (SLOPE, LIPSCHITZ)}


def sections(claim: Claim) -> dict[str, Any]:
    """Sections spec, scaling and solution."""
    spec, scaling, solution = claim.spec, claim.scaling, claim.solution
    return {
        "spec": {
            "sector": spec.sector.name,
            "output": {"name": claim.output.name, "rows": flat(claim.output.rows)},
            "rho": list(spec.rho),
            "noise": list(spec.noise),
            "unknown_input": spec.unknown_input,
            "radius": spec.radius,
            "slack": spec.slack,
        },
        "scaling": {
            "state": [float(v) for v in scaling.state],
            "output": [float(v) for v in scaling.output],
            "rate": scaling.rate,
        },
        "solution": {
            "gamma": solution.gamma,
            "optimum": solution.optimum,
            "L": flat(solution.L),
            "P": flat(solution.P),
            "multipliers": [float(v) for v in solution.multipliers],
        },
    }


def claim_of(file: Document, form: LinearForm) -> Claim:
    """What the file promises, about the matrices of `form`."""
    n, m = form.n, form.C.shape[0]
    output = Output(str(file.at("spec.output.name")), file.matrix("spec.output.rows", (None, n)))
    scaling = Scaling(
        state=_positive(file, "scaling.state", n),
        output=_positive(file, "scaling.output", m),
        rate=file.number("scaling.rate"),
    )
    solution = Solution(
        L=file.matrix("solution.L", (2, n, m)),
        P=file.matrix("solution.P", (n, n)),
        multipliers=file.numbers("solution.multipliers", 2),
        gamma=file.number("solution.gamma"),
        optimum=file.number("solution.optimum"),
        solver_status=str(file.at("solver.status")),
    )
    return Claim(form, output, _spec(file, m), scaling, solution)


def _spec(file: Document, outputs: int) -> Spec:
    """What the gains were made to do."""
    sector, rho = file.at("spec.sector"), file.numbers("spec.rho", 2)
    if sector not in _SECTORS:
        raise InputError(file.path, "spec.sector", f"one of {', '.join(_SECTORS)}", sector)
    if not rho[0] < rho[1]:
        raise InputError(file.path, "spec.rho", "the lower duty first", list(rho))
    return Spec(
        sector=_SECTORS[sector],
        rho=(float(rho[0]), float(rho[1])),
        noise=tuple(float(v) for v in file.numbers("spec.noise", outputs)),
        unknown_input=file.number("spec.unknown_input"),
        radius=file.number("spec.radius"),
        slack=file.number("spec.slack"),
    )


def _positive(file: Document, key: str, length: int) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Sizes (length,), above zero."""
    values = file.numbers(key, length)
    if not np.all(values > 0.0):
        raise InputError(file.path, key, "numbers above 0", list(values))
    return values
