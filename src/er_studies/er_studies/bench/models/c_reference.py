"""The loops of the kernel in C for one model, compiled when they are asked for: what the kernel could cost at best."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
import tempfile
from functools import lru_cache
from pathlib import Path
from typing import Any

import numpy as np
from er_models.kernel.elementary import HIGH, LOW, TABLE
from er_models.model import Array, Model
from er_models.prediction import Motion, substeps
from er_models.simulation import prepare

SOURCE = Path(__file__).with_name("reference.c")
OPTIONS = ("-O3", "-march=native", "-std=c99", "-fPIC", "-shared")
_DAMPER = (("passive", "k0"), ("passive", "c0"), ("guo_yield", "f_c"), ("guo_yield", "k1"),
           ("guo_yield", "c1"), ("response", "tau"))  # fmt: skip
_CAR = (("quarter_car", "m_s"), ("quarter_car", "m_us"), ("quarter_car", "k_s"), ("quarter_car", "k_t"))  # fmt: skip
_Long, _Double = ctypes.c_int64, ctypes.c_double


def compiler() -> str | None:
    """A C compiler of this machine."""
    return shutil.which("gcc") or shutil.which("cc")


@lru_cache(maxsize=1)
def _library() -> Any:
    """The compiled loops; `RuntimeError` without a C compiler."""
    command = compiler()
    if command is None:
        raise RuntimeError("no C compiler (gcc or cc)")
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "reference.so"
        subprocess.run([command, *OPTIONS, str(SOURCE), "-o", str(path), "-lm"], check=True)
        library = ctypes.CDLL(str(path))
    library.prepare(_at(TABLE), _Double(HIGH), _Double(LOW))
    return library


def _at(values: np.ndarray[Any, Any]) -> ctypes.c_void_p:
    """Address of a contiguous array."""
    return ctypes.c_void_p(values.ctypes.data)


def _values(model: Model, names: tuple[tuple[str, str], ...]) -> Array:
    """Parameters in the order of a struct of the C code."""
    return np.array([model.value(*name) for name in names])


def c_predict(model: Model, inputs: Motion) -> Array:
    """Force (n,) [N] of a dynamic Guo damper along one record, as `predict`."""
    force = np.empty(inputs.n)
    _library().predict(
        _at(_values(model, _DAMPER)), _Long(inputs.n), _Double(inputs.dt), _Long(substeps(inputs.dt)),
        _at(inputs.x), _at(inputs.v), _at(inputs.a), _at(inputs.u), _at(force),
    )  # fmt: skip
    return force


def c_simulate(model: Model, dt: float, road: Array, duty: Array) -> Array:
    """The quarter car from rest with duty held: outputs (n - 1, 5) at the end of each sample, as `simulate`.

    Both accelerations, force, deflection and its velocity.
    """
    plant, n = prepare(model, dt), road.shape[0] - 1
    outputs = np.empty((n, 5))
    _library().simulate(
        _at(_values(model, _DAMPER)), _at(_values(model, _CAR)), _Long(n), _Double(dt), _Long(plant.n_sub),
        _Double(plant.tolerance), _at(road), _at(duty), _at(outputs),
    )  # fmt: skip
    return outputs
