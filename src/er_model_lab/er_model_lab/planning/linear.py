"""How well one explanation imitates another, by one linear step: fast enough to try hundreds of programs.

The force of the truth minus that of a mimic, and its derivatives by every parameter of the
mimic and of the base model, are reduced to a small triangle (QR). What is left of the difference
after least squares is what no refit can imitate. Triangles of several pieces of a program are
stacked, so that programs made of them cost nothing more.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field, replace

import numpy as np
from er_models.model import Array, Model
from er_models.prediction import predict
from er_models.scales import Scales
from numpy.typing import NDArray

from er_model_lab.fitting.fit import fit
from er_model_lab.motion.fuse import Noise
from er_model_lab.planning.limits import Sensors
from er_model_lab.planning.segment import FADE
from er_model_lab.planning.virtual_rig import Run
from er_model_lab.problem.problem import Problem

RANK = 1e-8
"""Directions weaker than this share of the strongest are not told from nothing."""


@dataclass(frozen=True)
class Design(Problem):
    """A noise-free problem on a common envelope, so that derivatives of several runs can be joined."""

    envelope: Scales = field(kw_only=True)

    @property
    def scales(self) -> Scales:
        """The envelope of the model, not of the run."""
        return self.envelope


def design(run: Run, sensors: Sensors, envelope: Scales) -> Design:
    """The run as a fitting problem in which all but the fading in counts."""
    n = run.channels["t"].size
    fold: NDArray[np.int64] = np.zeros(n, np.int64)
    fold[: round(FADE / run.dt)] = -1
    noise = Noise(sensors.deflection, sensors.velocity, sensors.acceleration, 0.0)
    return Design(
        motion=run.motion, force=run.channels["damper_force"], fold=fold,
        held_out=np.zeros(n, bool), raw=(), fused=(), noise=noise, names=("plan",), notes=(),
        complete=True, sd_force=sensors.force, velocity_lag=(0.0, 0.0), envelope=envelope,
    )  # fmt: skip


@dataclass(frozen=True)
class Triangle:
    """R of the QR of [derivatives, difference] in units of the noise, and the samples behind it.

    r (p + 1, p + 1) at most; the last column is the difference.
    """

    r: Array
    samples: int


def triangle(mimic: Model, problem: Problem, noise: float) -> Triangle:
    """A mimic's triangle on a problem whose force is the truth's; noise: floor of the force [N].

    Refinements stay as they are: what they can imitate the refits of the best programs say.
    """
    known = mimic.catalogue
    free = tuple(
        f for f in problem.forward.free(mimic) if not known[f[0]].parameter(f[1]).optional
    )
    found = fit(mimic, problem, free, max_iter=0)
    rows = problem.train
    table = np.column_stack([found.jacobian[rows], found.residual[rows]]) / noise
    if not np.isfinite(table).all():
        return Triangle(np.zeros((1, table.shape[1])), int(rows.sum()))
    return Triangle(np.asarray(np.linalg.qr(table, mode="r")), int(rows.sum()))


def left(parts: Sequence[Triangle]) -> float:
    """Root mean square of what least squares leaves of the difference, over the noise."""
    r = np.vstack([p.r for p in parts])
    size = np.linalg.norm(r[:, :-1], axis=0)
    columns = r[:, :-1][:, size > 0.0] / size[size > 0.0]
    y = r[:, -1]
    if columns.shape[1]:
        y = y - columns @ np.linalg.lstsq(columns, y, rcond=RANK)[0]
    return float(np.linalg.norm(y) / np.sqrt(max(sum(p.samples for p in parts), 1)))


def floor_of(base: Model, run: Run, sensors: Sensors, sd_velocity: float, seed: int) -> float:
    """Noise floor [N] of a run: force sensor, and what an error of the fused velocity does to the force."""
    m = run.motion
    rng = np.random.default_rng(seed)
    wrong = replace(m, v=m.v + sd_velocity * rng.standard_normal(m.n))
    error = predict(base, wrong) - predict(base, m)
    return float(np.hypot(sensors.force, np.sqrt(np.mean(error**2))))
