"""Controllers that a practitioner would pick instead: one file each, compiled, with knobs that one search tunes."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass

import numpy as np
from er_ftc_controller.synthesis.state_lqr import StateWeights, car_of, state_gain
from er_ftc_controller.synthesis.weights import body_frequency
from er_models.forms.lipschitz import linearise
from er_models.forms.loss import Factors
from er_models.forms.lti import lti_form
from er_models.model import Array, Model
from scipy.linalg import expm, solve_continuous_lyapunov

from er_studies.control.peers.sample import STEP

Knobs = Mapping[str, float]


@dataclass(frozen=True)
class Peer:
    """Number in `rule.duty`; knobs with bounds, searched on a logarithmic scale; its parameters p for a vehicle."""

    number: int
    knobs: Mapping[str, tuple[float, float]]
    prepare: Callable[[Model, Knobs], Array]


def _plainly(_model: Model, knobs: Knobs) -> Array:
    """The knobs as they are."""
    return np.array([*knobs.values()], float)


def _sh_add(model: Model, knobs: Knobs) -> Array:
    """Its crossing at a multiple of the body's frequency."""
    return np.array([knobs["duty"], knobs["crossing"] * body_frequency(lti_form(model))])


def _pdd(model: Model, knobs: Knobs) -> Array:
    """The car's stiffness and passive damping."""
    damper = model.effects["passive"]
    stiffness = model.value("quarter_car", "k_s") + damper["k0"]
    return np.array([knobs["duty"], stiffness, damper["c0"]])


def _lqr(model: Model, knobs: Knobs) -> Array:
    """Its gain."""
    weights = (knobs[n] for n in ("deflection", "velocity", "tyre", "goal"))
    return state_gain(model, StateWeights(1.0, *weights))


def _mpc(model: Model, knobs: Knobs, *, preview: bool) -> Array:
    """Step, costs and what the passive car costs after the horizon."""
    A, B, D = car_of(model, Factors())
    whole = np.zeros((7, 7))
    whole[:5, :5], whole[:5, 5], whole[:5, 6] = A, B, D
    step, form = expm(STEP * whole), linearise(model)
    weights = np.array([1.0, knobs["deflection"], knobs["tyre"]])
    rows = np.vstack([A[1], np.eye(5)[0], np.eye(5)[2]])
    end = solve_continuous_lyapunov(A.T, -rows.T @ np.diag(weights) @ rows)
    return np.concatenate([
        step[:5, :5].ravel(), step[:5, 5], step[:5, 6], form.Gamma[[0, 1]], A[1], weights, end.ravel(), [preview],
    ])  # fmt: skip


DUTY = {"duty": (0.005, 1.0)}
COSTS = {"deflection": (1e4, 3e6), "tyre": (1e5, 3e8)}
"""Squares of m/s2 over m."""
SIZES = {
    "deflection": (0.3, 5.0),
    "velocity": (0.5, 50.0),
    "tyre": (0.5, 15.0),
    "goal": (1.0, 10.0),
}
PEERS: Mapping[str, Peer] = {
    "constant": Peer(0, DUTY, _plainly),
    "skyhook": Peer(1, DUTY, _plainly),
    "linear_skyhook": Peer(2, {"damping": (3.0, 200.0)}, _plainly),
    "sh_add": Peer(3, DUTY | {"crossing": (0.7, 2.5)}, _sh_add),
    "pdd": Peer(4, DUTY, _pdd),
    "clipped_lqr": Peer(5, SIZES, _lqr),
    "mpc": Peer(6, COSTS, lambda m, k: _mpc(m, k, preview=False)),
    "mpc_preview": Peer(6, COSTS, lambda m, k: _mpc(m, k, preview=True)),
}
