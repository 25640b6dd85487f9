"""Where results of the lab go: places that can be written, and none of a recording that is read."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from importlib import import_module
from pathlib import Path

from er_common.extras import extra

from er_models import places

MEASURED = ("DATA", "--data", "--hold-out")
"""Arguments that name measurements: files, or folders of them."""


def writable(
    files: Mapping[str, Path | None], report: Path | None, read: Mapping[str, Sequence[Path]]
) -> None:
    """As `er_models.places.writable`, whose arguments these are; measurements are all of their files.

    A report is refused as early where what draws it is not installed.
    """
    if report is not None:
        with extra("er_model_lab[plots]", "a report"):
            import_module("er_model_lab.output.report.page")
    places.writable(files, report, read, _opened)


def _opened(argument: str, path: Path) -> list[Path]:
    """A path, or the recordings under it with every file that reading them opens."""
    from er_records.load import files_of, recordings

    if argument not in MEASURED:
        return [path]
    if not path.exists():
        return []
    return [place for item in recordings(path) for place in (item, *files_of(item))]
