"""Text files of the MTS machine's data acquisition: header, numbered samples, events."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path

import numpy as np
from er_models.errors import InputError
from er_records.provenance import digest_bytes
from er_records.record import Array

HEADER_LINES = 7


@dataclass(frozen=True, slots=True)
class Acquisition:
    """A file as written: rate [Hz], channels (N, C) in raw units, first row of each run."""

    rate: float
    raw: Array
    starts: tuple[int, ...]
    digest: str


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
