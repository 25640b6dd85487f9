"""Programs of the build whose first line no kernel understands, and the first lines that every kernel does.

What makes the programs puts the path of their Python in quotes where it holds a space, and as it is where it is long;
the kernel knows no quotes and reads the beginning of the line only.
"""

from __future__ import annotations

import os
import re
from pathlib import Path

from er_workspace.layout import Layout

LONGEST = 127
"""Longest first line that every kernel reads to its end [bytes]."""


def unstartable(layout: Layout) -> list[Path]:
    """Installed programs that cannot be started by their name alone."""
    files = sorted(path for path in layout.install.glob("*/lib/*/*") if path.is_file())
    return [path for path in files if _puzzling(_first(path), os.fsencode(layout.python))]


def mend(layout: Layout) -> None:
    """Have the shell start what the kernel cannot, by lines that are a command to it and a text to Python."""
    python = re.sub(r'([\\"$`])', r"\\\1", str(layout.python))
    head = os.fsencode(f"#!/bin/sh\n'''exec' \"{python}\" \"$0\" \"$@\"\n' '''\n")
    for path in unstartable(layout):
        path.write_bytes(head + path.read_bytes().partition(b"\n")[2])


def _first(path: Path) -> bytes:
    """First line of a file."""
    with path.open("rb") as source:
        return source.readline().rstrip()


def _puzzling(first: bytes, python: bytes) -> bool:
    """Whether a first line names this Python in a way that the kernel does not understand."""
    if first.startswith(b'#!"'):
        return True
    split = len(python.split()) > 1
    return first.startswith(b"#!" + python) and (split or len(first) > LONGEST)
