"""What a synthesis finds, as plain data: reading and running a controller needs no solver."""

from __future__ import annotations

from dataclasses import dataclass

from er_models.errors import ErError
from er_models.model import Array


class NoController(ErError):
    """No controller was found, or what was found is none."""


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
    """Vertices, the Lyapunov matrix P (2n, 2n) of the closed loop, the least gamma, the solver's word.

    P_sampled (4 + n, 4 + n): the same of the sampled loop, one for all rho, which may jump between samples.
    """

    vertices: tuple[Vertex, ...]
    P: Array
    P_sampled: Array
    optimum: float
    status: str
