"""A claim as sections of a gain file, and back."""

from __future__ import annotations

from typing import Any

import numpy as np
from er_models.errors import InputError
from er_models.gain_file import Document, flat
from er_models.linear import LinearForm

from er_observers.law import RESIDUAL, Law, luenberger
from er_observers.scaling import Scaling
from er_observers.synthesis.proof import Claim
from er_observers.synthesis.spec import SECTORS, Output, Solution, Spec

_MATRICES = ("M", "J", "T", "R", "S")


def sections(claim: Claim) -> dict[str, Any]:
    """Sections spec, scaling, law, solution and, where there is one, common."""
    spec, scaling = claim.spec, claim.scaling
    found = {
        "spec": {
            "sector": spec.sector.name,
            "output": {"name": claim.output.name, "rows": flat(claim.output.rows)},
            "rho": list(spec.rho),
            "noise": list(spec.noise),
            "unknown_input": spec.unknown_input,
            "radius": spec.radius,
            "decay": spec.decay,
            "damping": spec.damping,
            "slack": spec.slack,
        },
        "scaling": {
            "state": [float(v) for v in scaling.state],
            "output": [float(v) for v in scaling.output],
            "rate": scaling.rate,
        },
        "law": _law_section(claim.solution.law),
        "solution": _solution_section(claim.solution),
    }
    if claim.common is not None:
        found["common"] = _solution_section(claim.common)
    return found


def _law_section(law: Law) -> dict[str, Any]:
    """Gains L, and S where the reading takes outputs, where they say it all, else the matrices."""
    rho = [float(v) for v in law.rho]
    if law.is_luenberger:
        reading = {"S": flat(law.S)} if np.any(law.S) else {}
        return {"rho": rho, "L": flat(law.J), **reading}
    return {"rho": rho, **{name: flat(getattr(law, name)) for name in _MATRICES}}


def _solution_section(s: Solution) -> dict[str, Any]:
    """Lyapunov function, multipliers and gamma."""
    found: dict[str, Any] = {"gamma": s.gamma, "optimum": s.optimum, "P": flat(s.P)}
    if np.any(s.P_1):
        found |= {"P_1": flat(s.P_1), "rate": s.rate}
    return found | {"multipliers": [float(v) for v in s.multipliers]}


def claim_of(file: Document, form: LinearForm) -> Claim:
    """What the file promises, about the matrices of `form`."""
    n, m = form.n, form.C.shape[0]
    output = Output(str(file.at("spec.output.name")), file.matrix("spec.output.rows", (None, n)))
    scaling = Scaling(
        state=_positive(file, "scaling.state", n),
        output=_positive(file, "scaling.output", m),
        rate=file.number("scaling.rate"),
    )
    law = _law(file, form)
    common = _solution(file, "common", law) if "common" in file.content else None
    return Claim(form, output, _spec(file, m), scaling, _solution(file, "solution", law), common)


def _law(file: Document, form: LinearForm) -> Law:
    """The law, from its gains or its matrices."""
    n, m = form.n, form.C.shape[0]
    rho = file.at("law.rho")
    rho = file.numbers("law.rho", max(2, len(rho) if isinstance(rho, list) else 2))
    k = len(rho)
    if not np.all(np.diff(rho) > 0.0):
        raise InputError(file.path, "law.rho", "rising duties", list(rho))
    if "L" in file.at("law"):
        S = file.matrix("law.S", (n, m)) if "S" in file.at("law") else None
        return luenberger(form, rho, file.matrix("law.L", (k, n, m)), S)
    T = file.matrix("law.T", (None, n))
    order = T.shape[0]
    shapes = {"M": (k, order, order), "J": (k, order, m), "R": (n, order), "S": (n, m)}
    law = Law(rho, T=T, **{key: file.matrix(f"law.{key}", s) for key, s in shapes.items()})
    residual = law.residual(form, _positive(file, "scaling.state", n))
    if not residual <= RESIDUAL:
        expected = f"matrices with M T + J C = T A and R T + S C = I to {RESIDUAL:g}"
        raise InputError(file.path, "law", expected, f"a residual of {residual:.3g}")
    return law


def _solution(file: Document, key: str, law: Law) -> Solution:
    """One Lyapunov function."""
    square = (law.order, law.order)
    moving = "P_1" in file.at(key)
    return Solution(
        law=law,
        P=file.matrix(f"{key}.P", square),
        P_1=file.matrix(f"{key}.P_1", square) if moving else np.zeros(square),
        rate=file.number(f"{key}.rate") if moving else 0.0,
        multipliers=file.numbers(f"{key}.multipliers", len(law.rho)),
        gamma=file.number(f"{key}.gamma"),
        optimum=file.number(f"{key}.optimum"),
        solver_status=str(file.at("solver.status")),
    )


def _spec(file: Document, outputs: int) -> Spec:
    """What the gains were made to do."""
    sector, rho = file.at("spec.sector"), file.numbers("spec.rho", 2)
    if sector not in SECTORS:
        raise InputError(file.path, "spec.sector", f"one of {', '.join(SECTORS)}", sector)
    if not rho[0] < rho[1]:
        raise InputError(file.path, "spec.rho", "the lower duty first", list(rho))
    return Spec(
        sector=SECTORS[sector],
        rho=(float(rho[0]), float(rho[1])),
        noise=tuple(float(v) for v in file.numbers("spec.noise", outputs)),
        unknown_input=file.number("spec.unknown_input"),
        radius=file.number("spec.radius"),
        decay=file.number("spec.decay"),
        damping=file.number("spec.damping"),
        slack=file.number("spec.slack"),
    )


def _positive(file: Document, key: str, length: int) -> np.ndarray[Any, np.dtype[np.float64]]:
    """Sizes (length,), above zero."""
    values = file.numbers(key, length)
    if not np.all(values > 0.0):
        raise InputError(file.path, key, "numbers above 0", list(values))
    return values
