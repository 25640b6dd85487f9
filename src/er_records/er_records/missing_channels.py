"""What is lost for want of a channel, or of a rate."""

from __future__ import annotations

from collections.abc import Iterator, Sequence

from er_records.record import Record

NO_DUTY = "no duty channel: taken as 0, effects of the field cannot be seen"
"""What is said of records without a duty."""
ACCELEROMETERS = ("sprung_acceleration", "unsprung_acceleration")
SAME = 1.02
"""Ratio of rates that are one rate."""


def losses(records: Sequence[Record]) -> tuple[str, ...]:
    """What is lost for want of channels or of one rate, and in how many records."""
    said: dict[str, int] = {}
    for r in records:
        for sentence in _lost(r):
            said[sentence] = said.get(sentence, 0) + 1
    many = len(records)
    lacking = (s if n == many else f"{s} ({n} of {many} records)" for s, n in said.items())
    return (*_slowed(records), *lacking)


def _slowed(records: Sequence[Record]) -> Iterator[str]:
    """Records that are faster than the slowest, at whose rate all are looked at."""
    rates = [1.0 / r.dt for r in records]
    faster = sum(rate > SAME * min(rates) for rate in rates)
    if faster:
        yield (
            f"rates from {min(rates):.4g} to {max(rates):.4g} Hz: {faster} of {len(records)} records are averaged to "
            f"{min(rates):.4g} Hz, what is faster is lost; give records of one rate to use it"
        )


def _lost(r: Record) -> list[str]:
    """What one record lacks."""
    out = []
    accelerometers = [r.has(c) for c in ACCELEROMETERS]
    if not all(accelerometers):
        out.append(
            "without both accelerations the velocity is known less well: effects near zero velocity blur"
        )
    if any(accelerometers) and not all(accelerometers):
        out.append(
            "one acceleration alone says nothing of the motion between the masses: it is not used"
        )
    if not r.has("deflection"):
        out.append(
            "without the deflection its zero and slow part are unknown: the motion is taken about the middle, "
            "effects of position blur"
        )
    if not r.has("deflection_velocity") or "deflection_velocity" in r.derived:
        out.append("without a velocity channel its lag and gain cannot be checked")
    if not r.has("duty"):
        out.append(NO_DUTY)
    return out
