"""A case: measurements of several records with a hidden truth, and its files.

Beside the measurements, ``record_<n>.csv``, a folder ``sealed`` holds ``truth.json`` and the
noiseless channels ``record_<n>.truth.npz``; whatever is judged by the case must not read it.
"""

from __future__ import annotations

import hashlib
import json
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from test.blind.calibrate import Hidden, table_of
from test.blind.errors import BlindError
from test.blind.integrate import SAMPLE, STEP
from test.blind.jit import Array
from test.blind.measure import COLUMNS, Noise
from test.blind.plant import CAR, Motion, Program, Rig
from test.blind.refit import excess, refit

_FORMATS = ("%.3f", "%.8g", "%.8g", "%.8g", "%.3f", "%.8g", "%.8g", "%.8g")
_BASE = (("k0", "N/m"), ("c0", "N.s/m"), ("fc", "N"), ("k1", "1/m"), ("c1", "s/m"), ("tau", "s"))
_CAR = (("m_s", "kg"), ("m_us", "kg"), ("k_s", "N/m"), ("k_t", "N/m"))


@dataclass(frozen=True)
class Case:
    """Measurements with their truth.

    Attributes:
        directory: where the files are.
        seed: what everything was drawn from.
        rig, program: quarter car or imposed stroke; rich or poor inputs.
        seconds: length of each record [s].
        base: k0, c0, fc, k1, c1, tau in SI units, (6,).
        hidden: the effects, none for a complete model.
        noise: of the instruments.
        motions: inputs of each record.
        clean, noisy: contract columns of each record, without and with noise.
    """

    directory: Path
    seed: int
    rig: Rig
    program: Program
    seconds: float
    base: Array
    hidden: tuple[Hidden, ...]
    noise: Noise
    motions: tuple[Motion, ...]
    clean: tuple[dict[str, Array], ...]
    noisy: tuple[dict[str, Array], ...]

    @property
    def effects(self) -> tuple[str, ...]:
        """Names of the hidden effects."""
        return tuple(one.effect.name for one in self.hidden)

    @property
    def table(self) -> Array:
        """Effect table of the truth."""
        return table_of(self.hidden)

    @property
    def csv(self) -> tuple[Path, ...]:
        """The measurement files."""
        count = range(1, len(self.noisy) + 1)
        return tuple(self.directory / f"record_{index}.csv" for index in count)

    @property
    def sealed(self) -> Path:
        """Folder of the truth."""
        return self.directory / "sealed"


def excess_after_refit(case: Case) -> float:
    """Rise of the residual over the force noise once a healthy base is refitted; 0.1 is 10 %."""
    offset = not any(one.effect.hides_in_bias for one in case.hidden)
    return excess(refit(list(case.clean), offset=offset).rms, case.noise.force)


def _named(values: Array, names: tuple[tuple[str, str], ...]) -> dict[str, dict[str, Any]]:
    pairs = zip(names, values, strict=True)
    return {symbol: {"value": float(value), "unit": unit} for (symbol, unit), value in pairs}


def truth(case: Case) -> dict[str, Any]:
    """Everything that was hidden, as data."""
    return {
        "effects": list(case.effects),
        "seed": case.seed,
        "rig": case.rig,
        "program": case.program,
        "seconds": case.seconds,
        "sample_interval": SAMPLE,
        "integration_step": STEP,
        "base": _named(case.base, _BASE),
        "car": _named(CAR, _CAR),
        "hidden": [
            {
                "effect": one.effect.name,
                "parameters": one.effect.named(one.row),
                "rise_drawn": one.target,
                "rise_alone": one.rise,
            }
            for one in case.hidden
        ],
        "rise_together": excess_after_refit(case),
        "noise": vars(case.noise),
        "sha256": {path.name: hashlib.sha256(path.read_bytes()).hexdigest() for path in case.csv},
    }


def check_free(out: Path) -> None:
    """Refuse a folder that already holds a case.

    Raises:
        BlindError: records or a truth are already there.
    """
    found = sorted(path.name for path in out.glob("record_*.csv")) if out.is_dir() else []
    if found or (out / "sealed").exists():
        what = found[0] if found else "sealed"
        raise BlindError(f"{out}: expected a folder without a case, found {what}")


def write(case: Case) -> None:
    """Write measurements, noiseless channels and the sealed truth."""
    case.sealed.mkdir(parents=True, exist_ok=True)
    for path, record, clean in zip(case.csv, case.noisy, case.clean, strict=True):
        table = np.stack([record[name] for name in COLUMNS], axis=1)
        np.savetxt(path, table, _FORMATS, delimiter=",", header=",".join(COLUMNS), comments="")
        columns: dict[str, Any] = dict(clean)
        np.savez_compressed(case.sealed / f"{path.stem}.truth.npz", **columns)
    (case.sealed / "truth.json").write_text(json.dumps(truth(case), indent=2) + "\n")
