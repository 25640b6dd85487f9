"""The command as it was typed."""

from __future__ import annotations

import shlex
import sys
from pathlib import Path

PROGRAM = ("er_studies", "study.py")
"""Folder and file that `./er study` starts."""


def command_line() -> str:
    """The `./er study ...` that this process is, for whoever wants the same result again; empty where it is none."""
    typed = Path(sys.argv[0]).parts[-2:] == PROGRAM
    return shlex.join(["./er", "study", *sys.argv[1:]]) if typed else ""
