"""Data set `mr_damper_mts`: a magnetorheological damper on an MTS machine.

Source: github.com/DanielMaurelE/vRTHS_AMBC_MRdamper, commit 08753ff, MIT (c) 2022 mequiroz (see
SOURCE.txt beside the data). Sines in `ME<amplitude>mm<frequency>Hz.txt`, five currents a file, cut
by the events 'DAQ Pause' and 'DAQ Resume'; sweeps in `15Hz<current>A.txt` (0x5 for 0.5).

Sign: force and displacement rise together with a gas force that is positive everywhere and grows
with the displacement, so the machine counts compression positive; both are turned round here.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import replace
from itertools import pairwise
from math import gcd
from pathlib import Path

import numpy as np
from er_models.errors import InputError, UnknownName
from er_records.record import Array, Record
from scipy.signal import resample_poly

from er_studies.importers.checks import centred, check_dissipates
from er_studies.importers.mts_text import Acquisition, parse

METRES_PER_UNIT = 0.010
NEWTONS_PER_UNIT = 980.665
CURRENTS = (0.0, 0.25, 0.5, 0.75, 1.0)
"""Current of the five runs of a sine file, in order [A]; the force amplitude must rise with it."""

FULL_CURRENT = 1.0
SOURCE = "github.com/DanielMaurelE/vRTHS_AMBC_MRdamper 08753ff"
TURNED = "deflection and force turned round: the machine counts compression positive"
LICENCE = "MIT (c) 2022 mequiroz"
TRAINING = ("ME2mm5Hz", "ME5mm3Hz", "ME25mm0x25Hz", "ME25mm0x5Hz")

_SINE = re.compile(r"^ME\d+mm[\dx]+Hz$")
_SWEEP = re.compile(r"^15Hz(?P<current>\d+(?:[.x]\d+)?)A$")


def split(name: str) -> str:
    """Part of the data set a file or record is in: `train`, `held_out_sine`, `held_out_sweep`.

    `UnknownName` for a name that is none of the data set's.
    """
    stem = name.split("-")[0].removesuffix(".txt")
    if stem in TRAINING:
        return "train"
    if _SINE.match(stem):
        return "held_out_sine"
    if name.startswith("15Hz"):
        return "held_out_sweep"
    raise UnknownName("run", name, (*TRAINING, "ME10mm2Hz", "15Hz0A", "15Hz1A"))


def read(path: Path, rate: float = 200.0) -> list[Record]:
    """Runs of one file, one record each, named `ME2mm5Hz-0.25A`.

    Args:
        path: File.
        rate: Sampling rate of the result [Hz]; faster files pass an anti-alias filter.

    Raises:
        InputError: Another layout or number of runs, or forces in another order than currents.
    """
    acquired = parse(path)
    force_column, motion_column = (0, 1) if acquired.rate == 200.0 else (1, 0)
    motion = METRES_PER_UNIT * acquired.raw[:, motion_column]
    force = NEWTONS_PER_UNIT * acquired.raw[:, force_column]
    currents = _currents(path, len(acquired.starts))
    edges = pairwise((*acquired.starts, motion.size))
    runs = [
        _run(path, current, -motion[i:j], -force[i:j], acquired)
        for current, (i, j) in zip(currents, edges, strict=True)
    ]
    _check_order(path, runs)
    return [_resampled(run, acquired.rate, rate) for run in runs]


def _currents(path: Path, runs: int) -> Sequence[float]:
    """Current of each run of a file [A]."""
    sweep = _SWEEP.match(path.stem)
    if sweep is None and not _SINE.match(path.stem):
        raise InputError(
            path, "name", "ME<amplitude>mm<frequency>Hz.txt or 15Hz<current>A.txt", path.name
        )
    currents = CURRENTS if sweep is None else (float(sweep["current"].replace("x", ".")),)
    if runs != len(currents):
        raise InputError(path, "events", f"{len(currents)} runs between 'DAQ Resume' events", runs)
    return currents


def _run(path: Path, current: float, x: Array, force: Array, acquired: Acquisition) -> Record:
    """One run at the rate of its file: zero at the centre of the stroke, duty constant."""
    x, note = centred(x)
    notes = (
        TURNED,
        f"duty is the current of the run, {current:g} A, by its place; 1 = {FULL_CURRENT:g} A",
        _standstill(x, acquired.rate),
        note,
    )
    record = Record(
        f"{_SWEEP.sub('15Hz', path.stem)}-{current:g}A",
        np.arange(x.size) / acquired.rate,
        {"deflection": x, "duty": np.full(x.size, current / FULL_CURRENT), "damper_force": force},
        notes,
        source=f"{SOURCE} {path.name}",
        digest=acquired.digest,
        scales={"duty": f"1 = {FULL_CURRENT:g} A"},
        licence=LICENCE,
    )
    check_dissipates(record, path)
    return record


def _standstill(x: Array, rate: float, threshold: float = 2e-4) -> str:
    """A note on when the machine moves: displacement leaves its first or last value by 0.2 mm."""
    moving = np.flatnonzero((np.abs(x - x[0]) > threshold) | (np.abs(x - x[-1]) > threshold))
    if not moving.size:
        return "the machine stands still"
    first, last = moving[0] / rate, moving[-1] / rate
    return f"the machine stands still before {first:.2f} s and after {last:.2f} s"


def _resampled(record: Record, old: float, new: float) -> Record:
    """The run at another rate [Hz]; the FIR filter is symmetric, so nothing is delayed."""
    if new == old:
        return record
    if new <= 0.0 or new != round(new):
        raise InputError(record.source, "rate", "a whole number of Hz above 0", new)
    common = gcd(round(old), round(new))
    up, down = round(new) // common, round(old) // common
    channels = {
        name: resample_poly(record.channels[name], up, down, padtype="line")
        for name in ("deflection", "damper_force")
    }
    n = channels["deflection"].size
    channels["duty"] = np.full(n, record.channels["duty"][0])
    note = f"{old:g} Hz brought to {new:g} Hz behind a zero-phase anti-alias filter"
    return replace(record, t=np.arange(n) / new, channels=channels).noted(note)


def _check_order(path: Path, runs: list[Record]) -> None:
    """Refuse runs whose force amplitude does not rise from run to run as the current does."""
    amplitudes = [0.5 * float(np.ptp(run.channels["damper_force"])) for run in runs]
    if any(b <= a for a, b in pairwise(amplitudes)):
        found = ", ".join(f"{a:.0f} N" for a in amplitudes)
        raise InputError(path, "runs", "force amplitudes that rise with the current", found)
