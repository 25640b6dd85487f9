"""How long the loop takes: from a sample to the command that answers it, and how late ticks are. No clock.

Times are counted in bins, so that hours cost no memory.
"""

from __future__ import annotations

from array import array
from dataclasses import dataclass, field

BIN = 2e-5
"""Width of a bin [s]."""
BINS = 10_000
RING = 512
"""Samples that may wait for their answer."""
WARM_UP = 1.0
"""Beginning of a run that does not count [s]."""


@dataclass(slots=True)
class Histogram:
    """Times [s] up to BIN * BINS; longer ones count as that."""

    counts: array[int] = field(default_factory=lambda: array("Q", bytes(8 * BINS)))
    total: int = 0
    longest: float = 0.0

    def add(self, seconds: float) -> None:
        """Count one time."""
        self.counts[min(int(max(seconds, 0.0) / BIN), BINS - 1)] += 1
        self.total += 1
        self.longest = max(self.longest, seconds)

    def percentile(self, percent: float) -> float:
        """Time that this many percent do not exceed, to a bin [s]; 0 without any."""
        wanted, seen = percent / 100.0 * self.total, 0
        for place, count in enumerate(self.counts):
            seen += count
            if count and seen >= wanted:
                return min((place + 1) * BIN, self.longest)
        return 0.0


@dataclass(slots=True)
class LoopTimes:
    """Samples and their answers; first: tick that counts first."""

    first: int
    latency: Histogram = field(default_factory=Histogram)
    lateness: Histogram = field(default_factory=Histogram)
    ticks: int = 0
    _when: array[float] = field(default_factory=lambda: array("d", bytes(8 * RING)))
    _seq: array[int] = field(default_factory=lambda: array("Q", bytes(8 * RING)))

    def sensed(self, seq: int, now: float, late: float) -> None:
        """A sample goes out at time now [s], this much after it was due [s]."""
        if seq < self.first:
            return
        self.ticks += 1
        self.lateness.add(late)
        self._seq[seq % RING], self._when[seq % RING] = seq, now

    def answered(self, seq: int, now: float) -> None:
        """A command arrives at time now [s]; only the first one to a sample counts."""
        place = seq % RING
        if seq and self._seq[place] == seq:
            self._seq[place] = 0
            self.latency.add(now - self._when[place])

    @property
    def unanswered(self) -> int:
        """Samples without an answer; the last one may still be waiting for its."""
        return max(self.ticks - self.latency.total - 1, 0)

    def words(self) -> str:
        """One line: percentiles in milliseconds, samples that were not answered."""
        return (
            f"loop ms {_figures(self.latency)}; lateness ms {_figures(self.lateness)}; "
            f"unanswered {self.unanswered} of {self.ticks}"
        )


def _figures(histogram: Histogram) -> str:
    each = (("p50", 50.0), ("p99", 99.0), ("p99.9", 99.9))
    words = [f"{name} {1e3 * histogram.percentile(p):.2f}" for name, p in each]
    return ", ".join([*words, f"max {1e3 * histogram.longest:.2f}"])
