r"""The law that every observer here follows, whatever theorem its gains come from.

.. math::  z' = M(\rho) z + J(\rho) y + T B \rho\, \Phi(\Gamma \hat x), \quad \hat x = R z + S y

M and J go straight from one of the duties `rho` to the next. With the identities
``M T + J C = T A`` and ``R T + S C = I`` the error T x - z obeys M alone:

.. math::  \zeta' = M \zeta + T B \rho\, d + T D_1 w - J n, \quad x - \hat x = R \zeta - S n

The Luenberger observer (4.5) has T = I, J = L, M = A - L C, R = I - S C, with S = 0 as printed; the
unified observer (3.4) has z = [z, v], M = [N M; P G], J = [J; Q], T = [T; 0], R = [R 0].

Source: thesis (3.4), (3.8)-(3.14), (4.5).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from er_models.linear import LinearForm
from er_models.model import Array

RESIDUAL = 1e-9
"""Largest departure from the identities that free the error of the state."""


@dataclass(frozen=True, eq=False)
class Law:
    """Matrices [SI]: rho (K,), M (K, N, N), J (K, N, m), T (N, n), R (n, N), S (n, m)."""

    rho: Array
    M: Array
    J: Array
    T: Array
    R: Array
    S: Array

    @property
    def order(self) -> int:
        """States N of the observer."""
        return int(self.T.shape[0])

    @property
    def is_luenberger(self) -> bool:
        """Whether T = I: then gains J and reading S say it all, M = A - J C and R = I - S C."""
        return np.array_equal(self.T, np.eye(*self.T.shape))

    def at(self, rho: float) -> tuple[Array, Array]:
        """M (N, N) and J (N, m) at a duty, the ends held beyond them."""
        k = min(max(int(np.searchsorted(self.rho, rho)) - 1, 0), len(self.rho) - 2)
        share = (rho - self.rho[k]) / (self.rho[k + 1] - self.rho[k])
        share = min(max(float(share), 0.0), 1.0)
        return tuple((1.0 - share) * v[k] + share * v[k + 1] for v in (self.M, self.J))  # type: ignore[return-value]

    def sizes(self, state: Array) -> Array:
        """Typical sizes (N,) of the observer's states, from those (n,) of the model's."""
        found = np.sqrt((self.T**2) @ (state**2))
        return np.where(found > 0.0, found, 1.0)

    def state(self, x: Array, y: Array, near: Array) -> Array:
        """The observer's state (N,) with the estimate x (n,) at outputs y (m,), nearest to `near`; x where T = I."""
        if self.is_luenberger:
            return np.array(x)
        return np.asarray(near + np.linalg.pinv(self.R) @ (x - self.R @ near - self.S @ y))

    def residual(self, form: LinearForm, state: Array) -> float:
        """Largest departure from the two identities, as a share of the terms in its row.

        state (n,): typical sizes of the model's states.
        """
        gaps, terms = [], []
        for M, J in zip(self.M, self.J, strict=True):
            gaps.append(self.T @ form.A - M @ self.T - J @ form.C)
            terms.append(np.abs(M) @ np.abs(self.T) + np.abs(J) @ np.abs(form.C))
        gaps.append(np.eye(form.n) - self.R @ self.T - self.S @ form.C)
        terms.append(np.abs(self.R) @ np.abs(self.T) + np.abs(self.S) @ np.abs(form.C))
        shares = [
            np.abs(g * state) / _row_sizes(t * state) for g, t in zip(gaps, terms, strict=True)
        ]
        return float(max(share.max() for share in shares))


def luenberger(form: LinearForm, rho: Array, L: Array, S: Array | None = None) -> Law:
    """The observer (4.5) with gains L (K, n, m) at the duties rho (K,); S (n, m): of the reading, None for 0."""
    n, m = form.n, form.C.shape[0]
    M = np.array([form.A - gain @ form.C for gain in L])
    S = np.zeros((n, m)) if S is None else S
    return Law(np.array(rho, float), M, np.array(L), np.eye(n), np.eye(n) - S @ form.C, S)


def _row_sizes(rows: Array) -> Array:
    """Largest entry of each row (k, 1), one for rows of zeros."""
    sizes = rows.max(axis=1, keepdims=True)
    return np.where(sizes > 0.0, sizes, 1.0)
