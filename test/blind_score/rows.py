"""The results file: one JSON line a case, written as soon as it is known, so that a run can go on later.

A row belongs to the code that made it. The digest covers the statements of everything that decides (models,
lab, generator), without comments and docstrings, and no commit: a change of words keeps the rows.
"""

from __future__ import annotations

import ast
import hashlib
import json
from collections.abc import Iterator, Sequence
from functools import cache
from pathlib import Path
from typing import Any

from er_models.errors import InputError

ROOT = Path(__file__).resolve().parents[2]
DECIDES = ("src/er_models/er_models", "src/er_model_lab/er_model_lab", "test/blind")
# fmt: off
SAYS = frozenset((
    "card", "cards", "cli", "forms", "identify", "nodes", "plan", "recording", "report", "terminal",
    "versions", "view", "wording", "write",
))
# fmt: on
"""Folders and files there that only report, or do another task."""


@cache
def _bare(source: str) -> str:
    """Source without comments and docstrings, written as one Python version writes it like another."""
    tree = ast.parse(source)
    for node in ast.walk(tree):
        body = getattr(node, "body", None)
        if isinstance(body, list):
            texts = (ast.Expr, ast.Constant)
            kept = [
                n for n in body if not (isinstance(n, texts[0]) and isinstance(n.value, texts[1]))
            ]
            node.body = kept  # type: ignore[attr-defined]
    return ast.unparse(tree)


def deciding(root: Path = ROOT, folders: Sequence[str] = DECIDES) -> list[Path]:
    """Files of the code that decides a row, tests left out."""
    found = []
    for folder in folders:
        for path in sorted((root / folder).rglob("*.py")):
            parts = path.relative_to(root / folder).with_suffix("").parts
            if SAYS.isdisjoint(parts) and not parts[-1].startswith(("test_", "short", "conftest")):
                found.append(path)
    return found


def digest(root: Path = ROOT, folders: Sequence[str] = DECIDES) -> str:
    """Hash of the code that decides a row."""
    total = hashlib.sha256()
    for path in deciding(root, folders):
        total.update(path.relative_to(root).as_posix().encode())
        total.update(_bare(path.read_text(encoding="utf-8")).encode())
    return total.hexdigest()[:16]


def read(path: Path) -> Iterator[dict[str, Any]]:
    """Rows of a results file, none where there is no file; a last line cut short is left out.

    Raises:
        InputError: a line that is no row.
    """
    if not path.exists():
        return
    lines = path.read_text(encoding="utf-8").splitlines(keepends=True)
    for number, line in enumerate(lines, 1):
        if number == len(lines) and not line.endswith("\n"):
            return
        try:
            row = json.loads(line)
        except json.JSONDecodeError as error:
            raise InputError(path, f"line {number}", "a row in JSON", line[:40]) from error
        if not isinstance(row, dict) or "key" not in row:
            raise InputError(path, f"line {number}", "a row with a key", line[:40])
        yield row


def append(path: Path, row: dict[str, Any]) -> None:
    """Write one row at the end; a line that an interrupted run left unfinished is cut off first."""
    path.parent.mkdir(parents=True, exist_ok=True)
    old = path.read_bytes() if path.exists() else b""
    if old and not old.endswith(b"\n"):
        path.write_bytes(old[: old.rfind(b"\n") + 1])
    with path.open("a", encoding="utf-8") as file:
        file.write(json.dumps(row) + "\n")
