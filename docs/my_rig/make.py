"""Makes the measurements of docs/my_rig.md: a damper of 1.5 kN with a rubber stop that its model does not know.

    ./er exec python docs/my_rig/make.py FOLDER

Three runs in three formats, as rigs write them: CSV with decimal commas and a row of units, TDMS, MATLAB.
The damper has equations of its own; nothing of the lab is used.
"""

from __future__ import annotations

import sys
from pathlib import Path

import numpy as np
from nptdms import ChannelObject, TdmsWriter
from numpy.typing import NDArray
from scipy.io import savemat

Array = NDArray[np.float64]
RATE, SECONDS, FINE = 200.0, 10.0, 25
STROKE, TOP_CURRENT = 0.032, 1.6
"""Largest deflection [m] and current [A]."""
VISCOUS, FRICTION, YIELD, RESPONSE, WIDTH = 900.0, 90.0, 650.0, 0.022, 0.012
"""Damping [N s/m], friction [N], yield force at full current [N], its response time [s], pre-yield velocity [m/s]."""
STOP, RUBBER = 0.024, 5.0e4
"""Where the rubber begins [m], and its stiffness [N/m]."""
NOISE = {"Kolbenweg": 0.006, "Kraft": 0.0025, "Strom": 0.0}
"""Standard deviations in the units of the files."""
UNITS = {"Zeit": "s", "Kolbenweg": "mm", "Kraft": "kN", "Strom": "A"}


def force(x: Array, v: Array, duty: Array) -> Array:
    """Force (n,) [N] that resists extension; x, v, duty at `FINE` points a sample."""
    gate, keep = np.tanh(v / WIDTH), np.exp(-1.0 / (RATE * FINE * RESPONSE))
    field, level = np.empty(x.size), duty[0] * gate[0]
    for k, goal in enumerate(duty * gate):
        field[k] = level
        level = goal + keep * (level - goal)
    rubber = RUBBER * np.sign(x) * np.maximum(np.abs(x) - STOP, 0.0)
    return VISCOUS * v + FRICTION * gate + YIELD * field + rubber


def run(seed: int) -> dict[str, Array]:
    """One run in the units of the files: five tones, steps of the current, the force of a load cell in compression."""
    rng, n = np.random.default_rng(seed), round(RATE * SECONDS)
    t = np.arange(n * FINE) / (RATE * FINE)
    w = 2.0 * np.pi * np.array([0.8, 1.4, 2.3, 3.7, 5.9])
    angle = np.multiply.outer(t, w) + rng.uniform(0.0, 2.0 * np.pi, w.size)
    x, v = np.sin(angle) @ (1.0 / w), np.cos(angle).sum(axis=1)
    scale = STROKE / np.max(np.abs(x))
    duty = np.repeat(rng.permutation(np.tile([0.0, 0.25, 0.5, 1.0], 4)), n // 16)
    F = force(scale * x, scale * v, np.repeat(duty, FINE))[::FINE]
    clean = {"Kolbenweg": 1e3 * scale * x[::FINE], "Kraft": -1e-3 * F, "Strom": TOP_CURRENT * duty}
    noisy = {k: y + NOISE[k] * rng.standard_normal(n) for k, y in clean.items()}
    return {"Zeit": np.arange(n) / RATE, **noisy}


def main(folder: Path) -> None:
    """Write the three runs."""
    folder.mkdir(parents=True, exist_ok=True)
    text, tdms, mat = (run(seed) for seed in (1, 2, 3))
    rows = [";".join(f"{y:.6g}" for y in row) for row in np.stack(list(text.values()), axis=1)]
    head = [";".join(UNITS), ";".join(UNITS.values())]
    body = "\n".join(row.replace(".", ",") for row in rows)
    (folder / "fahrt_1.csv").write_text("\n".join([*head, body, ""]), encoding="utf-8")
    with TdmsWriter(str(folder / "fahrt_2.tdms")) as writer:
        channels = [
            ChannelObject("Messung", k, y, {"unit_string": UNITS[k]}) for k, y in tdms.items()
        ]
        writer.write_segment(channels)
    savemat(folder / "fahrt_3.mat", mat, do_compression=True)


if __name__ == "__main__":
    main(Path(sys.argv[1]))
