"""Data set `piston_seal_friction`: seal friction of a pneumatic piston at constant pressure.

Source: github.com/EvaZillen/3D-printed-pneumatic-actuator, commit 6e0bcb4, CC0 1.0 (see SOURCE.txt
beside the data). Files `<seal>_<pressure>bar.csv`, tab separated, no header, about 100 Hz with
pauses of the logger; the first row is a tare.

Sign: the pressure pushes the piston out and the load cell counts that push positive, against a
displacement inwards; both are turned round, so that the deflection is positive in extension.
"""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
from er_models.errors import InputError
from er_records.provenance import digest_bytes
from er_records.record import Array, Record

from er_studies.importers.checks import centred, check_dissipates

FULL_PRESSURE = 7.0
PASCAL_PER_BAR = 1e5
SOURCE = "github.com/EvaZillen/3D-printed-pneumatic-actuator 6e0bcb4"
LICENCE = "CC0 1.0"
COLUMNS = 7
TIME_MS, POSITION_MM, PRESSURE_BAR, FORCE_N = 0, 4, 5, 6

_NAME = re.compile(r"^(?P<seal>.+)_(?P<bar>\d+)bar$")


def read(path: Path) -> list[Record]:
    """The one run of a file, times as logged; `er_records.clean` splits it at the pauses.

    Raises:
        InputError: Another file name or layout.
    """
    found = _NAME.match(path.stem)
    if found is None or not 0.0 < float(found["bar"]) <= FULL_PRESSURE:
        raise InputError(path, "name", "<seal>_<pressure up to 7>bar.csv", path.name)
    data = path.read_bytes()
    table = _table(path, data)[1:]
    deflection, note = centred(-1e-3 * table[:, POSITION_MM])
    channels = {
        "deflection": deflection,
        "duty": np.full(len(table), float(found["bar"]) / FULL_PRESSURE),
        "damper_force": -table[:, FORCE_N],
        "pressure": PASCAL_PER_BAR * table[:, PRESSURE_BAR],
    }
    notes = (
        "the first row is a tare and was left out",
        "deflection and force turned round: the rig counts compression positive",
        f"duty is the nominal pressure, {found['bar']} bar; 1 = {FULL_PRESSURE:g} bar; "
        "the measured one is the channel 'pressure'",
        note,
    )
    record = Record(
        path.stem,
        1e-3 * table[:, TIME_MS],
        channels,
        notes,
        source=f"{SOURCE} {path.name}",
        digest=digest_bytes(data),
        scales={"duty": f"1 = {FULL_PRESSURE:g} bar"},
        licence=LICENCE,
    )
    check_dissipates(record, path)
    return [record]


def _table(path: Path, data: bytes) -> Array:
    """The numbers of a file (N, 7)."""
    try:
        table = np.loadtxt(data.decode().splitlines(), delimiter="\t", ndmin=2)
    except (ValueError, UnicodeDecodeError) as error:
        found = str(error).splitlines()[0]
        raise InputError(path, "", "a table of numbers, tab separated", found) from None
    if table.shape[1] != COLUMNS or len(table) < 2:
        raise InputError(path, "columns", f"{COLUMNS} without a header", table.shape[1])
    return np.asarray(table)
