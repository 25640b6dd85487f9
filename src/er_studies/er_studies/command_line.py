"""The command as it was typed."""

from __future__ import annotations

import shlex
import sys


def command_line() -> str:
    """The `./er study ...` that this process is, for whoever wants the same result again; empty where it is none."""
    program, *words = sys.argv
    return f"./{program} {shlex.join(words)}" if program.startswith("er study ") else ""
