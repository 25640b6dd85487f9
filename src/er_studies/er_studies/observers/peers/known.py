"""The peers by name, with what is tuned of them, and the tuned values of a file."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial
from pathlib import Path
from typing import Any, NamedTuple

from er_models.errors import InputError
from er_models.linear import relative_form
from er_models.model import Model
from er_models.yaml_file import read_yaml

from er_studies.observers import kalman
from er_studies.observers.estimators import Estimator
from er_studies.observers.peers import balance, coloured, horizon, momentum

WHITE = {"share": (0.01, 100.0), "noise": (0.01, 0.2)}
"""What is tuned of the filters of four states: share of the road's density, noise of the accelerometers [m/s2]."""


class Peer(NamedTuple):
    """Title, `make(model, **tuned)`, module with start and step, bounds of what is tuned."""

    title: str
    make: Callable[..., Any]
    module: Any
    tuned: Mapping[str, tuple[float, float]]


def _white(name: str, model: Model, share: float, noise: float) -> Any:
    """A filter of `kalman` with another road and another sensor."""
    kind = kalman.KINDS[name]._replace(share=share)
    return kalman.make(name, model, kalman.Statement(noise=noise), kind)


PEERS = {
    "balance": Peer("direct balance", balance.make, balance, balance.TUNED),
    "momentum": Peer("momentum observer", momentum.make, momentum, momentum.TUNED),
    "ekf": Peer("EKF, white road", partial(_white, "ekf"), kalman, WHITE),
    "ukf": Peer("UKF, white road", partial(_white, "ukf"), kalman, WHITE),
    "ekf_5": Peer("EKF, 5 states", partial(coloured.make, "ekf"), coloured, coloured.TUNED),
    "ukf_5": Peer("UKF, 5 states", partial(coloured.make, "ukf"), coloured, coloured.TUNED),
    "horizon": Peer("moving horizon", horizon.make, horizon, horizon.TUNED),
}


def peer(name: str, model: Model, values: Mapping[str, float]) -> Estimator:
    """A peer with these tuned values."""
    kind, form = PEERS[name], relative_form(model)
    made = kind.make(model, **values)
    return Estimator(name, kind.title, False, made, kind.module.start, kind.module.step, form)


def tuned_peers(model: Model, path: Path) -> tuple[Estimator, ...]:
    """All peers with the values of a file of `tune`; `InputError` where it lacks one."""
    found = read_yaml(path, "a file of tuned peers")
    made = []
    for name, kind in PEERS.items():
        values = (found.get("peers") or {}).get(name) if isinstance(found, Mapping) else None
        if not isinstance(values, Mapping) or set(values) != set(kind.tuned):
            raise InputError(path, f"peers.{name}", ", ".join(kind.tuned) or "{}", repr(values))
        made.append(peer(name, model, values))
    return tuple(made)
