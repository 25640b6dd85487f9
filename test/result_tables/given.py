"""Tables that are stored cell by cell, as a command gives them out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from er_studies.given_out import table

from test.result_tables.stored import Run

Tables = dict[str, tuple[Run, Callable[[Any], str]]]


def given(
    name: str,
    command: str,
    page: str,
    decides: Sequence[str],
    *names: str,
    writes: str = "--json FILE",
) -> Tables:
    """A run whose command writes these tables first: Markdown, or JSON with `tables` and perhaps a `machine`."""

    def keeps(written: Any) -> dict[str, Any]:
        found = written["tables"] if isinstance(written, dict) else written
        machine = {"machine": written["machine"]} if "machine" in written else {}
        return {**dict(zip(names, found, strict=False)), **machine}

    run = Run(name, command, page, tuple(decides), keeps, writes)
    return {each: (run, partial(shown, each, last=each == names[-1])) for each in names}


def shown(name: str, values: dict[str, Any], *, last: bool = True) -> str:
    """A table, and below the last one of a run the machine that it was measured on."""
    machine = f"\n{values['machine']}\n" if last and "machine" in values else ""
    return table(values[name]["head"], values[name]["rows"]) + machine
