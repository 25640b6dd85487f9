"""Data set `mr_damper_shaking_table`: a magnetorheological damper on a crank-driven table.

Source: github.com/labcontrol-data/mr-damper, commit e42439f, MIT (c) 2021 Labcontrol, cite
doi 10.5281/zenodo.4445334 (see SOURCE.txt beside the data). Voltages are those of the table in
Ensaios.ods. They are not stated for `ensaioN.2` and `ensaio.vali.A.N`: there the voltage is
inferred from the force, by comparison with the runs of known voltage, and the duty counts as
derived.

Sign: the gas force is positive in the files, so compression is positive there; both are turned
round.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from pathlib import Path

import numpy as np
from er_models.errors import InputError
from er_records.provenance import digest_files
from er_records.readers.mat import table
from er_records.readers.names import Given
from er_records.readers.table import record
from er_records.record import Array, Record
from scipy.signal import savgol_filter

from er_studies.importers.checks import centred, check_dissipates

FULL_VOLTAGE = 3.212
SOURCE = "github.com/labcontrol-data/mr-damper e42439f, doi 10.5281/zenodo.4445334"
TURNED = "deflection and force turned round: the rig counts compression positive"
VELOCITY_NOT_USED = "the velocity in the file is a backward difference, half a sample late: unused"
LICENCE = "MIT (c) 2021 Labcontrol"

LEVELS: tuple[tuple[str, float | None], ...] = (
    (r"ensaio\d+\.1", 0.0),
    (r"ensaio\.vali\.\d+", 0.8712),
    (r"ensaio\.B\.\d+", 1.98),
    (r"ensaio\.A\.\d+", 3.212),
    (r"ensaio\d+\.2", None),
    (r"ensaio\.vali\.A\.\d+", None),
)
"""File name (without .mat) to voltage [V]; None where it is not stated."""

NAMES: Given = {
    "deflection": {"from": "dist", "unit": "mm", "sign": -1},
    "damper_force": {"from": "forc", "sign": -1},
    "t": "Tout",
}
"""What the variables of a file are, as `names.yaml` would say it."""
VARIABLES = ("dist", "forc", "Tout")

SPEED_BAND = (0.015, 0.025)
"""Speeds at which forces are compared to infer a voltage [m/s]: every run passes through them."""


def read(path: Path, known: Sequence[tuple[float, float]] = ()) -> list[Record]:
    """The one run of a file.

    Args:
        path: `.mat` file.
        known: (voltage [V], `plateau` [N]) of runs with a stated voltage, for a file without.

    Raises:
        InputError: Another file name or other variables.
    """
    x, force, t = _variables(path)
    voltage = stated_voltage(path)
    inferred = voltage is None and len({level for level, _ in known}) >= 2
    if inferred:
        voltage = infer_voltage(plateau(x, force, t), known)
    deflection, note = centred(x)
    channels = {"deflection": deflection, "damper_force": force}
    if voltage is not None:
        channels["duty"] = np.full(t.size, min(voltage / FULL_VOLTAGE, 1.0))
    run = Record(
        path.stem,
        t,
        channels,
        (TURNED, _duty_note(voltage, inferred=inferred), VELOCITY_NOT_USED, note),
        source=f"{SOURCE} {path.name}",
        digest=digest_files([path]),
        scales={"duty": f"1 = {FULL_VOLTAGE:g} V"},
        derived=("duty",) if inferred else (),
        licence=LICENCE,
    )
    check_dissipates(run, path)
    return [run]


def read_folder(folder: Path) -> list[Record]:
    """All runs of a folder in the order of their names; unknown voltages are inferred."""
    files = sorted(folder.glob("*.mat"), key=_natural)
    if not files:
        raise InputError(folder, "", "files ensaio*.mat", "none")
    known = []
    for file in files:
        voltage = stated_voltage(file)
        if voltage is not None:
            known.append((voltage, plateau(*_variables(file))))
    return [run for file in files for run in read(file, known)]


def stated_voltage(path: Path) -> float | None:
    """Voltage of a run by its file name [V], None where the source does not state it."""
    for pattern, voltage in LEVELS:
        if re.fullmatch(pattern, path.stem):
            return voltage
    raise InputError(
        path, "name", "ensaioN.1, ensaioN.2, ensaio.A.N, .B.N, .vali.N or .vali.A.N", path.stem
    )


def plateau(x: Array, force: Array, t: Array) -> float:
    """Half the distance between the forces of the two directions at about 20 mm/s [N].

    It rises strictly with the voltage and hardly depends on the stroke (spread within 10 %).
    """
    velocity = savgol_filter(x, 7, 3, deriv=1, delta=float(np.median(np.diff(t))))
    low, high = SPEED_BAND
    forth = (velocity > low) & (velocity < high)
    back = (velocity < -low) & (velocity > -high)
    return 0.5 * float(np.median(force[forth]) - np.median(force[back]))


def infer_voltage(force: float, known: Sequence[tuple[float, float]]) -> float:
    """Voltage [V] at which the known runs show this `plateau`, linear between their medians."""
    levels = sorted({level for level, _ in known})
    medians = [float(np.median([p for level, p in known if level == wanted])) for wanted in levels]
    return float(np.interp(force, medians, levels))


def _duty_note(voltage: float | None, *, inferred: bool) -> str:
    """Where the duty comes from."""
    if voltage is None:
        return "the voltage of this run is not stated: no duty"
    if inferred:
        return (
            f"the voltage is not stated: {voltage:.2f} V (within 0.15 V), inferred from the"
            " force by the runs of known voltage; this run is no evidence on the field"
        )
    return f"duty is the voltage of the run, {voltage:g} V; 1 = {FULL_VOLTAGE:g} V"


def _variables(path: Path) -> tuple[Array, Array, Array]:
    """Displacement [m] and force [N], both turned round, and time [s]."""
    stored = table(path)
    missing = [key for key in VARIABLES if key not in stored.header]
    if missing:
        raise InputError(path, "variables", ", ".join(VARIABLES), f"no {', '.join(missing)}")
    run = record(stored, NAMES)
    return run.channels["deflection"], run.channels["damper_force"], run.t


def _natural(path: Path) -> tuple[str | int, ...]:
    """Sort key that puts ensaio10 behind ensaio9."""
    return tuple(int(part) if part.isdigit() else part for part in re.split(r"(\d+)", path.stem))
