"""What the importers of measured data sets share: sign check and zero of the deflection."""

from __future__ import annotations

from pathlib import Path

import numpy as np
from er_models.errors import InputError
from er_records.record import Array, Record


def centred(x: Array) -> tuple[Array, str]:
    """Deflection with its zero at the centre of the stroke, and a note on where that was."""
    centre = 0.5 * (float(x.min()) + float(x.max()))
    return (
        x - centre,
        f"deflection is zero at the centre of the stroke, {1e3 * centre:.3f} mm on the rig",
    )


def dissipated(x: Array, force: Array) -> float:
    """Energy the force takes out of the motion [J], trapezoidal rule."""
    return float(np.sum(0.5 * (force[1:] + force[:-1]) * np.diff(x)))


def check_dissipates(record: Record, path: Path) -> None:
    """Refuse a record whose force drives the motion: a sign or a channel is swapped."""
    energy = dissipated(record.channels["deflection"], record.channels["damper_force"])
    if energy <= 0.0:
        raise InputError(
            path, record.name, "a damper force that takes energy out", f"{energy:.3g} J"
        )
