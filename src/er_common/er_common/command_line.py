"""The command as it was typed."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path

PROGRAM = ("cli", "app.py")
"""Folder and file that `./er lab` starts."""


def by_er() -> bool:
    """Whether this process is an `./er lab`."""
    return Path(sys.argv[0]).parts[-2:] == PROGRAM


def command_line() -> str:
    """The command as it was typed, for whoever wants the same result again; empty where there was none."""
    typed = by_er() or Path(sys.argv[0]).name == "er-lab"
    words = sys.argv[1:] if typed else []
    return " ".join(["./er lab", *map(shlex.quote, words)]) if words else ""
