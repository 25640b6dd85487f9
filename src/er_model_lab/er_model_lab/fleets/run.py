"""A fleet under way: every recording, then every unit; what was found before is not done again."""

from __future__ import annotations

import sqlite3
import zlib
from base64 import b64decode, b64encode
from collections.abc import Callable, Iterator, Mapping, Sequence
from dataclasses import dataclass, field, replace
from itertools import accumulate
from typing import Any

from er_model_lab.fleets.asked import Asked
from er_model_lab.fleets.engine import Engine, Failure, spread
from er_model_lab.fleets.places import token
from er_model_lab.fleets.pooled import means
from er_model_lab.fleets.recording import RecordingJob, recording
from er_model_lab.fleets.source import Source
from er_model_lab.fleets.store import Store
from er_model_lab.fleets.unit import UnitJob, chosen, page, unit
from er_model_lab.work import Work

Row = dict[str, Any]
Span = tuple[float, float, str]
"""Begin and end of a recording [s], and its path."""


@dataclass
class Run:
    """A fleet under way.

    resume: whether what an earlier run found is taken; room: samples of which what a page shows is still kept, some 60
    bytes each; lost: why results could not be kept; reused: how many were.
    """

    store: Store
    asked: Asked
    engine: Engine
    work: Work
    resume: bool = False
    room: int = 0
    lost: str = ""
    reused: int = 0
    _done: int = field(default=0, repr=False)

    def recordings(self) -> None:
        """Look at every recording; each is in the store with its rows, or with what happened to it."""
        total = self.store.count("source")
        pending: dict[int, tuple[Source, str]] = {}

        def jobs() -> Iterator[tuple[int, RecordingJob]]:
            for number, source in self.store.sources():
                before, content = self.store.known(source.path) if self.resume else ("", "")
                rows = self.store.kept(self._key(source, content)) if content else None
                now = token(source.path)
                if rows is not None and now and now == before:
                    self.reused += 1
                    self._placed(number, source, rows, total)
                    continue
                pending[number] = source, now
                yield (
                    number,
                    RecordingJob(source.path, source.unit, content if rows is not None else ""),
                )

        def told(number: int, found: Any) -> None:
            source, now = pending.pop(number)
            self._placed(number, source, self._rows_of(source, now, found), total)

        self._spread(recording, jobs(), told)

    def units(self) -> None:
        """Diagnose every unit of which something can be used."""
        names = self.store.units()
        keys: dict[int, tuple[str, str, Row]] = {}

        def jobs() -> Iterator[tuple[int, UnitJob]]:
            for number, name in enumerate(names):
                job, facts = self._unit_job(name)
                if job is None or not self.asked.search:
                    self._entered(
                        name, _refitted(list(self.store.parts(name, "used"))), facts, len(names)
                    )
                    continue
                key = self.asked.key("unit", sorted(job.digests))
                row = self.store.kept(key) if self.resume else None
                if row is not None:
                    self.reused += 1
                    self._entered(name, row, facts, len(names))
                    continue
                keys[number] = name, key, facts
                self.room -= job.samples
                yield number, replace(job, keeps=self.room >= 0)

        def told(number: int, found: Any) -> None:
            name, key, facts = keys.pop(number)
            failed = isinstance(found, Failure)
            row, seen = ({"verdict": "failed", "error": found.said}, b"") if failed else found
            if seen:
                self.store.show(name, seen)
            if not isinstance(found, Failure) or found.kept:
                self._keep(key, row)
            self._entered(name, row, facts, len(names))

        self._done = 0
        self._spread(unit, jobs(), told)

    def pages(self, names: Sequence[str]) -> dict[str, bytes]:
        """Reports of these units, of those that can be diagnosed; each is kept like a result."""
        found: dict[str, bytes] = {}
        keys: dict[int, tuple[str, str]] = {}

        def jobs() -> Iterator[tuple[int, UnitJob]]:
            for number, name in enumerate(names):
                job, _ = self._unit_job(name)
                if job is None:
                    continue
                key = self.asked.key("page", sorted(job.digests))
                kept = self.store.kept(key) if self.resume else None
                if kept is not None:
                    found[name] = zlib.decompress(b64decode(kept))
                    continue
                keys[number] = name, key
                yield number, replace(job, seen=self.store.shown(name))

        def told(number: int, page: Any) -> None:
            name, key = keys.pop(number)
            if not isinstance(page, Failure):
                found[name] = page
                self._keep(key, b64encode(zlib.compress(page)).decode())

        self._spread(page, jobs(), told)
        return found

    def _spread(
        self,
        function: Callable[[Any, Asked], Any],
        jobs: Iterator[tuple[int, Any]],
        told: Callable[[int, Any], None],
    ) -> None:
        self.engine = spread(self.engine, function, jobs, self.asked, told, self.work.check)

    def _key(self, source: Source, content: str) -> str:
        """Name of what a recording gives: by its content, and by what its file is called, which names its records."""
        return self.asked.key("recording", [content, *source.path.rsplit("/", 2)[-2:]])

    def _rows_of(self, source: Source, now: str, found: Any) -> Sequence[Row]:
        """Rows of a recording that was looked at, kept where they would be the same again."""
        if isinstance(found, Failure):
            return [
                {
                    "record": "",
                    "status": "unreadable" if found.kept else "failed",
                    "error": found.said,
                }
            ]
        content, rows = found["content"], found["rows"]
        key = self._key(source, content)
        if rows is None:
            rows, self.reused = self.store.kept(key), self.reused + 1
        self._keep(key, rows, (source.path, now, content))
        return rows  # type: ignore[no-any-return]

    def _keep(self, key: str, row: Any, seen: tuple[str, str, str] | None = None) -> None:
        """Keep a result; where that fails the run goes on without."""
        try:
            self.store.keep(key, row, seen)
        except sqlite3.Error as error:
            self.lost = self.lost or str(error)

    def _placed(self, number: int, source: Source, rows: Sequence[Row], total: int) -> None:
        self.store.place(number, source, rows)
        self._done += 1
        self.work.report("recordings", self._done, total)

    def _entered(self, name: str, row: Mapping[str, Any], facts: Row, total: int) -> None:
        self.store.enter(name, {**row, **facts, "notes": [*row.get("notes", ()), *facts["notes"]]})
        self._done += 1
        self.work.report("units", self._done, total)

    def _unit_job(self, name: str) -> tuple[UnitJob | None, Row]:
        """What is to be done for a unit, and what is known of its recordings."""
        used, left_out = [], 0
        for part in self.store.parts(name):
            if part["status"] == "used":
                used.append(
                    {
                        k: part[k]
                        for k in ("path", "digest", "samples", "seconds", "time", "mileage")
                    }
                )
            else:
                left_out += 1
        taken = [used[k] for k in chosen([p["samples"] for p in used], self.asked.most)]
        facts = {
            "recordings": len(used), "left_out": left_out, "diagnosed_with": len(taken) if self.asked.search else 0,
            "seconds": sum(p["seconds"] for p in used), "notes": _overlaps(used),
        }  # fmt: skip
        for axis in ("time", "mileage"):
            known = [p[axis] for p in used if p[axis] is not None]
            facts |= {
                f"first_{axis}": min(known, default=None),
                f"last_{axis}": max(known, default=None),
            }
        job = UnitJob(
            name,
            tuple(dict.fromkeys(p["path"] for p in taken)),
            frozenset(p["digest"] for p in taken),
            sum(p["samples"] for p in taken),
        )
        return (job if taken else None), facts


