"""Checks a record once for all formats, repairs what can be repaired, refuses what cannot.

Order: time, repeated rows, finite and plausible values, missing samples, holes, uneven
sampling, length, velocity.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
from er_models.errors import InputError

from er_records import repair, sampling
from er_records.record import CHANNELS, Record
from er_records.timing import timing_of

MIN_SECONDS = 2.0
MIN_SAMPLES = 200
SLOWEST = 0.1
"""Median step from which on rows are not the samples of a moving damper [s]."""

LIMITS: dict[str, tuple[float, str]] = {
    "road": (10.0, "looks like mm"),
    "deflection": (1.0, "looks like mm"),
    "deflection_velocity": (20.0, "looks like mm/s"),
    "damper_force": (1e6, "looks like mN"),
    "sprung_acceleration": (2000.0, "looks like mm/s2"),
    "unsprung_acceleration": (5000.0, "looks like mm/s2"),
    "actuator_force": (1e6, "looks like mN"),
    "sprung_displacement": (10.0, "looks like mm"),
    "unsprung_displacement": (10.0, "looks like mm"),
    "temperature": (500.0, "a temperature difference in K is meant"),
}
"""Largest believable magnitude in SI units, and what a larger one suggests."""

DUTY_ROUNDING = 1e-6


def clean(record: Record) -> list[Record]:
    """Checked and repaired pieces of a record as a reader returns it.

    Returns:
        One record, or `name#1`, `name#2`... when it had to be split.

    Raises:
        InputError: Unsorted or missing time, infinite or unbelievable values, no channel, or too
            short.
    """
    check_time(record)
    record = replace(record, timing=timing_of(record.t))
    record = repair.drop_held(record)
    check_repeats(record)
    check_values(record)
    record = repair.drop_empty(_rounded_duty(record))
    if not any(name in CHANNELS for name in record.channels):
        raise InputError(
            record.source, "channels", "at least one with a valid sample", "only missing samples"
        )
    record = repair.drop_sparse(repair.fill_slow(record))
    pieces = repair.split(repair.bridge(record))
    long_enough = [piece for piece in pieces if _enough(piece)]
    if not long_enough:
        raise _too_short(record, pieces)
    check_step(record)
    dropped = [piece for piece in pieces if not _enough(piece)]
    notes = [
        f"{piece.name} ({len(piece)} samples) is too short and was dropped" for piece in dropped
    ]
    even = (sampling.with_deflection(sampling.even(piece)) for piece in long_enough)
    return [sampling.with_velocity(piece).noted(*notes) for piece in even]


def check_time(record: Record) -> None:
    """Refuse an empty record, missing times and times that run backwards, naming the first row."""
    t = record.t
    if not t.size:
        raise InputError(record.source, "t", f"at least {MIN_SAMPLES} samples", "no rows")
    bad = np.flatnonzero(~np.isfinite(t))
    if bad.size:
        raise InputError(
            record.source, f"t, row {bad[0] + 1}", "a finite time [s]", f"{t[bad[0]]:g}"
        )
    back = np.flatnonzero(np.diff(t) < 0.0)
    if back.size:
        k = int(back[0])
        raise InputError(
            record.source,
            f"t, row {k + 2}",
            f"a time after {t[k]:.9g} s",
            f"{t[k + 1]:.9g} s (not sorted)",
        )


def check_step(record: Record) -> None:
    """Refuse times whose steps can only be another unit."""
    if record.dt >= SLOWEST:
        hint = " (looks like ms)" if record.dt < 1e3 * SLOWEST else ""
        raise InputError(
            record.source,
            "t",
            f"steps below {SLOWEST:g} s",
            f"{record.dt:.4g} s as a rule{hint}",
            record.cure,
        )


def check_repeats(record: Record) -> None:
    """Refuse two different rows at the same time."""
    same = np.flatnonzero(np.diff(record.t) == 0.0)
    if same.size:
        k = int(same[0])
        raise InputError(
            record.source,
            f"t, row {k + 2}",
            "one row a time",
            f"two different rows at {record.t[k]:.9g} s",
        )


def check_values(record: Record) -> None:
    """Refuse infinite samples and magnitudes that can only be another unit."""
    for name, samples in record.channels.items():
        infinite = np.flatnonzero(np.isinf(samples))
        if infinite.size:
            raise InputError(
                record.source, f"{name}, row {infinite[0] + 1}", "a finite number", "infinity"
            )
        valid = samples[~np.isnan(samples)]
        if not valid.size:
            continue
        low, high = float(valid.min()), float(valid.max())
        if name == "duty" and not -DUTY_ROUNDING <= low <= high <= 1.0 + DUTY_ROUNDING:
            hint = " (looks like percent)" if 1.5 < high <= 100.0 and low >= 0.0 else ""
            found = f"{low:.6g}..{high:.6g}{hint}"
            raise InputError(record.source, name, "0..1", found, record.cure)
        limit, hint = LIMITS.get(name, (np.inf, ""))
        if max(-low, high) > limit:
            unit = CHANNELS[name]
            raise InputError(
                record.source,
                name,
                f"at most {limit:g} {unit}",
                f"{max(-low, high):.6g} {unit} ({hint})",
                record.cure,
            )


def _rounded_duty(record: Record) -> Record:
    """Duty with rounding errors beyond 0 or 1 taken off."""
    if not record.has("duty"):
        return record
    duty = np.clip(record.channels["duty"], 0.0, 1.0)
    return replace(record, channels={**record.channels, "duty": duty})


def _seconds(record: Record) -> float:
    """Length in time, one sample time for each sample [s]."""
    return len(record) * record.dt if len(record) > 1 else 0.0


def _enough(record: Record) -> bool:
    """Whether a piece is long enough to fit anything to it."""
    # rounding of decimal times must not turn exactly 2 s into less
    return len(record) >= MIN_SAMPLES and _seconds(record) >= MIN_SECONDS * (1.0 - 1e-6)


def _too_short(record: Record, pieces: list[Record]) -> InputError:
    """The message for a record of which no piece is long enough."""
    longest = max(pieces, key=len, default=record.slice(0, 0))
    what = "the longest piece without gaps has " if len(longest) < len(record) else ""
    return InputError(
        record.source,
        "length",
        f"at least {MIN_SECONDS:g} s and {MIN_SAMPLES} samples",
        f"{what}{_seconds(longest):.3g} s, {len(longest)} samples",
    )
