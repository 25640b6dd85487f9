"""The substeps of an observer as a table over the duty, so that a step looks up what else it had to make.

Straight lines between two rows are no approximation of the car: each row follows a car of any duty
exactly, whatever its gain, and so does every mean of two rows. Only the gain differs from that of
the law between two duties, by no more than `NEARLY`; the certificate is of the means, which run.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from er_models.model import Array

from er_observers.law import Law
from er_observers.observers.kernel import SUBSTEP
from er_observers.observers.substep import fill_substep

NEARLY = 1e-3
"""How far the mean of two rows may be from the law's own substep, in typical sizes."""
_HALVINGS = 8


class Table(NamedTuple):
    """Duties (T,) and the matrix of a substep at each (T, N, N + 2 m + 1), states divided by sizes (N,).

    gap: how far the mean of two rows is from the law's own, in typical sizes, in the middle between.
    """

    duties: Array
    rows: Array
    gap: float

    def at(self, rho: float) -> Array:
        """What runs at a duty (N, N + 2 m + 1)."""
        k = min(max(int(np.searchsorted(self.duties, rho)) - 1, 0), len(self.duties) - 2)
        share = (rho - self.duties[k]) / (self.duties[k + 1] - self.duties[k])
        return np.asarray((1.0 - share) * self.rows[k] + share * self.rows[k + 1])


def table_of(law: Law, b: Array, sizes: Array, output: Array, h: float = SUBSTEP) -> Table:
    """Table of substeps h [s]: between the law's duties as many as `NEARLY` asks for.

    b (N,): effect of an open gate at duty 1 [SI]; sizes (N,), output (m,): typical ones.
    """
    weights = np.concatenate([np.ones(law.order), output, output, [1.0]])
    gap, duties, rows = (
        0.0,
        [law.rho[:1]],
        [substep_matrix(law, b, sizes, float(law.rho[0]), h)[None]],
    )
    for low, high in zip(law.rho[:-1], law.rho[1:], strict=True):
        for halvings in range(_HALVINGS + 1):
            fine = np.linspace(low, high, 2 ** (halvings + 1) + 1)
            found = np.array([substep_matrix(law, b, sizes, float(rho), h) for rho in fine])
            mean = 0.5 * (found[:-1:2] + found[2::2])
            off = float(np.abs(weights * (found[1::2] - mean)).max())
            if off <= NEARLY:
                break
        gap = max(gap, off)
        duties.append(fine[2::2])
        rows.append(found[2::2])
    return Table(np.concatenate(duties), np.concatenate(rows), gap)


def substep_matrix(law: Law, b: Array, sizes: Array, rho: float, h: float) -> Array:
    """Exact matrix (N, N + 2 m + 1) of a substep h [s] at a duty, states divided by sizes (N,)."""
    M, J = law.at(rho)
    n, m = J.shape
    out, room = np.empty((n, n + 2 * m + 1)), np.empty((6, n, n))
    fill_substep(M * sizes / sizes[:, None], J / sizes[:, None], b / sizes, h, room, out)
    return out