def _overlaps(used: Sequence[Row]) -> list[str]:
    """A note where recordings of one unit were made at the same time: a clock is wrong, or they are of two units."""
    found: list[Span] = sorted(
        (p["time"], p["time"] + p["seconds"], p["path"]) for p in used if p["time"] is not None
    )
    longest = accumulate(found, _ends_later)
    both = [(a, b) for a, b in zip(longest, found[1:], strict=False) if b[0] < a[1] - 1e-6]
    if not both:
        return []
    (a, b), more = both[0], len(both) - 1
    others = f", and {more} more" if more else ""
    return [
        f"the times of {a[2]} and {b[2]} overlap{others}: a clock is wrong, or these are two units"
    ]


def _ends_later(a: Span, b: Span) -> Span:
    """That of two recordings which ends later."""
    return a if a[1] >= b[1] else b


def _refitted(parts: Sequence[Mapping[str, Any]]) -> Row:
    """The row of a unit whose effects are not searched for: means of what its recordings give."""
    import numpy as np

    if not parts:
        return {"verdict": "insufficient_data", "error": "no recording can be used"}
    values: dict[str, list[Any]] = {}
    for name in parts[0]["values"]:
        known = [v for p in parts if (v := p["values"].get(name)) and v[0] is not None and v[1]]
        if known:
            y, s = (np.array([v[k] for v in known], float) for k in (0, 1))
            mean, variance = means(np.zeros(y.size, np.intp), y, s**2, 1)
            values[name] = [float(mean[0]), float(variance[0]) ** 0.5, known[0][2]]
    square = {
        key: float(np.mean([p[key] ** 2 for p in parts])) ** 0.5
        for key in ("rmse", "rmse_refitted")
    }
    return {
        "verdict": "refitted", "rmse": square["rmse_refitted"], "rmse_as_given": square["rmse"],
        "nrmse": max(p["nrmse"] or 0.0 for p in parts), "values": values,
    }  # fmt: skip
