"""What is stored of a run: its command, the code that made it, and what it wrote."""

from __future__ import annotations

import json
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from er_models.errors import InputError
from er_models.files import write_whole

from test.blind_score.rows import ROOT, digest

DATA = ROOT / "docs/results/data"


@dataclass(frozen=True)
class Run:
    """A documented run.

    name: of its file in `DATA`; command: as one types it, with `writes` added; page: in `docs/results`; decides:
    folders whose code makes other figures when it changes; keeps: what of the JSON is stored, all by default; writes:
    the option that makes the command write a file, `--table FILE` for Markdown, of which the tables are kept in order.
    """

    name: str
    command: str
    page: str
    decides: tuple[str, ...]
    keeps: Callable[[Any], Any] = lambda written: written
    writes: str = "--json FILE"

    @property
    def file(self) -> Path:
        """Where it is stored."""
        return DATA / f"{self.name}.json"

    @property
    def code(self) -> str:
        """Hash of the code as it is now."""
        return digest(folders=self.decides)

    def store(self, written: Path) -> None:
        """Keep what the command wrote, with the code that made it.

        Raises:
            InputError: no JSON.
        """
        try:
            text = written.read_text(encoding="utf-8")
            values = json.loads(text) if "json" in self.writes else read_tables(text)
        except (OSError, ValueError) as error:
            raise InputError(written, "", f"what {self.command} wrote", str(error)) from error
        content = {"command": self.command, "code": self.code, "values": self.keeps(values)}
        write_whole(self.file, json.dumps(content, indent=1, sort_keys=True) + "\n")

    def stored(self) -> dict[str, Any]:
        """What is stored.

        Raises:
            InputError: nothing is.
        """
        if not self.file.is_file():
            raise InputError(self.file, "", f"the figures of ./er {self.command}", "no file")
        content: dict[str, Any] = json.loads(self.file.read_text(encoding="utf-8"))
        return content


def read_tables(text: str) -> list[dict[str, Any]]:
    """The tables of a Markdown text, each as its head and rows of cells.

    Raises:
        ValueError: there is none.
    """
    found: list[dict[str, Any]] = []
    lines = [*text.splitlines(), ""]
    for before, line in zip(["", *lines], lines, strict=False):
        cells = [cell.strip() for cell in line.strip().strip("|").split("|")]
        if not line.startswith("|"):
            continue
        if not before.startswith("|"):
            found.append({"head": cells, "rows": []})
        elif not set("".join(cells)) <= set("-:"):
            found[-1]["rows"].append(cells)
    if not found:
        raise ValueError("no table")
    return found


def marked(name: str) -> tuple[str, str]:
    """Where a table begins and ends in a page."""
    return f"<!-- table {name} -->\n", f"<!-- end of {name} -->\n"


def within(text: str, name: str) -> tuple[int, int]:
    """Where the table of a name stands in a page, its marks left out.

    Raises:
        InputError: the page holds no such marks.
    """
    first, last = marked(name)
    if text.count(first) != 1 or text.count(last) != 1:
        raise InputError("page", "", f"{first.strip()} and {last.strip()}, once each", name)
    return text.index(first) + len(first), text.index(last)
