"""Chapter 6, faults, as JSON and as lines for a terminal."""

from __future__ import annotations

from typing import Any

import numpy as np
from er_model_lab.results.values import clean

from er_studies.given_out import Table
from er_studies.thesis.chapter_1_text import columns
from er_studies.thesis.chapter_6 import LEAK, SEQUENCES, Chapter6

HEAD = (
    "fault",
    "left: f1, f2, f3",
    "a duty exists [%]",
    "mimic to fault, worst [% of range]",
    "fault to healthy, rms [N]",
)


def rows(found: Chapter6) -> list[tuple[str, ...]]:
    """Rows under `HEAD`."""
    return [
        (
            case.name,
            "; ".join(
                f"{f.electrical:g}, {f.leakage:g}, {f.deformation:g}" for f in SEQUENCES[case.name]
            ),
            f"{100.0 * case.exists:.1f}",
            f"{100.0 * case.worst:.2g}",
            f"{np.sqrt(np.mean((case.faulty - found.healthy) ** 2)):.2f}",
        )
        for case in found.cases
    ]


def result(found: Chapter6) -> dict[str, Any]:
    """Everything as plain data."""
    healthy, leaking = found.real
    data: dict[str, Any] = clean({
        "command": "thesis chapter6", "model": found.model.name,
        "mimics": {
            case.name: {
                "exists": case.exists, "worst": case.worst,
                "duty": [float(case.mimic.duty.min()), float(case.mimic.duty.max())],
            }
            for case in found.cases
        },
        "domain": {
            "leakage": LEAK.leakage,
            "healthy": [float(healthy.low.min()), float(healthy.high.max())],
            "leaking": [float(leaking.low.min()), float(leaking.high.max())],
        },
        "tables": [Table(HEAD, rows(found))._asdict()],
    })  # fmt: skip
    return data


def lines(found: Chapter6) -> list[str]:
    """The screen."""
    healthy, leaking = found.real
    return [
        *columns(HEAD, rows(found)),
        "",
        f"forces on the ride, duty 0 to 1: healthy {healthy.low.min():.1f} to {healthy.high.max():.1f} N, "
        f"f2 = {LEAK.leakage:g}: {leaking.low.min():.1f} to {leaking.high.max():.1f} N",
    ]
