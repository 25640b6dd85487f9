"""One thing that was checked: how it is, and what to do where it is wrong."""

from __future__ import annotations

from dataclasses import asdict, dataclass
from typing import Any, Literal

Level = Literal["ok", "note", "warning", "fail"]
ORDER: dict[str, int] = {"fail": 0, "warning": 1, "note": 2, "ok": 3}
"""Worst first."""


@dataclass(frozen=True)
class Finding:
    """A check of one record.

    check: channels, sampling, dropouts, held, clipping, spikes, ends, units, clock, bias, power, motion or size;
    channel: the one concerned, or empty; expected and found: as an error says them; remedy: what to do; a finding of
    level `fail` stops a command.
    """

    check: str
    level: Level
    record: str
    channel: str
    expected: str
    found: str
    remedy: str = ""
    source: str = ""

    def as_json(self) -> dict[str, Any]:
        """Plain data."""
        return {k: v for k, v in asdict(self).items() if k != "source"}
