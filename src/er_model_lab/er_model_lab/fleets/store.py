"""What was found so far, in one SQLite file: written as it comes, by one process, and found again by its content.

Each result is a transaction, so that whatever kills the process leaves whole rows. `done` holds rows by the key of
`Asked.key`, `seen` the content of a path; both outlive a run. The tables of the present run lie in a file of their own
among the temporary ones: they need no room on the disk of the results. Where that disk is full, they go on in memory.
"""

from __future__ import annotations

import json
import os
import sqlite3
import tempfile
from collections.abc import Iterable, Iterator, Mapping, Sequence
from contextlib import contextmanager, suppress
from itertools import islice
from pathlib import Path
from typing import Any

from er_models.errors import InputError

from er_model_lab.fleets.source import Source

SCHEMA = """
PRAGMA locking_mode=EXCLUSIVE; PRAGMA journal_mode=WAL; PRAGMA synchronous=NORMAL; PRAGMA temp_store=MEMORY;
CREATE TABLE IF NOT EXISTS done (key TEXT PRIMARY KEY, row TEXT) WITHOUT ROWID;
CREATE TABLE IF NOT EXISTS seen (path TEXT PRIMARY KEY, token TEXT, content TEXT) WITHOUT ROWID;
"""
RUN = """
PRAGMA {0}.journal_mode=MEMORY; PRAGMA {0}.synchronous=OFF;
CREATE TABLE {0}.source (id INTEGER PRIMARY KEY, path TEXT UNIQUE, unit TEXT, time REAL, mileage REAL, more TEXT);
CREATE TABLE {0}.part (
  id INTEGER PRIMARY KEY, source INTEGER, record TEXT, unit TEXT, time REAL, mileage REAL, digest TEXT, status TEXT,
  samples INTEGER, row TEXT);
CREATE INDEX {0}.part_source ON part (source); CREATE INDEX {0}.part_digest ON part (digest, source);
CREATE INDEX {0}.part_unit ON part (unit, mileage, time, source);
CREATE TABLE {0}.unit (unit TEXT PRIMARY KEY, row TEXT) WITHOUT ROWID;
CREATE TABLE {0}.shown (unit TEXT PRIMARY KEY, seen BLOB);
"""
"""Tables of a run in a database of this name."""
FIRST = """
SELECT path FROM part AS other JOIN source AS its ON its.id = other.source
WHERE part.status = 'used' AND part.digest != '' AND other.digest = part.digest AND other.status = 'used'
  AND (other.source, other.id) < (part.source, part.id)
ORDER BY other.source, other.id LIMIT 1
"""
"""Whose samples a record repeats: of those that can be used the one that was named first, whichever was read first."""
TOGETHER = 1000
"""Sources that are written in one transaction."""


