"""Spreadsheets: the sheet that holds the measurement, whatever stands above it, and books that hold none."""

from __future__ import annotations

from datetime import datetime, time, timedelta
from pathlib import Path
from typing import Any
from zipfile import ZipFile

import numpy as np
import pytest

pytest.importorskip("python_calamine")
from er_models.errors import InputError
from er_records.load import load
from er_records.mapping.mapping import mapped
from er_records.readers import sheet
from er_records.readers.sheet import _text

N, DT = 600, 0.005
T = DT * np.arange(N)
X = 5e-3 * np.sin(2 * np.pi * 2.0 * T)
F = 60.0 * np.gradient(X, DT)
NAME = "http://schemas.openxmlformats.org"
RUNS = Path(__file__).parents[4] / "shared/data/mr_damper_shaking_table/Ensaios.ods"


def book(path: Path, sheets: dict[str, list[list[Any]]]) -> Path:
    """The least that Excel opens: text in the cells themselves."""

    def cell(value: Any) -> str:
        if isinstance(value, str):
            return f'<c t="inlineStr"><is><t>{value}</t></is></c>'
        return f"<c><v>{value}</v></c>" if value is not None else "<c/>"

    kinds = (
        f'<Types xmlns="{NAME}/package/2006/content-types"><Default Extension="rels" ContentType='
    )
    kinds += (
        '"application/vnd.openxmlformats-package.relationships+xml"/><Default Extension="xml" '
    )
    kinds += 'ContentType="application/xml"/></Types>'
    links = f'<Relationships xmlns="{NAME}/package/2006/relationships">'
    office = f"{NAME}/officeDocument/2006/relationships"
    own, inside = "", ""
    with ZipFile(path, "w") as file:
        for k, (name, rows) in enumerate(sheets.items(), start=1):
            body = "".join(f"<row>{''.join(map(cell, row))}</row>" for row in rows)
            main = f'<worksheet xmlns="{NAME}/spreadsheetml/2006/main"><sheetData>{body}</sheetData></worksheet>'
            file.writestr(f"xl/worksheets/sheet{k}.xml", main)
            own += f'<sheet name="{name}" sheetId="{k}" r:id="rId{k}"/>'
            inside += f'<Relationship Id="rId{k}" Type="{office}/worksheet" Target="worksheets/sheet{k}.xml"/>'
        file.writestr("[Content_Types].xml", kinds)
        first = (
            f'<Relationship Id="rId1" Type="{office}/officeDocument" Target="xl/workbook.xml"/>'
        )
        file.writestr("_rels/.rels", f"{links}{first}</Relationships>")
        file.writestr("xl/_rels/workbook.xml.rels", f"{links}{inside}</Relationships>")
        start = f'<workbook xmlns="{NAME}/spreadsheetml/2006/main" xmlns:r="{office}">'
        file.writestr("xl/workbook.xml", f"{start}<sheets>{own}</sheets></workbook>")
    return path


def measured() -> list[list[Any]]:
    """A measurement as a rig's program exports it: a head, names, units, numbers."""
    head: list[list[Any]] = [
        ["Prüfstand 3"],
        ["Dämpfer", "vorn links"],
        ["Zeit", "Weg", "Kraft"],
        ["s", "mm", "kN"],
    ]
    return head + [[t, 1e3 * x, -1e-3 * f] for t, x, f in zip(T, X, F, strict=True)]


def test_the_sheet_with_the_measurement_is_read(tmp_path: Path) -> None:
    info: list[list[Any]] = [["Datum", "2025-11-14"], ["Temperatur", 28.0]]
    path = book(
        tmp_path / "run.xlsx",
        {"Info": info, "Daten": measured(), "Grenzen": [[1.0, 2.0], [3.0, 4.0]]},
    )
    found = mapped(path)
    assert {k: v for k, v in found.names.items() if k != "damper_force"} == {
        "t": "Zeit",
        "deflection": "Weg",
    }
    (record,) = load([path], found.names)
    np.testing.assert_allclose(record.t, T, atol=1e-12)
    np.testing.assert_allclose(record.channels["deflection"], X, atol=1e-12)
    np.testing.assert_allclose(record.channels["damper_force"], F, atol=1e-9)
    assert "sheet 'Daten' was read" in record.notes
    assert "sheets with numbers that were not: Grenzen" in record.notes


def test_a_list_of_runs_in_a_folder_is_no_measurement(tmp_path: Path) -> None:
    rows = zip(T, X, F, strict=True)
    text = "".join(f"{t},{x},{f}\n" for t, x, f in rows)
    (tmp_path / "run.csv").write_text(f"t,deflection,damper_force\n{text}", encoding="utf-8")
    book(
        tmp_path / "plan.xlsx",
        {"Runs": [["run", "Hz", "mm"], *([k, 2.0, 5.0] for k in range(40))]},
    )
    (tmp_path / "~$plan.xlsx").write_bytes(b"owner")
    assert [r.name for r in load([tmp_path])] == ["run"]
    with pytest.raises(InputError, match=r"plan\.xlsx.*found run, Hz, mm"):
        load([tmp_path / "plan.xlsx"])


@pytest.mark.skipif(not RUNS.exists(), reason=f"{RUNS.name} of the shared data is not here")
def test_a_real_list_of_runs_is_none_either(tmp_path: Path) -> None:
    (tmp_path / RUNS.name).write_bytes(RUNS.read_bytes())
    with pytest.raises(InputError, match=r"found Ensaios\.ods \(no measurement\)$"):
        load([tmp_path])


@pytest.mark.parametrize("content", [b"no book", b"PK\x03\x04"])
def test_a_damaged_book_is_one_line(tmp_path: Path, content: bytes) -> None:
    for path in (tmp_path / "run.xlsx", tmp_path / "run.ods"):
        path.write_bytes(content)
        with pytest.raises(InputError, match=f"{path.name}: expected a spreadsheet") as caught:
            load([path])
        assert "\n" not in str(caught.value)
    book(tmp_path / "empty.xlsx", {"Tabelle1": []})
    with pytest.raises(InputError, match="a sheet with rows of numbers, found none in Tabelle1"):
        load([tmp_path / "empty.xlsx"])


def test_a_book_that_unpacks_to_too_much_is_not_opened(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    path = book(tmp_path / "run.xlsx", {"Daten": measured()})
    monkeypatch.setattr(sheet, "LARGEST", 10_000)
    with pytest.raises(InputError, match="a spreadsheet of at most"):
        load([path])


def test_times_are_written_as_a_text_table_has_them() -> None:
    assert _text(datetime(2025, 11, 14, 20, 14, 37, 917152)) == "2025-11-14 20:14:37.917152"
    assert _text(time(20, 14, 37)) == "20:14:37"
    assert _text(timedelta(minutes=3, seconds=0.5)) == "00:03:00.500000"
    assert _text(0.1) == "0.1"
    assert _text("a\tb") == "a b"
