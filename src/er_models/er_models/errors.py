"""Errors that teach: each names the value, what was expected, and carries its exit status."""

from __future__ import annotations

from pathlib import Path
from typing import Any


class ErError(Exception):
    """Base of every error a user can cause; the message is one line."""

    exit_status = 2


class InputError(ErError):
    """Bad input: names the file, the key, what was expected and what was found, and what mends it."""

    def __init__(
        self, path: str | Path, key: str, expected: str, found: Any, cure: str = ""
    ) -> None:
        self.path, self.key, self.expected, self.found = str(path), key, expected, found
        self.cure = cure
        where = f"{path}: {key}" if key else str(path)
        super().__init__(f"{where}: expected {expected}, found {found}{cure and '; ' + cure}")


class UnknownName(ErError):
    """A name outside a catalogue; the message lists the closest allowed ones."""

    def __init__(self, kind: str, name: str, allowed: tuple[str, ...]) -> None:
        from difflib import get_close_matches

        self.name, self.allowed = name, allowed
        near = get_close_matches(name, allowed, n=3, cutoff=0.5)
        hint = f"did you mean {' or '.join(near)}?" if near else f"known: {', '.join(allowed)}"
        super().__init__(f"unknown {kind} '{name}'; {hint}")


class MissingChannel(ErError):
    """A channel the command needs is not in the data."""

    exit_status = 4

    def __init__(
        self,
        path: str | Path,
        channel: str,
        needed_for: str,
        present: tuple[str, ...],
        cure: str = "",
    ) -> None:
        there = ", ".join(present) or "none"
        said = f"{path}: channel '{channel}' is needed {needed_for}; present: {there}"
        super().__init__(said + (cure and "; " + cure))
