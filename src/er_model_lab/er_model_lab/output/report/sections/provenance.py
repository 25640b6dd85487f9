"""Notes on the data, and everything needed to make this page again."""

from __future__ import annotations

import shlex
from collections.abc import Mapping
from typing import Any

from er_model_lab.output.report.section import Section
from er_model_lab.view import View


def section(view: View) -> Section | None:
    """Notes, files, digests, seed, versions, and the command; None when nothing is known."""
    facts = _flat(view.provenance)
    if not facts and not view.notes:
        return None
    notes = list(dict.fromkeys(view.notes))
    return Section(
        "provenance",
        "Provenance",
        facts={"notes": notes, "facts": facts, "command": command(view)},
    )


def command(view: View) -> str:
    """The command that makes this page: as recorded, else with DATA for the records listed."""
    known = view.provenance
    if known.get("command_line"):
        return str(known["command_line"])
    effects = [str(e) for e in view.result.get("effects") or ()] if view.command == "add" else []
    model = str(known.get("model_file", view.model))
    words = ["./er", "lab", view.command, *effects, "DATA", "--model", model]
    if view.command in ("add", "improve"):
        words += ["--out", "NEW.yaml"]
    if view.result.get("level"):
        words += ["--level", str(view.result["level"])]
    if known.get("seed") is not None:
        words += ["--seed", str(known["seed"])]
    return shlex.join([*words, "--report", "DIR"])


def _flat(known: Mapping[str, Any], prefix: str = "") -> list[tuple[str, str]]:
    """Names and values, nested names joined."""
    rows: list[tuple[str, str]] = []
    for key, value in known.items():
        name = f"{prefix}{str(key).replace('_', ' ')}"
        if isinstance(value, Mapping):
            rows += _flat(value, f"{name}: ")
        elif key != "command_line":
            text = (
                ", ".join(str(v) for v in value) if isinstance(value, list | tuple) else str(value)
            )
            rows.append((name, text))
    return rows
