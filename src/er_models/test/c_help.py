"""C code of models, compiled by the machine's compiler and called through ctypes."""

from __future__ import annotations

import ctypes
import shutil
import subprocess
from pathlib import Path

import numpy as np
import pytest
from er_models.export.c_code import CCode, write_c
from er_models.model import Array, Model
from er_models.prediction import Motion

COMPILER = shutil.which("cc") or shutil.which("gcc") or shutil.which("clang")
needs_compiler = pytest.mark.skipif(COMPILER is None, reason="no C compiler (cc, gcc, clang) here")
STRICT = ("-std=c99", "-Wall", "-Werror", "-Wno-unused-but-set-variable")


def library(models: list[Model], folder: Path, level: str = "-O0") -> ctypes.CDLL:
    """The dampers of models with different names in one library."""
    sources = [str(write_c(model, folder)[1]) for model in models]
    out = folder / "dampers.so"
    done = subprocess.run(
        [str(COMPILER), *STRICT, level, "-shared", "-fPIC", *sources, "-o", str(out), "-lm"],
        capture_output=True, text=True, check=False,
    )  # fmt: skip
    assert done.returncode == 0, done.stderr
    return ctypes.CDLL(str(out))


def run(made: ctypes.CDLL, model: Model, inputs: Motion, dt: Array | None = None) -> Array:
    """Force (n,) [N] along a motion, one step a sample of its time; dt (n - 1,): of other times."""
    code, number = CCode(model), ctypes.c_double
    values = (number * max(len(code.slots), 1))()
    getattr(made, f"{code.name}_defaults")(values)
    state = ctypes.create_string_buffer(1 << 17)
    calls = [getattr(made, f"{code.name}_{what}") for what in ("init", "step")]
    for call in calls:
        call.restype = number
    rows = np.column_stack([inputs.x, inputs.v, inputs.a, inputs.u, inputs.theta]).tolist()
    force = [calls[0](state, values, *map(number, rows[0]))]
    steps = np.full(inputs.n - 1, inputs.dt) if dt is None else dt
    for h, row in zip(steps.tolist(), rows[1:], strict=True):
        force.append(calls[1](state, values, number(h), *map(number, row)))
    return np.array(force)
