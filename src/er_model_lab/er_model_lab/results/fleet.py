"""What `fleet` returns."""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any

from er_models.errors import ErError, InputError
from er_records.write import finished_only

from er_model_lab.results.result import Result


@dataclass(frozen=True, repr=False)
class FleetResult(Result):
    """What a fleet shows. `table` and `recordings_table` are the files with one row a unit, and one a recording.

    pages: reports of the strangest units by their place in a report; errors: what ended the run early, and tables that
    could not be written.
    """

    pages: Mapping[str, bytes] = field(default_factory=dict)
    errors: tuple[ErError, ...] = ()

    def report(self, folder: str | Path) -> Path:
        """Write the page, and beside it a page for each unit that was drawn and all recordings; returns the page.

        Raises:
            InputError: The folder cannot be written.
            ErError: A package that draws is not installed.
        """
        page = super().report(folder)
        try:
            for name, content in self.pages.items():
                with finished_only(page.parent / name) as part:
                    part.write_bytes(content)
            if "recordings" in self.view.result["tables"]:
                self._list_recordings(page.parent)
        except OSError as error:
            place, said = error.filename or page.parent, error.strerror or str(error)
            raise InputError(place, "report", "a place that can be written", said) from None
        return page

    def _list_recordings(self, folder: Path) -> None:
        """Write what the page lists of the recordings."""
        import pyarrow.parquet as pq

        from er_model_lab.output.report.rows import CHUNK, write_rows
        from er_model_lab.output.report.sections.fleet import RECORDINGS, SHOWN, recording_row

        with pq.ParquetFile(self.recordings_table) as file:
            rows = (
                row
                for some in file.iter_batches(CHUNK, columns=[*SHOWN])
                for row in some.to_pylist()
            )
            write_rows(folder, RECORDINGS, map(recording_row, rows))

    @property
    def table(self) -> Path:
        """One row a unit (Parquet); KeyError where it could not be written."""
        return Path(self.view.result["tables"]["units"])

    @property
    def recordings_table(self) -> Path:
        """One row a recording (Parquet); KeyError where it could not be written."""
        return Path(self.view.result["tables"]["recordings"])

    @property
    def verdicts(self) -> Mapping[str, int]:
        """How many units have which verdict."""
        found: Mapping[str, int] = self.view.result["verdicts"]
        return found

    @property
    def differ(self) -> tuple[Mapping[str, Any], ...]:
        """Units that differ, the strangest first: unit, p, in what, and what changes."""
        return tuple(self.view.result["differ"])

    @property
    def parameters(self) -> Mapping[str, Mapping[str, Any]]:
        """Every parameter as `effect.name`: common mean, spread between units and within."""
        found: Mapping[str, Mapping[str, Any]] = self.view.result["parameters"]
        return found

    def _rows(self) -> Iterable[Mapping[str, Any]]:
        """The table of the units."""
        import pyarrow.parquet as pq

        rows: list[Mapping[str, Any]] = pq.read_table(self.table).to_pylist()
        return rows
