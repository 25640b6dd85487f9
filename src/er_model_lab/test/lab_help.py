"""Measurements of an imposed motion under a known model, for tests of fits."""

from dataclasses import replace
from pathlib import Path

import numpy as np
from er_model_lab.diagnosis.verdict import Evidence
from er_model_lab.fitting.velocity_channel import on_fused
from er_model_lab.level.study import Opened
from er_model_lab.problem.prepare import prepare
from er_model_lab.span.span import All
from er_models.files import load_model
from er_models.prediction import motion, predict
from er_records.dataset import Dataset
from er_records.record import Record

GUO = Path(__file__).resolve().parents[3] / "config" / "dampers" / "inove_guo.yaml"
DT, FORCE_NOISE = 0.005, 0.15
NOTHING = Evidence(
    effects=0, explained=0.0, without_lines=0.0, too_many=False, tied=False, blocking=(), remains=False,
    within_errors=False,
)  # fmt: skip
"""Evidence of a model that lacks nothing."""
NAMED = replace(NOTHING, effects=1, explained=0.9, without_lines=0.9)
"""Evidence of one effect that explains nearly all."""
EVIDENCE = {
    "adequate": NOTHING, "missing_effect": NAMED, "ambiguous": replace(NAMED, tied=True),
    "partial": replace(NAMED, explained=0.5, without_lines=0.5),
    "unknown_effect": replace(NOTHING, remains=True),
    "insufficient_data": replace(NOTHING, blocking=("too short",)),
}  # fmt: skip
"""Evidence for each verdict."""


def imposed(rng, n):
    """Deflection, velocity and acceleration of six sines, and steps of duty."""
    w = 2 * np.pi * np.array([0.7, 1.3, 2.1, 3.4, 5.2, 7.3])
    size = 0.09 / w / 2.5
    phase = np.multiply.outer(np.arange(n) * DT, w) + rng.uniform(0, 2 * np.pi, w.size)
    x, v, a = np.sin(phase) @ size, np.cos(phase) @ (size * w), -np.sin(phase) @ (size * w**2)
    return x, v, a, np.repeat(rng.choice([0.0, 0.1, 0.2, 0.3], n // 150 + 1), 150)[:n]


def problem_of(
    effect, values, seconds=24.0, seed=1, accelerometers=True, blur=1.0, early=False, bent=None
):
    """The model without an effect (None: nothing is hidden), and measurements with it along an imposed motion.

    early: where the duty jumps at the instant of a sample, the force was read before.
    bent: makes another force (n,) of the force and the deflection, where no effect of the catalogue is the truth.
    """
    model, rng = load_model(GUO), np.random.default_rng(seed)
    n = round(seconds / DT)
    x, v, a, u = imposed(rng, n)
    truth = model.with_effect(effect, values) if effect else model
    force = predict(truth, motion(DT, x, v, u, a))
    if early:
        later = np.concatenate([u[:1], u[:-1]])
        force = np.where(u != later, predict(truth, motion(DT, x, v, later, a)), force)
    if bent is not None:
        force = bent(force, x)
    channels = {
        "deflection": x + blur * 2e-5 * rng.standard_normal(n),
        "deflection_velocity": v + blur * 1e-3 * rng.standard_normal(n),
        "duty": u,
        "damper_force": force + FORCE_NOISE * rng.standard_normal(n),
    }
    if accelerometers:
        channels["sprung_acceleration"] = a + 0.025 * rng.standard_normal(n)
        channels["unsprung_acceleration"] = 0.025 * rng.standard_normal(n)
    return model, prepare(Dataset.of([Record("made", np.arange(n) * DT, channels)]))


def asked(model, problem, lag=None):
    """A problem that was made by hand, as a question to a model."""
    bare = on_fused(model)
    given = problem.force - problem.predict(bare)
    return Opened(Dataset.of([]), model, bare, problem, All(), given, lag)
