"""Chapters of the thesis made again."""

from __future__ import annotations

from test.result_tables.given import Tables, given

MODELS, THESIS = "src/er_models/er_models", "src/er_studies/er_studies/thesis"
IDENTIFIES = ("src/er_records/er_records", "src/er_model_lab/er_model_lab")


def _chapter(number: int, code: tuple[str, ...], *tables: str) -> Tables:
    """A chapter whose figures other code decides, too."""
    named = (f"chapter {number}, {table}" for table in tables)
    command = f"study thesis chapter{number}"
    return given(f"chapter{number}", command, "thesis.md", (MODELS, THESIS, *code), *named)


TABLES: Tables = {
    **_chapter(1, IDENTIFIES, "roads", "ways", "static and dynamic"),
    **_chapter(2, (f"{MODELS}/forms",), "peaks", "departures", "zeros"),
    **_chapter(6, (f"{MODELS}/forms",), "mimics"),
}
