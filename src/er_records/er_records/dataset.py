"""What a question is asked of: records that a model learns from, and records that only score it."""

from __future__ import annotations

from collections.abc import Callable, Iterable
from dataclasses import dataclass, replace

from er_records.record import Record


@dataclass(frozen=True)
class Place:
    """A stretch of a record: which record of a data set, and its rows i to j."""

    record: int
    i: int
    j: int


@dataclass(frozen=True, eq=False)
class Dataset:
    """Records in their order; those that score come last.

    learn: records that models are fitted to; score: records that are never fitted to, often none: then the lab holds
    back a part of `learn`; whole: the data that these records are stretches of, None where they are whole; places:
    where each record lies there.
    """

    learn: tuple[Record, ...]
    score: tuple[Record, ...] = ()
    whole: Dataset | None = None
    places: tuple[Place, ...] = ()

    @classmethod
    def of(cls, learn: Iterable[Record], score: Iterable[Record] = ()) -> Dataset:
        """The data set of whole records."""
        return cls(tuple(learn), tuple(score))

    @property
    def records(self) -> tuple[Record, ...]:
        """All records, those to learn from first."""
        return (*self.learn, *self.score)

    @property
    def originals(self) -> tuple[Record, ...]:
        """All records as they were loaded, of which `records` may be stretches."""
        return (self.whole or self).records

    @property
    def numbers(self) -> tuple[int, ...]:
        """Which of `originals` each record is, be it in part."""
        return tuple(p.record for p in self.places) or tuple(range(len(self.records)))

    def with_records(self, records: Iterable[Record]) -> Dataset:
        """The same with other records in the place of each one."""
        found, n = tuple(records), len(self.learn)
        return replace(self, learn=found[:n], score=found[n:])

    def mapped(self, change: Callable[[Record], Record]) -> Dataset:
        """The same with every record changed, and the whole ones that they are stretches of."""
        whole = self.whole.mapped(change) if self.whole else None
        return replace(self.with_records(map(change, self.records)), whole=whole)
