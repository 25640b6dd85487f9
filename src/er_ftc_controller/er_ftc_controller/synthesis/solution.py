"""What a synthesis finds, as plain data: reading and running a controller needs no solver."""

from __future__ import annotations

from dataclasses import dataclass

from er_models.model import Array


@dataclass(frozen=True, eq=False)
class Vertex:
    """The controller at one rho, scaled as its plant: A (n, n), B (n, 1), C (1, n); its gamma."""

    rho: float
    A: Array
    B: Array
    C: Array
    gamma: float


@dataclass(frozen=True, eq=False)
class Solution:
    """Vertices, the Lyapunov matrix P (2n, 2n) of the closed loop, the least gamma, the solver's word."""

    vertices: tuple[Vertex, ...]
    P: Array
    optimum: float
    status: str
