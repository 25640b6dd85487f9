"""A short formula for what a model leaves, from products and powers of the signals, by a greedy search.

The blocks are products of powers of velocity, deflection, acceleration and duty and of their signs, over natural
scales, and the same of a lagged velocity. Each step takes the block that gains most beside those taken and the
model's parameters (orthogonal matching pursuit: Pati et al. 1993), the simplest of those that gain nearly as much;
blocks of time left out say when to stop.
"""

from __future__ import annotations

import itertools
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

import numpy as np
from er_models.model import Array
from er_models.scales import Scales
from numpy.typing import NDArray

from er_model_lab.filtering import fading
from er_model_lab.problem.problem import Problem
from er_model_lab.terms.learn import Learnt
from er_model_lab.terms.regression import normal

MOST_BLOCKS, HIGHEST = 4, 3
"""Blocks of a formula, and the sum of the powers of the motion in one."""
SAMPLES = 6_000
NEARLY = 0.97
"""Share of the best gain from which on a simpler block is taken instead."""
WORTH = 0.05
"""Share of what the term explains that a further block must explain."""
NARROW = 0.02
"""Width of the sign of a signal, over its natural scale."""
LAGS = (0.05, 0.2)
"""Time constants of a lagged velocity, over the time in which the motion turns."""
LAG_HELPS = 0.1
"""Share of what the term explains by which a formula with a lag must beat one without."""


class Power(NamedTuple):
    """|s|^power of a signal, with its sign where `odd`."""

    signal: str
    power: int
    odd: bool

    @property
    def cost(self) -> float:
        """How much there is to read: a modulus or a sign beside the power counts half."""
        return self.power + 0.5 * (self.odd != bool(self.power % 2))

    def values(self, y: Array) -> Array:
        """Along a signal y (n,) over its scale."""
        size = np.abs(y) ** self.power
        if not self.odd:
            return size
        return np.asarray(size * np.sign(y) if self.power else np.tanh(y / NARROW))

    def text(self, symbol: str) -> str:
        """As Python writes it, for a symbol in brackets."""
        if self.odd == bool(self.power % 2):
            return symbol if self.power == 1 else f"{symbol} ** {self.power}"
        if not self.power:
            return f"math.tanh({symbol} / {NARROW:g})"
        size = f"abs{symbol}" + (f" ** {self.power}" if self.power > 1 and not self.odd else "")
        return f"{symbol} * {size}" if self.odd else size

    @property
    def words(self) -> str:
        """As one writes it."""
        if not self.power:
            return f"sgn({self.signal})"
        if self.odd != bool(self.power % 2) and self.odd:
            return f"{self.signal} |{self.signal}|"
        size = self.signal if self.odd == bool(self.power % 2) else f"|{self.signal}|"
        return size if self.power == 1 else f"{size}^{self.power}"


Block = tuple[Power, ...]
UNITS = {"v": "m/s", "w": "m/s", "x": "m", "a": "m/s2", "u": "duty"}


@dataclass(frozen=True)
class Formula:
    """Sum of coefficients [N] times blocks; deviations [N]; share of the mean square left that it explains.

    units: scale [SI] of each signal; lag [s]: of the signal w, which follows the velocity.
    """

    blocks: tuple[Block, ...]
    coefficients: tuple[float, ...]
    share: float
    units: Mapping[str, float]
    lag: float = 0.0

    @property
    def text(self) -> str:
        """In plain words of arithmetic."""
        both = zip(self.coefficients, self.blocks, strict=True)
        parts = [f"{c:.3g} N {' '.join(p.words for p in b)}" for c, b in both]
        scales = ", ".join(f"{s} over {self.units[s]:g} {UNITS[s]}" for s in self.signals)
        lag = f", w the velocity lagged by {self.lag:.3g} s" if self.lag else ""
        return f"{' + '.join(parts)} ({scales}{lag})".replace("+ -", "- ")

    @property
    def signals(self) -> tuple[str, ...]:
        """Signals that it reads."""
        return tuple(dict.fromkeys(p.signal for b in self.blocks for p in b))


def _powers(signal: str, most: int = HIGHEST) -> list[Power]:
    """Powers of a signal that may be factors."""
    return [Power(signal, n, odd) for n in range(most + 1) for odd in (False, True) if n or odd]


def blocks(lagged: bool) -> list[Block]:
    """All blocks, without the empty one."""
    motion = [*_powers("v"), *_powers("x"), *_powers("a", 1), *(_powers("w", 2) if lagged else [])]
    pairs = (p for p in itertools.combinations(motion, 2) if p[0].signal != p[1].signal)
    of_motion: list[Block] = [(), *((m,) for m in motion), *pairs]
    of_motion = [b for b in of_motion if sum(p.power for p in b) <= HIGHEST]
    of_duty: list[Block] = [(), (Power("u", 1, True),), (Power("u", 2, False),)]
    return [(*b, *d) for b in of_motion for d in of_duty if b or d]


