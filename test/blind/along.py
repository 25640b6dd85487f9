"""The truth's force on a motion as it was measured: what even the true model cannot do better.

Whoever predicts the force from measured motion feels the sensors of the motion: a gate 2 mm/s wide
turns a velocity error of 0.2 mm/s into newtons. So the least error that a model can be asked for is that
of the truth itself, run along the same measured motion. Between samples the motion is the quintic that
meets position, velocity and acceleration at both ends; before and after the record it is the true one.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from scipy.interpolate import BPoly

from test.blind.case import Case
from test.blind.integrate import LEAD_SAMPLES, SAMPLE, SUBSTEPS
from test.blind.jit import Array
from test.blind.measure import noiseless
from test.blind.plant import Motion, trajectory
from test.blind.roads import half_grid
from test.blind.slots import DEFLECTION_ZERO, OAS, OAU, OV, OX


def _true_motion(case: Case, motion: Motion) -> Array:
    """True deflection, velocity and acceleration at every sample, lead and tail included, (n + 1, 3)."""
    fine = trajectory(motion, case.table, case.base)[::SUBSTEPS]
    lower = fine[:, OAU] if motion.rig == "car" else 0.0
    return np.stack([fine[:, OX], fine[:, OV], fine[:, OAS] - lower], axis=1)


def imposed(case: Case, record: int, measured: Array) -> Motion:
    """The inputs of a rig that imposes a motion as it was measured; arguments as of `force_along`."""
    motion = case.motions[record]
    knots = _true_motion(case, motion)
    rows = slice(LEAD_SAMPLES, LEAD_SAMPLES + measured.shape[0])
    knots[rows] = measured
    knots[rows, 0] -= case.table[DEFLECTION_ZERO, 0]
    n = motion.duty.size
    at = (np.arange(n + 1) - LEAD_SAMPLES) * SAMPLE
    curve = BPoly.from_derivatives(at, knots)
    grid = np.minimum(half_grid(n), at[-1])
    drive = np.stack([curve(grid, nu=order) for order in range(3)], axis=1)
    return replace(motion, rig="damper", drive=drive)


def force_along(case: Case, record: int, measured: Array) -> Array:
    """Noiseless force channel [N] of the truth on a measured motion, (n,).

    Args:
        case: the truth and its inputs.
        record: which record, from zero.
        measured: deflection [m], velocity [m/s] and acceleration [m/s2] as measured or fused, (n, 3); the
            deflection with the zero error of its sensor, which the truth knows and takes off.
    """
    motion = imposed(case, record, measured)
    fine = trajectory(motion, case.table, case.base)
    return noiseless(fine, motion, case.table, case.seconds)["damper_force"]
