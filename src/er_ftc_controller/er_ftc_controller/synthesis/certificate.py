"""What is known of a controller without trusting the solver: everything is found again from the rounded matrices."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from typing import Any

import numpy as np
from er_models.constants import SAMPLE_TIME
from er_models.exact import exact, is_positive_definite
from er_models.forms.response import frequency_response
from er_models.model import Array
from scipy.linalg import expm

from er_ftc_controller.synthesis.solution import NoController, Solution, Vertex
from er_ftc_controller.synthesis.weights import Plant

HERTZ = np.geomspace(1e-3, 2e3, 4000)
"""Frequencies of the sweep: from a climb to far beyond every pole."""


@dataclass(frozen=True, eq=False)
class Certificate:
    """Proved and measured of a controller, by vertex.

    margins: smallest eigenvalue of the bounded real inequality (6.24), scaled, and proved in fractions to be above
    half of that. peaks: largest singular value over frequency. slowest, fastest: poles of the closed loop [1/s].
    radii: spectral radius of the sampled loop, for every rho and its jumps proved by one quadratic function;
    mixed: largest over 11 rho.
    """

    margins: tuple[float, ...]
    peaks: tuple[float, ...]
    slowest: tuple[float, ...]
    fastest: tuple[float, ...]
    radii: tuple[float, ...]
    mixed: float


def closed_loop(plant: Plant, k: Vertex) -> tuple[Array, Array, Array]:
    """A (2n, 2n), B (2n, 2), C (3, 2n) of plant and controller, scaled."""
    A = np.block([[plant.A, plant.B2 @ k.C], [k.B @ plant.C2, k.A]])
    B = np.vstack([plant.B1, k.B @ plant.D21])
    C1, D12 = plant.outputs(k.rho)
    return A, B, np.hstack([C1, D12 @ k.C])


def peak_gain(A: Array, B: Array, C: Array, rate: float) -> float:
    """Largest singular value of C (j omega - A)^-1 B over `HERTZ`; rate: 1 / unit of time of A [1/s]."""
    response = frequency_response(A * rate, B * rate, C, HERTZ)
    return float(np.linalg.norm(response, 2, axis=(1, 2)).max())


def bounded_real(
    plant: Plant, k: Vertex, P: Array, convert: Callable[[Any], Any] = np.asarray
) -> Any:
    """Minus the matrix of (6.24) with gamma spread over both corners: positive definite where gamma is proved."""
    A, B, C = (convert(part) for part in closed_loop(plant, k))
    P, gamma = convert(P), convert(k.gamma)
    zero = convert(np.zeros((C.shape[0], B.shape[1])))
    unit_w, unit_z = convert(np.eye(B.shape[1])), convert(np.eye(C.shape[0]))
    S, entry = P @ A, P @ B
    return -np.block(
        [[S + S.T, entry, C.T], [entry.T, -unit_w * gamma, zero.T], [C, zero, -unit_z * gamma]]
    )


def certify(plant: Plant, solution: Solution) -> Certificate:
    """Certificate of a solution.

    Raises `NoController` naming the first statement that does not hold.
    """

    def demand(reason: str, *, holds: bool) -> None:
        if not holds:
            raise NoController(f"LPV controller: {reason} (solver: {solution.status})")

    margins, failed = proved(plant, solution)
    demand(failed, holds=not failed)
    peaks, slowest, fastest, sampled = [], [], [], []
    for k in solution.vertices:
        name = f"rho = {k.rho:g}"
        A, B, C = closed_loop(plant, k)
        peak = peak_gain(A, B, C, plant.rate)
        reason = f"the sweep finds {peak:.4g} above gamma {k.gamma:.4g} at {name}"
        demand(reason, holds=peak <= k.gamma)
        poles = np.linalg.eigvals(A) * plant.rate
        peaks.append(peak)
        slowest.append(float(poles.real.max()))
        fastest.append(float(np.abs(poles).max()))
        sampled.append(sampled_loop(plant, k))
    radii = [growth(A) for A in sampled]
    shares = np.linspace(0.0, 1.0, 11)
    mixed = max(growth((1.0 - a) * sampled[0] + a * sampled[-1]) for a in shares)
    return Certificate(margins, tuple(peaks), tuple(slowest), tuple(fastest), tuple(radii), mixed)


def proved(plant: Plant, solution: Solution) -> tuple[tuple[float, ...], str]:
    """Margins of (6.24) at the vertices, and the first statement that does not hold exactly ('' for none).

    P and P_sampled are shared and both loops straight lines between the vertices, so what holds there holds between.
    """
    if not is_positive_definite(exact(solution.P)):
        return (), "P is not positive definite"
    margins, failed = [], ""
    for k in solution.vertices:
        matrix = bounded_real(plant, k, solution.P)
        margin = float(np.linalg.eigvalsh(0.5 * (matrix + matrix.T))[0])
        holds = margin > 0.0
        if holds:
            whole = bounded_real(plant, k, solution.P, exact)
            holds = is_positive_definite(whole - exact(np.eye(len(whole))) * exact(0.5 * margin))
        margins.append(margin)
        if not holds and not failed:
            failed = f"(6.24) has the margin {margin:.3g} at rho = {k.rho:g}"
        if not failed and not _falls(sampled_loop(plant, k), solution.P_sampled):
            failed = f"P_sampled does not fall along the loop sampled at rho = {k.rho:g}"
    return tuple(margins), failed


def bears(plant: Plant, solution: Solution, sample: float) -> bool:
    """Whether a quadratic function is proved to fall along the loop of samples so long [s], however rho jumps.

    P_sampled is tried first, which a loaded file has for the usual sample time; the solver may find another.
    """
    if sample == SAMPLE_TIME:
        return True
    loops = [sampled_loop(plant, k, sample) for k in solution.vertices]
    if all(_falls(A, solution.P_sampled) for A in loops):
        return True
    if not growth_between(loops) < 1.0:
        return False
    from er_ftc_controller.synthesis.jumps import common

    P = common(loops)
    return P is not None and all(_falls(A, P) for A in loops)


def sampled_controller(k: Vertex, step: float) -> tuple[Array, Array, Array]:
    """Exact A, B, C of a controller whose input is held over a step in its unit of time."""
    n = k.A.shape[0]
    whole = expm(step * np.block([[k.A, k.B], [np.zeros((1, n + 1))]]))
    return whole[:n, :n], whole[:n, n:], k.C


def sampled_force(plant: Plant, k: Vertex, step: float) -> Array:
    """What a force held over a step, beyond the one asked for, does to the controller's state (n, 1).

    V = x'P x is (x - x_c)'Y(x - x_c) + x_c' M^-1 x_c by the reconstruction: x_c stands for the plant's own state,
    and such a force enters it as it enters the plant.
    """
    n = k.A.shape[0]
    whole = expm(step * np.block([[k.A, plant.B2], [np.zeros((1, n + 1))]]))
    return np.asarray(whole[:n, n:])


def sampled_loop(plant: Plant, k: Vertex, sample: float = SAMPLE_TIME) -> Array:
    """One sample [s] of car and controller (4 + n, 4 + n), force and deflection held; straight in the controller."""
    step = sample * plant.rate
    A, B = plant.A[:4, :4], plant.B2[:4]
    car = expm(step * np.block([[A, B], [np.zeros((1, 5))]]))
    Ac, Bc, Cc = sampled_controller(k, step)
    return np.block([[car[:4, :4], car[:4, 4:] @ Cc], [Bc @ plant.C2[:, :4], Ac]])


def growth(A: Array) -> float:
    """Growth per sample: the spectral radius."""
    return float(np.abs(np.linalg.eigvals(A)).max())


def growth_between(loops: list[Array]) -> float:
    """Largest growth per sample of the first loop, the last, and nine mixtures of them."""
    shares = np.linspace(0.0, 1.0, 11)
    return max(growth((1.0 - a) * loops[0] + a * loops[-1]) for a in shares)


def _falls(A: Array, P: Array) -> bool:
    """Whether P - A' P A is positive definite, exactly."""
    if float(np.linalg.eigvalsh(P - A.T @ P @ A)[0]) <= 0.0:
        return False
    whole, step = exact(P), exact(A)
    return is_positive_definite(whole) and is_positive_definite(whole - step.T @ whole @ step)