def formula(found: Learnt, problem: Problem) -> Formula | None:
    """The shortest formula that explains most of what the term does; None where none helps."""
    rows = np.flatnonzero(problem.train)
    rows = rows[:: max(1, rows.size // SAMPLES)]
    m = problem.motion
    turn = float(np.std(m.x) / max(float(np.std(m.v)), 1e-300))
    plain = _best(found, problem, rows, 0.0)
    lagged = [_best(found, problem, rows, share * turn) for share in LAGS]
    clear = [
        f
        for f in lagged
        if f and (plain is None or f.share > plain.share + LAG_HELPS * _of_term(found))
    ]
    return max(clear, key=lambda f: f.share, default=plain)


def _of_term(found: Learnt) -> float:
    """Share of the mean square left that the term itself explains."""
    return 1.0 - found.candidate.mse / max(found.before.mse, 1e-300)


def _signals(problem: Problem, lag: float) -> dict[str, Array]:
    """Signals (n,) over their scales; w follows the velocity in each record."""
    m = problem.motion
    out = {"v": m.v, "x": m.x, "a": m.a, "u": m.u}
    if lag:
        c, w = np.exp(-m.dt / lag), np.empty(m.n)
        for i, j in itertools.pairwise(m.starts.tolist()):
            w[i:j] = m.v[i] + fading((1.0 - c) * (m.v[i:j] - m.v[i]), c)
        out["w"] = w
    units = units_of(problem.scales)
    return {name: y / units[name] for name, y in out.items()}


def units_of(scales: Scales) -> dict[str, float]:
    """Natural scale [SI] of each signal, to two digits, as a formula writes it."""
    sizes = {
        "v": scales.velocity, "w": scales.velocity, "x": scales.deflection, "a": scales.acceleration, "u": scales.duty,
    }  # fmt: skip
    return {name: float(f"{size:.2g}") for name, size in sizes.items()}


def _best(found: Learnt, problem: Problem, rows: NDArray[np.intp], lag: float) -> Formula | None:
    """The formula of a greedy search, with a velocity lagged by a time [s] where that is not zero."""
    signals = {k: y[rows] for k, y in _signals(problem, lag).items()}
    known = [b for b in blocks(bool(lag)) if all(np.ptp(signals[p.signal]) > 1e-6 for p in b)]
    f = np.stack([_along(b, signals) for b in known], axis=1)
    fitted = found.before.fit
    j, r = fitted.jacobian[rows][:, ~fitted.at_bound], fitted.residual[rows]
    block = np.unique(problem.fold[rows], return_inverse=True)[1]
    costs = np.array([sum(p.cost for p in b) for b in known])
    base, fall = _left(j, r, block), found.before.mse - found.candidate.mse
    taken, left = list[int](), base
    while len(taken) < MOST_BLOCKS:
        k = _next(j, f, r, taken, costs)
        now = _left(np.hstack([j, f[:, [*taken, k]]]), r, block)
        if not left - now > WORTH * fall:
            break
        taken, left = _exchanged([*taken, k], now, j, f, r, block, costs)
    if not taken:
        return None
    c = np.linalg.lstsq(np.hstack([j, f[:, taken]]), r, rcond=1e-12)[0][-len(taken) :]
    units = units_of(problem.scales)
    lag = lag if any(p.signal == "w" for k in taken for p in known[k]) else 0.0
    return Formula(
        tuple(known[k] for k in taken), tuple(map(float, c)), 1.0 - left / base, units, lag
    )


def _along(block: Block, signals: Mapping[str, Array]) -> Array:
    """A block along signals (n,)."""
    out = np.ones(next(iter(signals.values())).size)
    for p in block:
        out = out * p.values(signals[p.signal])
    return out


def _left(columns: Array, r: Array, block: NDArray[np.int64]) -> float:
    """Mean square that columns (n, k) leave of r (n,), each block by what the others tell."""
    scaled = columns / np.maximum(np.linalg.norm(columns, axis=0), 1e-300)
    made = normal(scaled, np.empty((r.size, 0)), r, block)
    return made.mean(made.judged(1e-9 * np.eye(columns.shape[1])))


def _next(j: Array, f: Array, r: Array, taken: Sequence[int], costs: Array) -> int:
    """The block that gains most beside those taken, or the simplest of those that gain nearly as much."""
    q = np.linalg.qr(np.hstack([j, f[:, list(taken)]]))[0]
    left, beyond = r - q @ (q.T @ r), f - q @ (q.T @ f)
    power, whole = np.sum(beyond**2, axis=0), np.sum(f**2, axis=0)
    gains = np.where(power > 1e-6 * whole, (beyond.T @ left) ** 2 / np.maximum(power, 1e-300), 0.0)
    near = np.flatnonzero(gains >= NEARLY * gains.max())
    return int(min(near, key=lambda k: (costs[k], -gains[k])))


def _exchanged(
    taken: list[int], left: float, j: Array, f: Array, r: Array, block: NDArray[np.int64], costs: Array
) -> tuple[list[int], float]:  # fmt: skip
    """Blocks taken, each exchanged once for a better one beside the others; what is left of blocks of time."""
    for place in range(len(taken) - 1):
        others = [k for i, k in enumerate(taken) if i != place]
        k = _next(j, f, r, others, costs)
        now = _left(np.hstack([j, f[:, [*others, k]]]), r, block)
        if now < left:
            taken, left = [*others, k], now
    return taken, left
