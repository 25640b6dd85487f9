"""Data set `piston_seal_friction`: seal friction of a pneumatic piston at constant pressure.

Source: github.com/EvaZillen/3D-printed-pneumatic-actuator, commit 6e0bcb4, CC0 1.0 (see SOURCE.txt
beside the data). Files `<seal>_<pressure>bar.csv`, tab separated, no header, about 100 Hz with
pauses of the logger; the first row is a tare.

Duty: the measured pressure. A record of nominally 3 bar may be 0.07 bar off, which moves the force by 3.6 N: more than
half of what a model of the nominal pressure leaves.

Sign: the pressure pushes the piston out and the load cell counts that push positive, against a
displacement inwards; both are turned round, so that the deflection is positive in extension.
"""

from __future__ import annotations

import re
from pathlib import Path

from er_models.errors import InputError
from er_records.readers.csv import table
from er_records.readers.names import Given
from er_records.readers.table import record
from er_records.readers.units import UNITS
from er_records.record import Record

from er_studies.importers.checks import centred, check_dissipates

NOMINAL, FULL_PRESSURE = 7.0, 8.0
"""Highest nominal pressure, and what is counted as full duty: more than the regulator ever let through [bar]."""
SOURCE = "github.com/EvaZillen/3D-printed-pneumatic-actuator 6e0bcb4"
LICENCE = "CC0 1.0"
COLUMNS = 7
NAMES: Given = {
    "t": "column 1 [ms]",
    "deflection": {"from": "column 5", "unit": "mm", "sign": -1},
    "pressure": "column 6 [bar]",
    "damper_force": {"from": "column 7", "sign": -1},
}
"""What the columns of a file are, as `names.yaml` would say it."""

_NAME = re.compile(r"^(?P<seal>.+)_(?P<bar>\d+)bar$")


def read(path: Path) -> list[Record]:
    """The one run of a file, times as logged; `er_records.clean` splits it at the pauses.

    Raises:
        InputError: Another file name or layout.
    """
    found = _NAME.match(path.stem)
    if found is None or not 0.0 < float(found["bar"]) <= NOMINAL:
        raise InputError(path, "name", "<seal>_<pressure up to 7>bar.csv", path.name)
    stored = table(path)
    if len(stored.header) != COLUMNS or stored.header[0] != "column 1":
        found_there = f"{len(stored.header)}: {', '.join(stored.header)}"
        raise InputError(path, "columns", f"{COLUMNS} of numbers without a header", found_there)
    rows = record(stored, NAMES).slice(1, None)
    deflection, note = centred(rows.channels["deflection"])
    duty = rows.channels["pressure"] / (FULL_PRESSURE * UNITS["Pa"]["bar"])
    channels = {**rows.channels, "deflection": deflection, "duty": duty}
    notes = (
        "the first row is a tare and was left out",
        "deflection and force turned round: the rig counts compression positive",
        f"duty is the measured pressure, nominally {found['bar']} bar; 1 = {FULL_PRESSURE:g} bar",
        note,
    )
    run = Record(
        path.stem,
        rows.t,
        channels,
        notes,
        source=f"{SOURCE} {path.name}",
        digest=stored.digest,
        scales={"duty": f"1 = {FULL_PRESSURE:g} bar"},
        licence=LICENCE,
    )
    check_dissipates(run, path)
    return [run]
