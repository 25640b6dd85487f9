"""What was found so far, in one SQLite file: written as it comes, by one process, and found again by its content.

Each result is a transaction, so that whatever kills the process leaves whole rows. `done` holds rows by the key of
`Asked.key`, `seen` the content of a path; both outlive a run. The tables of the present run are temporary: they need no
room on the disk of the results.
"""

from __future__ import annotations

import json
import sqlite3
from collections.abc import Iterable, Iterator, Mapping
from contextlib import contextmanager
from pathlib import Path
from typing import Any

from er_models.errors import InputError

from er_model_lab.fleets.source import Source

SCHEMA = """
PRAGMA locking_mode=EXCLUSIVE; PRAGMA journal_mode=WAL; PRAGMA synchronous=NORMAL;
CREATE TABLE IF NOT EXISTS done (key TEXT PRIMARY KEY, row TEXT) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS seen (path TEXT PRIMARY KEY, token TEXT, content TEXT) WITHOUT ROWID;
CREATE TEMP TABLE source (id INTEGER PRIMARY KEY, path TEXT UNIQUE, unit TEXT, time REAL, mileage REAL, more TEXT);
CREATE TEMP TABLE part (
  source INTEGER, record TEXT, unit TEXT, time REAL, mileage REAL, digest TEXT, status TEXT, samples INTEGER, row TEXT);
CREATE INDEX temp.part_source ON part (source); CREATE INDEX temp.part_digest ON part (digest);
CREATE INDEX temp.part_unit ON part (unit, mileage, time, source);
CREATE TEMP TABLE unit (unit TEXT PRIMARY KEY, row TEXT) WITHOUT ROWID;
"""
TOGETHER = 1000
"""Sources that are written in one transaction."""


class Store:
    """The results of a fleet; one process writes them."""

    def __init__(self, file: Path) -> None:
        """Open the file, or make it; `InputError` where that cannot be."""
        try:
            file.parent.mkdir(parents=True, exist_ok=True)
            self._db = sqlite3.connect(
                file, isolation_level=None, timeout=1.0, check_same_thread=False
            )
            self._db.executescript(SCHEMA)
        except (OSError, sqlite3.Error) as error:
            expected = "a file of results that no other run has open"
            raise InputError(file, "--resume", expected, str(error)) from None

    def close(self) -> None:
        """Close the file."""
        self._db.close()

    def add(self, found: Iterable[Source]) -> int:
        """Write down the recordings of this run; how many there are. A path that is named twice is one."""
        enter = "INSERT OR IGNORE INTO source (path, unit, time, mileage, more) VALUES (?,?,?,?,?)"
        rows = ((s.path, s.unit, s.time, s.mileage, json.dumps(dict(s.more))) for s in found)
        with self._whole():
            self._db.executemany(enter, rows)
        return self.count("source")

    @contextmanager
    def _whole(self) -> Iterator[None]:
        """A transaction: all of it is written, or nothing."""
        self._db.execute("BEGIN")
        try:
            yield
        except BaseException:
            if self._db.in_transaction:
                self._db.execute("ROLLBACK")
            raise
        self._db.execute("COMMIT")

    def count(self, table: str, where: str = "1") -> int:
        """Rows of a table."""
        return int(self._db.execute(f"SELECT count(*) FROM {table} WHERE {where}").fetchone()[0])

    def sources(self) -> Iterator[tuple[int, Source]]:
        """The recordings of this run with their numbers."""
        last = 0
        while True:
            rows = self._db.execute(
                "SELECT * FROM source WHERE id > ? ORDER BY id LIMIT ?", (last, TOGETHER)
            ).fetchall()
            for number, path, unit, time, mileage, more in rows:
                yield number, Source(path, unit, time, mileage, tuple(json.loads(more).items()))
            if not rows:
                return
            last = rows[-1][0]

    def known(self, path: str) -> tuple[str, str]:
        """Token and content of a path when it was last read; empty where it never was."""
        found = self._db.execute(
            "SELECT token, content FROM seen WHERE path = ?", (path,)
        ).fetchone()
        return ("", "") if found is None else (str(found[0]), str(found[1]))

    def kept(self, key: str) -> Any:
        """The result of a key; None where there is none."""
        found = self._db.execute("SELECT row FROM done WHERE key = ?", (key,)).fetchone()
        return None if found is None else json.loads(found[0])

    def keep(self, key: str, row: Any, seen: tuple[str, str, str] | None = None) -> None:
        """Keep a result; seen: path, token and content that it follows from.

        Raises:
            sqlite3.Error: It cannot be written, as on a full disk; nothing of it is there then.
        """
        with self._whole():
            self._db.execute("INSERT OR REPLACE INTO done VALUES (?, ?)", (key, json.dumps(row)))
            if seen is not None:
                self._db.execute("INSERT OR REPLACE INTO seen VALUES (?, ?, ?)", seen)

    def place(self, number: int, source: Source, rows: Iterable[Mapping[str, Any]]) -> None:
        """Enter the records of a recording into this run, each once, however often it is told."""
        with self._whole():
            self._db.execute("DELETE FROM part WHERE source = ?", (number,))
            for row in rows:
                digest, time = row.get("digest", ""), source.time
                copy = digest and self._db.execute(
                    "SELECT path FROM part JOIN source ON source = id WHERE digest = ? AND status != 'copy'", (digest,)
                ).fetchone()  # fmt: skip
                told = {**row, "error": f"the samples of {copy[0]}: used once"} if copy else row
                entry = (
                    number, row["record"], row.get("unit") or source.unit, row.get("start") if time is None else time,
                    source.mileage, digest, "copy" if copy else row["status"], row.get("samples", 0), json.dumps(told),
                )  # fmt: skip
                self._db.execute("INSERT INTO part VALUES (?,?,?,?,?,?,?,?,?)", entry)

    def units(self) -> list[str]:
        """Names of all units, also of those of which nothing can be used."""
        return [row[0] for row in self._db.execute("SELECT DISTINCT unit FROM part ORDER BY unit")]

    def parts(
        self, unit: str | None = None, status: str | None = None
    ) -> Iterator[dict[str, Any]]:
        """The records of one unit, or of all, in the order of mileage, time and naming."""
        wanted = {"part.unit": unit, "status": status}
        asked = {column: value for column, value in wanted.items() if value is not None}
        where = " AND ".join(f"{column} = ?" for column in asked) or "1"
        for row in self._db.execute(
            "SELECT path, record, part.unit, part.time, part.mileage, digest, status, more, row FROM part "
            f"JOIN source ON source = id WHERE {where} ORDER BY part.unit, part.mileage, part.time, source",
            tuple(asked.values()),
        ):
            path, record, own, time, mileage, digest, state, more, content = row
            yield json.loads(content) | {
                "path": path, "record": record, "unit": own, "time": time, "mileage": mileage, "digest": digest,
                "status": state, "more": json.loads(more),
            }  # fmt: skip

    def enter(self, unit: str, row: Mapping[str, Any]) -> None:
        """Enter the row of a unit into this run."""
        with self._whole():
            self._db.execute("INSERT OR REPLACE INTO unit VALUES (?, ?)", (unit, json.dumps(row)))

    def rows(self) -> Iterator[dict[str, Any]]:
        """The rows of all units, by name."""
        for unit, row in self._db.execute("SELECT unit, row FROM unit ORDER BY unit"):
            yield {"unit": unit, **json.loads(row)}
