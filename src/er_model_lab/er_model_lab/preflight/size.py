"""Whether force and deflection are of the size, and about the middle, that a model is made for."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

import numpy as np
from er_models.model import Array, Model
from er_models.scales import peak
from er_records.record import Record

from er_model_lab.preflight.finding import Finding
from er_model_lab.residual.errors import ANOTHER_SIZE


def size_findings(records: Sequence[Record], model: Model) -> Iterator[Finding]:
    """Warnings where the data are another damper's, of another unit, or off centre."""
    forces = _all(records, "damper_force")
    if forces.size:
        size, expected = peak(forces), model.scales.force
        if not expected / ANOTHER_SIZE < size < expected * ANOTHER_SIZE:
            yield Finding(
                "size", "warning", records[0].name, "damper_force",
                f"forces within {ANOTHER_SIZE:g} times those of '{model.name}'",
                f"forces of {_newtons(size)} where the model is made for {_newtons(expected)}",
                "another damper (lab identify), or another unit: state it, as in 'damper_force [kN]'",
                records[0].source,
            )  # fmt: skip
    for record in records:
        if middle := off_centre(record, model):
            reach = model.scales.deflection
            yield Finding(
                "size", "warning", record.name, "deflection", f"a middle within {1e3 * reach:.3g} mm of zero",
                f"{1e3 * middle:.4g} mm", "set the sensor's zero, or ask lab diagnose (deflection_zero)", record.source,
            )  # fmt: skip


def off_centre(record: Record, model: Model) -> float:
    """Middle of the deflection of a record [m] where it lies beyond what a model is made for; 0 where it does not."""
    if not record.has("deflection"):
        return 0.0
    middle = float(np.nanmedian(record.channels["deflection"]))
    return middle if abs(middle) > model.scales.deflection else 0.0


def centre_notes(records: Sequence[Record], model: Model) -> tuple[str, ...]:
    """What is said of deflections whose middle lies beyond what the model is made for."""
    middles = sorted(middle for record in records if (middle := off_centre(record, model)))
    if not middles:
        return ()
    ends = dict.fromkeys(f"{1e3 * middle:.3g}" for middle in (middles[0], middles[-1]))
    return (
        f"the deflection's middle is at {' to '.join(ends)} mm, the model is made for "
        f"{1e3 * model.scales.deflection:.3g} mm to either side: the sensor's zero may be another (deflection_zero)",
    )


def _newtons(force: float) -> str:
    """Three digits of a force, without a power of ten."""
    return f"{float(f'{force:.3g}'):.10g} N"


def _all(records: Sequence[Record], channel: str) -> Array:
    parts = [r.channels[channel] for r in records if r.has(channel)]
    found = np.concatenate(parts) if parts else np.empty(0)
    return np.asarray(found[np.isfinite(found)])
