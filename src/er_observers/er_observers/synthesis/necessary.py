"""Conditions that every observer gain must meet, with numbers: why a synthesis has no solution.

At zero frequency both accelerations vanish whatever constant force the damper holds, so part of
the error is out of reach of any gain. These facts need no solver.
"""

from __future__ import annotations

import numpy as np
from er_models.linear import LinearForm
from er_models.model import Array

from er_observers.synthesis.spec import Output, Spec

_TINY = 1e-9


def static_gate_gain(form: LinearForm, rho: float) -> float | None:
    """Gain at s = 0 from an error d of the gate to Gamma e, where no observer gain can change it.

    A constant error e with ``A e + B rho d = 0`` and ``C e = 0`` shows in no output, so every
    stabilising L gives the same. For two accelerometers it is
    -k1 f_c rho / (k_s + k_0) = -3.6004 rho. None where the outputs see e.
    """
    hidden = _hidden(form, -form.B * rho)
    return None if hidden is None else float(form.Gamma @ hidden)


def road_blind_gain(form: LinearForm, output: Output, spec: Spec) -> float:
    """Lower bound of gamma that no observer can beat, from an unknown input that does not show.

    The thesis's state has it: a car climbing at constant speed shows no acceleration, so both
    absolute velocities are wrong by the road's. With its C_z this is sqrt(2). Zero where the
    unknown input cannot hide at s = 0.
    """
    hidden = _hidden(form, -form.D1 * spec.unknown_input)
    return 0.0 if hidden is None else float(np.linalg.norm(output.rows @ hidden))


def undetectable(form: LinearForm) -> list[complex]:
    """Eigenvalues of A, not decaying, whose direction shows in no output: no gain moves them."""
    sizes = _row_sizes(np.vstack([form.A, form.C]))
    found = []
    for pole in np.linalg.eigvals(form.A):
        pencil = np.vstack([pole * np.eye(form.n) - form.A, form.C]) / sizes
        if pole.real >= -_TINY and np.linalg.svd(pencil, compute_uv=False)[-1] < _TINY:
            found.append(complex(pole))
    return found


def decoupling_ranks(form: LinearForm) -> tuple[int, int]:
    """rank(C D1) and rank(D1), equal where the unknown input can be decoupled exactly."""
    d_1 = form.D1[:, None]
    return int(np.linalg.matrix_rank(form.C @ d_1)), int(np.linalg.matrix_rank(d_1))


def violated(form: LinearForm, output: Output, spec: Spec) -> list[str]:
    """Sentences naming every necessary condition that is broken, with numbers; empty when none."""
    reasons = []
    poles = undetectable(form)
    if poles:
        names = ", ".join(f"{p:.3g}" for p in poles)
        reasons.append(f"the poles {names} show in no output, so no gain moves them")
    rho = max(spec.rho)
    gain = static_gate_gain(form, rho)
    if gain is not None and _outside(spec, gain):
        reasons.append(
            f"at zero frequency an error d of the gate makes Gamma e = {gain:.4f} d at rho = "
            f"{rho:g} whatever the gain, which the {spec.sector.name} bound does not allow; "
            f"it needs rho below {_largest_rho(form, spec, rho):.4f}"
        )
    floor = road_blind_gain(form, output, spec)
    if floor > spec.gamma_max:
        reasons.append(
            f"the unknown input {form.unknown_input} has an invariant zero at s = 0: it shows in "
            f"no acceleration but moves the output '{output.name}' by {floor:.4f}, so gamma "
            f"cannot be below {floor:.4f}, asked for {spec.gamma_max:.5g}"
        )
    return reasons


def _outside(spec: Spec, gain: float) -> bool:
    """Whether the loop is unstable inside the sector at zero frequency, s = gain d."""
    loop = np.array([gain, 1.0])
    return float(loop @ spec.sector.form @ loop) >= 0.0


def _largest_rho(form: LinearForm, spec: Spec, rho: float) -> float:
    """Largest duty below `rho` that the sector bound allows at zero frequency, by bisection."""
    low, high = 0.0, rho
    for _ in range(60):
        middle = 0.5 * (low + high)
        gain = static_gate_gain(form, middle)
        fails = gain is not None and _outside(spec, gain)
        low, high = (low, middle) if fails else (middle, high)
    return low


def _hidden(form: LinearForm, right: Array) -> Array | None:
    """Error e with ``A e = right`` (n,) and ``C e = 0`` where there is one, else None."""
    rows = np.vstack([form.A, form.C])
    whole = np.concatenate([right, np.zeros(form.C.shape[0])])
    sizes = _row_sizes(rows)[:, 0]
    solution, *_ = np.linalg.lstsq(rows / sizes[:, None], whole / sizes, rcond=1e-14)
    allowed = _TINY * (np.abs(whole) + sizes * np.abs(solution).max())
    error: Array = np.array(solution, np.float64)
    return error if np.all(np.abs(rows @ solution - whole) <= allowed) else None


def _row_sizes(rows: Array) -> Array:
    """Largest entry of each row (n, 1), one for rows of zeros."""
    sizes = np.abs(rows).max(axis=1, keepdims=True)
    return np.where(sizes > 0.0, sizes, 1.0)
