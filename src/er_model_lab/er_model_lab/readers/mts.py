"""Data set `mr_damper_mts`: a magnetorheological damper on an MTS machine.

Source: github.com/DanielMaurelE/vRTHS_AMBC_MRdamper, commit 08753ff, MIT (c) 2022 mequiroz (see
SOURCE.txt beside the data). Sines in `ME<amplitude>mm<frequency>Hz.txt`, five currents a file, cut
by the events 'DAQ Pause' and 'DAQ Resume'; sweeps in `15Hz<current>A.txt`.

Sign: force and displacement rise together with a gas force that is positive everywhere and grows
with the displacement, so the machine counts compression positive; both are turned round here.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from math import gcd
from pathlib import Path

import numpy as np
from scipy.signal import resample_poly

from er_model_lab.provenance import digest_bytes
from er_model_lab.readers.imported import centred, check_dissipates
from er_model_lab.record import Array, Record
from er_models.errors import InputError, UnknownName

METRES_PER_UNIT = 0.010
NEWTONS_PER_UNIT = 980.665
CURRENTS = (0.0, 0.25, 0.5, 0.75, 1.0)
"""Current of the five runs of a sine file, in order [A]; the force amplitude must rise with it."""

FULL_CURRENT = 1.0
SOURCE = "github.com/DanielMaurelE/vRTHS_AMBC_MRdamper 08753ff"
TURNED = "deflection and force turned round: the machine counts compression positive"
LICENCE = "MIT (c) 2022 mequiroz"
TRAINING = ("ME2mm5Hz", "ME5mm3Hz", "ME25mm0x25Hz", "ME25mm0x5Hz")
HEADER_LINES = 7

_SINE = re.compile(r"^ME\d+mm[\dx]+Hz$")
_SWEEP = re.compile(r"^15Hz(?P<current>[\d.]+)A$")


@dataclass(frozen=True, slots=True)
class Acquisition:
    """A file as written: rate [Hz], channels (N, C) in raw units, first row of each run."""

    rate: float
    raw: Array
    starts: tuple[int, ...]
    digest: str


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
    acquisition = parse(path)
    force_column, motion_column = (0, 1) if acquisition.rate == 200.0 else (1, 0)
    motion = METRES_PER_UNIT * acquisition.raw[:, motion_column]
    force = NEWTONS_PER_UNIT * acquisition.raw[:, force_column]
    currents = _currents(path, len(acquisition.starts))
    edges = (*acquisition.starts, motion.size)
    runs = []
    for current, i, j in zip(currents, edges[:-1], edges[1:], strict=True):
        name = f"{path.stem.removesuffix(f'{current:g}A')}-{current:g}A"
        runs.append(_run(path, name, current, -motion[i:j], -force[i:j], acquisition, rate))
    _check_order(path, runs)
    return runs


def parse(path: Path) -> Acquisition:
    """The text file as numbers; `InputError` naming the line that is not as expected."""
    data = path.read_bytes()
    lines = data.decode("utf-8", errors="replace").splitlines()
    if len(lines) <= HEADER_LINES or not lines[0].startswith("Header Size"):
        raise InputError(
            path, "line 1", "'Header Size: 7' and samples", lines[0][:40] if lines else "nothing"
        )
    rate = _header_rate(path, lines[3])
    channels = lines[6].count("CHANNEL")
    rows: list[list[float]] = []
    starts = [0]
    for number, line in enumerate(lines[HEADER_LINES:]):
        cells = line.split(",")
        try:
            rows.append([float(cell) for cell in cells[2 : 2 + channels]])
            counted = int(cells[0])
        except ValueError:
            counted = -1
        if counted != number + 1 or len(rows[-1]) != channels:
            where = f"line {number + HEADER_LINES + 1}"
            raise InputError(
                path, where, f"sample {number + 1} with {channels} channels", line[:60]
            )
        if any("Resume" in cell for cell in cells[2 + channels :]):
            starts.append(number)
    return Acquisition(rate, np.asarray(rows), tuple(starts), digest_bytes(data))


def _header_rate(path: Path, line: str) -> float:
    """Sampling rate [Hz] from the fourth header line."""
    key, _, value = line.partition(":")
    if key != "Sampling Rate" or not value.strip().isdigit() or int(value) % 100:
        raise InputError(path, "line 4", "'Sampling Rate: 200' or 1000", line[:60])
    return float(value)


def _currents(path: Path, runs: int) -> Sequence[float]:
    """Current of each run of a file [A]."""
    sweep = _SWEEP.match(path.stem)
    if sweep is None and not _SINE.match(path.stem):
        raise InputError(
            path, "name", "ME<amplitude>mm<frequency>Hz.txt or 15Hz<current>A.txt", path.name
        )
    currents = CURRENTS if sweep is None else (float(sweep["current"]),)
    if runs != len(currents):
        raise InputError(path, "events", f"{len(currents)} runs between 'DAQ Resume' events", runs)
    return currents


def _run(
    path: Path,
    name: str,
    current: float,
    x: Array,
    force: Array,
    acquisition: Acquisition,
    rate: float,
) -> Record:
    """One run as a record: resampled, zero at the centre of the stroke, duty constant."""
    notes = [
        TURNED,
        f"duty is the current of the run, {current:g} A, by its place; 1 = {FULL_CURRENT:g} A",
        _standstill(x, acquisition.rate),
    ]
    if rate != acquisition.rate:
        x, force = (
            _resampled(path, x, acquisition.rate, rate),
            _resampled(path, force, acquisition.rate, rate),
        )
        notes.append(
            f"{acquisition.rate:g} Hz brought to {rate:g} Hz behind a zero-phase anti-alias filter"
        )
    x, note = centred(x)
    channels = {
        "deflection": x,
        "duty": np.full(x.size, current / FULL_CURRENT),
        "damper_force": force,
    }
    record = Record(
        name,
        np.arange(x.size) / rate,
        channels,
        (*notes, note),
        True,
        f"{SOURCE} {path.name}",
        acquisition.digest,
        {"duty": f"1 = {FULL_CURRENT:g} A"},
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


def _resampled(path: Path, samples: Array, old: float, new: float) -> Array:
    """Samples at another rate; the FIR filter is symmetric, so nothing is delayed."""
    if new <= 0.0 or new != round(new):
        raise InputError(path, "rate", "a whole number of Hz above 0", new)
    common = gcd(round(old), round(new))
    return np.asarray(
        resample_poly(samples, round(new) // common, round(old) // common, padtype="line")
    )


def _check_order(path: Path, runs: list[Record]) -> None:
    """Refuse runs whose force amplitude does not rise from run to run as the current does."""
    amplitudes = [0.5 * float(np.ptp(run.channels["damper_force"])) for run in runs]
    if any(b <= a for a, b in pairwise(amplitudes)):
        found = ", ".join(f"{a:.0f} N" for a in amplitudes)
        raise InputError(path, "runs", "force amplitudes that rise with the current", found)
