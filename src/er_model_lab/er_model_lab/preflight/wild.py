"""Samples that are no measurements, found before anything is fitted: those that stand alone, bent ends, flat runs."""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import replace
from functools import lru_cache
from typing import Any

import numpy as np
from er_records.missing_channels import ACCELEROMETERS
from er_records.record import Record

from er_model_lab.preflight.bent_ends import bent_ends
from er_model_lab.preflight.finding import Finding, Level, joined
from er_model_lab.preflight.kinematics import parted
from er_model_lab.preflight.samples import FEW, clipped, hung, others
from er_model_lab.preflight.spikes import LEAST, Mask, spikes

JUDGED = ("damper_force", "deflection", "deflection_velocity", *ACCELEROMETERS)
STRUCK = 0.3
"""Share of an acceleration's range that a spike has at least: a corner of the road may strike for one sample."""
SLOPE = 3
"""Samples to either side that the slope of a derived velocity is taken from."""
WORDS = {
    "spikes": ("samples that agree with their neighbours", "alone"),
    "ends": ("ends that follow from the inside", "bent at an end"),
}


@lru_cache(maxsize=4)
def marked(record: Record) -> Record:
    """The record with its wild samples marked and noted; as it is where it was looked at before."""
    if record.wild is not None:
        return record
    measured = [c for c in JUDGED if record.has(c) and c not in record.derived]
    found = {name: _wild(record, name) for name in measured}
    wild = {name: mask for name, mask in found.items() if mask.any()}
    notes = [
        (
            f"1 sample of {name} is wild and gets no weight"
            if mask.sum() == 1
            else f"{int(mask.sum())} samples of {name} ({mask.mean():.2%}) are wild and get no weight"
        )
        for name, mask in wild.items()
    ]
    velocity = "deflection_velocity"
    if "deflection" in wild and velocity in record.derived:
        window = np.ones(2 * SLOPE + 1)
        wild[velocity] = np.convolve(wild["deflection"], window, "same") > 0.5
    return replace(record, wild=wild).noted(*notes)


def _wild(record: Record, name: str) -> Mask:
    """Wild samples (n,) of a channel."""
    y = record.channels[name]
    moving = {c: z for c, z in record.channels.items() if c == name or c != "damper_force"}
    beside = others(replace(record, channels=moving), name)
    flat = clipped(y, beside) | hung(y, beside, record.dt)
    alone = spikes(y, STRUCK if name in ACCELEROMETERS else LEAST)
    if flat.any() or alone.any():
        rows = np.arange(y.size)
        sound = ~(flat | alone)
        y = np.interp(rows, rows[sound], y[sound])
    apart = parted(record) if name in ("deflection", "deflection_velocity") else None
    return np.asarray(flat | alone | bent_ends(y, apart))


def bridged(record: Record) -> Record:
    """The record with straight lines in the place of wild samples."""
    if not record.wild:
        return record
    return replace(record, channels={name: record.bridged(name) for name in record.channels})


def places(record: Record) -> Iterator[dict[str, Any]]:
    """Each run of wild samples of a measured channel: its kind, and from when to when [s] since the beginning."""
    for name, mask in (record.wild or {}).items():
        if name in record.derived:
            continue
        y, edges = (
            record.channels[name],
            np.flatnonzero(np.diff(mask, prepend=False, append=False)),
        )
        for i, j in edges.reshape(-1, 2).tolist():
            level = j - i > 2 and np.ptp(y[i:j]) == 0.0
            kind = "flat" if level else "ends" if i == 0 or j == y.size else "spikes"
            since, until = (float(record.t[k] - record.t[0]) for k in (i, j - 1))
            yield {
                "record": record.name, "channel": name, "kind": kind, "samples": j - i, "from": since, "to": until,
            }  # fmt: skip


def wild_findings(record: Record) -> Iterator[Finding]:
    """Channels with samples that stand alone or are bent at an end; flat tops are told by `clipping_findings`."""
    seen = list(places(record))
    for name, kind in dict.fromkeys((p["channel"], p["kind"]) for p in seen):
        if kind not in WORDS:
            continue
        here = [p for p in seen if (p["channel"], p["kind"]) == (name, kind)]
        n = sum(p["samples"] for p in here)
        level: Level = "warning" if n > FEW * len(record) or kind == "ends" else "note"
        expected, words = WORDS[kind]
        yield Finding(
            kind, level, record.name, name, expected,
            _counted(n, len(record), words, here[0]["from"]),
            "check the cable, the converter, and what filters the data", record.source,
            joined([(record.t[0] + p["from"], record.t[0] + p["to"]) for p in here]),
        )  # fmt: skip


def _counted(n: int, size: int, words: str, first: float) -> str:
    """How many samples of a record of this size are so, and where the first of them is [s]."""
    if n == 1:
        return f"1 sample {words} at {first:.4g} s: it gets no weight"
    return f"{n} samples ({n / size:.2%}) {words}, the first at {first:.4g} s: they get no weight"


def outliers(records: tuple[Record, ...], beside: int = 0) -> dict[str, Any]:
    """What a result says of wild samples; beside: of the force, found by what a model leaves."""
    where = [p for r in records for p in places(r)]
    count = sum(p["samples"] for p in where) + beside
    by_record: dict[str, dict[str, int]] = {}
    for p in where:
        channels = by_record.setdefault(p["record"], {})
        channels[p["channel"]] = channels.get(p["channel"], 0) + p["samples"]
    total = sum(len(r) * sum(r.has(c) and c not in r.derived for c in JUDGED) for r in records)
    return {
        "count": count, "share": count / max(total, 1), "beside_model": beside, "by_record": by_record, "where": where,
    }  # fmt: skip