class Store:
    """The results of a fleet; one process writes them.

    full: what the disk of temporary files said, once the run goes on in memory.
    """

    full = ""

    def __init__(self, file: Path) -> None:
        """Open the file, or make it; `InputError` where that cannot be."""
        try:
            file.parent.mkdir(parents=True, exist_ok=True)
            self._db = sqlite3.connect(
                file, isolation_level=None, timeout=1.0, check_same_thread=False
            )
            self._db.executescript(SCHEMA)
            self.file = file
        except (OSError, sqlite3.Error) as error:
            expected = "a file of results that no other run has open"
            raise InputError(file, "--resume", expected, str(error)) from None
        try:
            handle, name = tempfile.mkstemp(prefix="er_fleet_")
            os.close(handle)
            try:
                self._db.execute("ATTACH ? AS run", (name,))
                self._db.executescript(RUN.format("run"))
            finally:
                os.unlink(name)  # it is open: whatever ends this process, nothing is left
        except (OSError, sqlite3.Error) as error:
            self._into_memory(str(error))

    def close(self) -> None:
        """Close the file."""
        with suppress(sqlite3.Error):
            self._db.close()

    def add(self, found: Iterable[Source]) -> int:
        """Write down the recordings of this run; how many there are. A path that is named twice is one."""
        enter = "INSERT OR IGNORE INTO source (path, unit, time, mileage, more) VALUES (?,?,?,?,?)"
        rows = ((s.path, s.unit, s.time, s.mileage, json.dumps(dict(s.more))) for s in found)
        while together := list(islice(rows, TOGETHER)):
            self._write((enter, together))
        return self.count("source")

    @contextmanager
    def _whole(self) -> Iterator[None]:
        """A transaction: all of it is written, or nothing."""
        self._db.execute("BEGIN")
        try:
            yield
            self._db.execute("COMMIT")
        except BaseException:
            if self._db.in_transaction:
                self._db.execute("ROLLBACK")
            raise

    def _write(self, *commands: tuple[str, Sequence[Sequence[Any]]]) -> None:
        """Write into the tables of this run, all or nothing; in memory once their disk is full."""
        while True:
            try:
                with self._whole():
                    for command, rows in commands:
                        self._db.executemany(command, rows)
                return
            except sqlite3.Error as error:
                if self.full:
                    raise
                self._into_memory(str(error))

    def _into_memory(self, why: str) -> None:
        """Go on in memory with what the tables of this run hold."""
        self.full = why
        self._db.execute("ATTACH ':memory:' AS spare")
        self._db.executescript(RUN.format("spare"))
        if "run" not in [row[1] for row in self._db.execute("PRAGMA database_list")]:
            return
        with suppress(sqlite3.OperationalError):  # at the very beginning there is no table
            for table in ("source", "part", "unit"):
                self._db.execute(f"INSERT INTO spare.{table} SELECT * FROM run.{table}")
        self._db.execute("DETACH run")

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
        columns = "source, record, unit, time, mileage, digest, status, samples, row"
        enter = f"INSERT INTO part ({columns}) VALUES (?,?,?,?,?,?,?,?,?)"
        entries = [
            (
                number, row["record"], row.get("unit") or source.unit,
                row.get("start") if source.time is None else source.time, source.mileage, row.get("digest", ""),
                row["status"], row.get("samples", 0), json.dumps(row),
            )
            for row in rows
        ]  # fmt: skip
        self._write(("DELETE FROM part WHERE source = ?", [(number,)]), (enter, entries))

    def units(self) -> list[str]:
        """Names of all units, also of those of which nothing can be used."""
        return [row[0] for row in self._db.execute("SELECT DISTINCT unit FROM part ORDER BY unit")]

    def parts(
        self, unit: str | None = None, status: str | None = None
    ) -> Iterator[dict[str, Any]]:
        """The records of one unit, or of all, in the order of mileage, time and naming.

        A record whose samples another one holds too, which was named before it, is a `copy`.
        """
        wanted = {"part.unit": unit, "part.status": "used" if status == "copy" else status}
        asked = {column: value for column, value in wanted.items() if value is not None}
        where = " AND ".join(f"{column} = ?" for column in asked) or "1"
        for row in self._db.execute(
            "SELECT path, record, part.unit, part.time, part.mileage, digest, status, more, row, "
            f"({FIRST}) FROM part JOIN source ON source = source.id WHERE {where} "
            "ORDER BY part.unit, part.mileage, part.time, source",
            tuple(asked.values()),
        ):
            path, record, own, time, mileage, digest, state, more, content, first = row
            state = state if first is None else "copy"
            if status not in (None, state):
                continue
            yield json.loads(content) | {
                "path": path, "record": record, "unit": own, "time": time, "mileage": mileage, "digest": digest,
                "status": state, "more": json.loads(more),
            } | ({} if first is None else {"error": f"the samples of {first}: used once"})  # fmt: skip

    def enter(self, unit: str, row: Mapping[str, Any]) -> None:
        """Enter the row of a unit into this run."""
        self._write(("INSERT OR REPLACE INTO unit VALUES (?, ?)", [(unit, json.dumps(row))]))

    def show(self, unit: str, seen: bytes) -> None:
        """Keep for this run what a page of a unit shows, while its disk has room."""
        if not self.full:
            with suppress(sqlite3.Error), self._whole():
                self._db.execute("INSERT OR REPLACE INTO shown VALUES (?, ?)", (unit, seen))

    def shown(self, unit: str) -> bytes:
        """What a page of a unit shows; b"" where it was not kept."""
        found = self._db.execute("SELECT seen FROM shown WHERE unit = ?", (unit,)).fetchone()
        return b"" if found is None else bytes(found[0])

    def rows(self) -> Iterator[dict[str, Any]]:
        """The rows of all units, by name."""
        for unit, row in self._db.execute("SELECT unit, row FROM unit ORDER BY unit"):
            yield {"unit": unit, **json.loads(row)}
