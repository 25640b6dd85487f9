"""Fleets of which everything is known: rows of units and recordings as sampling theory says them, made without the lab.

A force is a sum of terms, each scaled to a root mean square of one standard deviation of its noise. What least squares
makes of a recording of N independent samples is then normal about the truth, with covariance R^-1 / N, R the
correlation of the terms; what is left has the variance 1 + e^2 (1 - r' R^-1 r) with a term e that is not in the model.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np
from scipy.stats import norm

TERMS = {"passive.k0": 10.0, "passive.c0": 20.0, "guo_yield.f_c": 30.0, "response.tau": 5.0}
"""Parameters and their common value [standard deviations of the noise of the force]."""
BETWEEN, WITHIN = 0.05, 0.004
"""Spread between units, and from recording to recording, over the value [1]."""
INDEPENDENT = 3000
"""Independent samples of a recording: a minute at 200 Hz, where four neighbours count as one."""
NEW = ("coulomb_friction", "preload", "freeplay")
"""Effects that no model holds; the other two take a part of a parameter away: a leak at once, a
fade of the yield from some mileage on."""
LESS = {"leak": "passive.c0", "fade": "guo_yield.f_c"}
SPAN = 1e8
"""Mileage of a fleet [m]."""


@dataclass(frozen=True)
class Fleet:
    """Rows, and the truth: which unit has which effect, where it begins (0: from the start), and all values."""

    units: list[dict[str, Any]]
    recordings: list[dict[str, Any]]
    effects: Mapping[str, str]
    begins: Mapping[str, float]
    values: Mapping[str, Mapping[str, float]]


def fleet(seed: int, units: int = 60, recordings: int = 20, size: float = 1.0) -> Fleet:
    """A fleet of which 0 to 10 units carry an effect of `size` standard deviations of the noise of the force."""
    rng = np.random.default_rng(seed)
    k = len(TERMS) + 1
    mixing = np.eye(k) + 0.25 * rng.standard_normal((k, k))
    r = mixing @ mixing.T
    r /= np.sqrt(np.outer(np.diag(r), np.diag(r)))
    names = [f"unit{n:03d}" for n in range(units)]
    ill = rng.choice(units, rng.integers(0, 11), replace=False)
    effects = {names[n]: str(rng.choice([*NEW, *LESS])) for n in ill}
    late = {u: e in LESS or rng.random() < 0.5 for u, e in effects.items()}
    begins = {u: float(rng.uniform(0.2, 0.8)) * SPAN if late[u] else 0.0 for u in effects}
    values = {
        u: {t: v * (1 + BETWEEN * rng.standard_normal()) for t, v in TERMS.items()} for u in names
    }
    rows: list[dict[str, Any]] = []
    made = [
        _unit(rng, u, values[u], effects.get(u, ""), begins.get(u, 0.0), r, recordings, size, rows)
        for u in names
    ]
    return Fleet(made, rows, effects, begins, values)


def _unit(
    rng: np.random.Generator, name: str, values: Mapping[str, float], effect: str, begin: float,
    r: np.ndarray, n: int, size: float, rows: list[dict[str, Any]],
) -> dict[str, Any]:  # fmt: skip
    """A unit's row; those of its recordings are added to `rows`."""
    x = (np.arange(n) + rng.uniform(0.0, 1.0, n)) * SPAN / n
    here = size * (x >= begin) * (effect != "")
    if effect == "fade":
        here *= (x - begin) / (SPAN - begin)
    inverse = np.linalg.inv(r[:-1, :-1])
    pull = inverse @ r[:-1, -1]
    root = np.linalg.cholesky(inverse / INDEPENDENT)
    sd = np.sqrt(np.diag(inverse) / INDEPENDENT)
    means, seen = np.zeros(len(TERMS)), np.zeros(n)
    for j in range(n):
        new = here[j] if effect in NEW else 0.0
        truth = np.array([v * (1 + WITHIN * rng.standard_normal()) for v in values.values()])
        truth -= [here[j] if LESS.get(effect) == term else 0.0 for term in TERMS]
        left = 1.0 + new**2 * (1.0 - r[:-1, -1] @ pull)
        found = truth + pull * new + root @ rng.standard_normal(len(TERMS)) * np.sqrt(left)
        rest = (
            left * rng.chisquare(INDEPENDENT) / INDEPENDENT * np.exp(0.01 * rng.standard_normal())
        )
        seen[j] = (
            new + np.sqrt(1.0 / (1.0 - r[:-1, -1] @ pull) / INDEPENDENT) * rng.standard_normal()
        )
        means += (found - pull * new) / n
        triples = {t: [v, s, "N"] for t, v, s in zip(TERMS, found, sd, strict=True)}
        rows.append({
            "unit": name, "status": "used", "mileage": float(x[j]), "time": None, "values": triples,
            "rmse_refitted": float(np.sqrt(rest)), "independent": float(INDEPENDENT),
        })  # fmt: skip
    mean, error = seen.mean(), np.sqrt(1.0 / (1.0 - r[:-1, -1] @ pull) / INDEPENDENT / n)
    others = error * rng.standard_normal(len(NEW))
    sizes = {e: float(mean if e == effect else others[k]) for k, e in enumerate(NEW)}
    p = {e: min(1.0, len(NEW) * 2.0 * float(norm.sf(abs(s) / error))) for e, s in sizes.items()}
    named = sorted((e for e in NEW if p[e] < 0.01), key=p.__getitem__)
    return {
        "unit": name, "verdict": "missing_effect" if named else "adequate", "effects": named,
        "values": {t: [float(v), float(s) / np.sqrt(n), "N"] for t, v, s in zip(TERMS, means, sd, strict=True)},
        "candidates": {e: [abs(s), 3 * error, p[e], "present" if e in named else "absent"] for e, s in sizes.items()},
    }  # fmt: skip
