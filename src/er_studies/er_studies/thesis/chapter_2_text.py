"""Chapter 2 as JSON and as lines for a terminal."""

from __future__ import annotations

from typing import Any

import numpy as np
from er_model_lab.results.values import clean
from er_models.forms.passive import OUTPUTS
from er_models.forms.ride import SIGNALS
from er_models.forms.sensing import Sensing

from er_studies.given_out import Table
from er_studies.thesis.chapter_1_text import columns
from er_studies.thesis.chapter_2 import PUBLISHED, Chapter2, departures

HEAD_PEAKS = ("passive car, peaks [Hz]", "thesis", "ours", "gain")
HEAD_RIDE = ("largest departure from the record", *SIGNALS)
HEAD_ZEROS = ("velocities", "unknown", "sensors", "zeros [1/s]", "errors decay")


def peaks(found: Chapter2) -> list[tuple[str, ...]]:
    """Rows under `HEAD_PEAKS`."""
    rows: list[tuple[str, ...]] = []
    for name in OUTPUTS:
        ours = found.peaks[name]
        rows.append(
            (
                f"{name} / z_r",
                ", ".join(f"{p:.0f}" for p in PUBLISHED[name]) or "-",
                ", ".join(f"{p.hertz:.2f}" for p in ours),
                ", ".join(f"{p.gain:.3f}" for p in ours),
            )
        )
    return rows


def ride(found: Chapter2) -> list[tuple[str, ...]]:
    """Rows under `HEAD_RIDE`: shares of each signal's range."""
    r = found.ride
    pairs = [(name, signals, r.record) for name, signals in r.forms.items()]
    pairs.append(("descriptor (2.19), leaking", r.descriptor, r.leaking))
    return [
        (name, *(f"{share:.1e}" for share in departures(signals, wanted)))
        for name, signals, wanted in pairs
    ]


def zeros(found: Chapter2) -> list[tuple[str, ...]]:
    """Rows under `HEAD_ZEROS`: what no sensor shows, for each choice of state, unknown inputs and sensors."""
    return [
        (
            s.velocities,
            " + ".join(s.unknowns),
            " + ".join(s.sensors),
            ", ".join(f"{z:.1f}" for z in rates(s)) or "none",
            "yes" if all(z < 0.0 for z in rates(s)) else "no",
        )
        for s in found.systems
    ]


def rates(system: Sensing) -> list[float]:
    """Real parts of the zeros [1/s]; what is zero but for rounding, a thousandth of the slowest pole, is zero."""
    poles = np.abs(np.linalg.eigvals(system.A))
    tiny = 1e-3 * float(poles[poles > 1e-9].min())
    return [0.0 if abs(z) < tiny else float(z.real) for z in system.zeros]


def result(found: Chapter2) -> dict[str, Any]:
    """Everything as plain data."""
    r = found.ride
    every = {**r.forms, "descriptor (2.19), leaking": r.descriptor}
    data: dict[str, Any] = clean({
        "command": "thesis chapter2", "model": found.model.name,
        "peaks": {
            name: {"thesis": list(PUBLISHED[name]), "ours": [p._asdict() for p in found.peaks[name]]}
            for name in OUTPUTS
        },
        "departures": {
            name: dict(zip(SIGNALS, departures(y, r.leaking if "leaking" in name else r.record).tolist(), strict=True))
            for name, y in every.items()
        },
        "zeros": [
            {"velocities": s.velocities, "unknowns": list(s.unknowns), "sensors": list(s.sensors), "zeros": rates(s)}
            for s in found.systems
        ],
        "tables": [table._asdict() for table in tables(found)],
    })  # fmt: skip
    return data


def tables(found: Chapter2) -> list[Table]:
    """Peaks, departures of the forms, zeros."""
    return [
        Table(HEAD_PEAKS, peaks(found)),
        Table(HEAD_RIDE, ride(found)),
        Table(HEAD_ZEROS, zeros(found)),
    ]


def lines(found: Chapter2) -> list[str]:
    """The screen."""
    return [line for table in tables(found) for line in (*columns(table.head, table.rows), "")][
        :-1
    ]
