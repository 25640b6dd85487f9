"""Tables that are stored cell by cell, as a command gives them out."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import partial
from typing import Any

from er_studies.given_out import Table, markdown

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
    """A run whose command gives out these tables first: as `tables` of its JSON, or as Markdown; "" is left out."""

    def keeps(written: Any) -> dict[str, Any]:
        tables = written["tables"] if isinstance(written, dict) else written
        return {each: made for each, made in zip(names, tables, strict=False) if each}

    run = Run(name, command, page, tuple(decides), keeps, writes)
    return {each: (run, partial(shown, each)) for each in names if each}


def shown(name: str, values: dict[str, Any]) -> str:
    """A table below its title."""
    return markdown(Table(**values[name]))
