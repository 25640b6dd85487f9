"""The page of a fleet in a browser, opened as a file: every recording can be turned to and searched for."""

import base64
import gzip
import json
import re
from contextlib import suppress
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq
import pytest
from er_model_lab.fleets.overview import overview
from er_model_lab.fleets.tables import RECORDINGS
from er_model_lab.output.report.rows import CHUNK, write_rows
from er_model_lab.output.report.sections.fleet import recordings as section
from er_model_lab.results.fleet import FleetResult
from er_model_lab.results.fleet_view import fleet_view
from er_model_lab.results.values import clean
from er_model_lab.view import View

from test.fleet_truth import fleet

LAST = 2 * CHUNK + 7
EVIL = "</script><b>7"


def listed(folder: Path) -> FleetResult:
    """A small fleet whose table holds `LAST` recordings."""
    made = fleet(7, units=6, recordings=5)
    found = overview(made.units, made.recordings)
    rows: list[dict[str, Any]] = [
        {"unit": EVIL, "path": f"r/{k}.csv", "record": f"{k}", "status": "used", "mileage": 1000.0 * k, "time": 1e9 + k}
        for k in range(LAST)
    ]  # fmt: skip
    rows[-1] |= {"status": "unreadable", "error": "Torn file", "mileage": None, "time": None}
    columns = pa.schema([pa.field(name, kind) for name, kind, *_ in RECORDINGS])
    pq.write_table(pa.Table.from_pylist(rows, columns), folder / "f.parquet")
    more = {"command": "fleet", "failed": [], "notes": [], "tables": {"recordings": str(folder / "f.parquet")},
            "complete": True, "recordings": LAST}  # fmt: skip
    seen = fleet_view(made.units, found.units, found.content["differ"], lambda u: [], {})
    view = View("fleet", "m", "6 units", clean(found.content | more), (), fleet=seen)
    return FleetResult(view)


def test_files_beside_the_page_hold_every_recording(tmp_path):
    found = listed(tmp_path)
    found._list_recordings(tmp_path)
    shown = section(found.view)
    assert shown is not None
    table = json.loads(shown.facts["table"])
    rows: list[list[str]] = []
    for name in table["files"]:
        packed = re.fullmatch(rf'erRows\("{name}","(.*)"\);\n', (tmp_path / name).read_text())
        assert packed is not None
        rows += json.loads(gzip.decompress(base64.b64decode(packed[1])))
    assert (len(rows), table["count"], table["chunk"]) == (LAST, LAST, CHUNK)
    assert rows[0][:6] == [EVIL, "r/0.csv", "0", "used", "0", "2001-09-09 01:46:40"]
    assert rows[-1][3:] == ["unreadable", "", "", "-", "-", "-", "", "Torn file"]
    assert {len(row) for row in rows} == {len(table["head"])}


@pytest.mark.slow
def test_every_recording_is_turned_to_and_searched_for(tmp_path):
    from test.page_help import visited

    place = listed(tmp_path).report(tmp_path / "report")
    with visited(place.as_uri()) as page:
        from playwright.sync_api import expect

        table = page.locator("#recordings")
        where, body = table.locator("output"), table.locator("tbody tr")
        expect(where).to_have_text(f"1 to 50 of {LAST}")
        expect(body).to_have_count(50)
        assert body.first.locator("th, td").all_inner_texts()[:6] == [
            EVIL, "r/0.csv", "0", "used", "0", "2001-09-09 01:46:40",
        ]  # fmt: skip
        expect(table.get_by_role("button", name="back")).to_be_disabled()
        table.get_by_role("button", name="on").click()
        expect(where).to_have_text(f"51 to 100 of {LAST}")
        table.get_by_label("from row").fill(f"{CHUNK + 3}")
        table.get_by_label("from row").press("Enter")
        expect(body.first).to_contain_text(f"r/{CHUNK}.csv")
        table.locator("table").press("End")
        expect(where).to_have_text(f"{LAST - 6} to {LAST} of {LAST}")
        table.locator("table").press("ArrowLeft")
        expect(where).to_have_text(f"{LAST - 56} to {LAST - 7} of {LAST}")
        table.get_by_label("Find").fill("torn")
        expect(where).to_have_text("1 to 1 of 1")
        expect(body).to_contain_text(f"r/{LAST - 1}.csv")
        table.get_by_label("Find").fill("nowhere")
        expect(where).to_have_text("none")
        table.get_by_label("Find").fill("99.csv")  # of each hundred the last
        expect(where).to_have_text(f"1 to 50 of {LAST // 100}")
        units = page.locator("#units")
        expect(units.locator("output")).to_have_text("1 to 6 of 6")
        units.get_by_label("Find").fill("unit003")
        expect(units.locator("tbody tr")).to_have_count(1)


def test_a_shorter_table_leaves_no_rows_of_the_one_before(tmp_path):
    write_rows(tmp_path, "r", [["a"]] * (CHUNK + 1))
    (tmp_path / "r/other.js").write_text("mine")
    assert sorted(p.name for p in (tmp_path / "r").iterdir()) == ["0000.js", "0001.js", "other.js"]
    write_rows(tmp_path, "r", [["a"]])
    assert sorted(p.name for p in (tmp_path / "r").iterdir()) == ["0000.js", "other.js"]


@pytest.mark.slow
def test_rows_that_are_missing_are_said(tmp_path):
    from test.page_help import visited

    place = listed(tmp_path).report(tmp_path / "report")
    (place.parent / "recordings/0001.js").unlink()
    told = ""
    with suppress(AssertionError), visited(place.as_uri()) as page:  # the browser tells it, too
        from playwright.sync_api import expect

        table = page.locator("#recordings")
        expect(table.locator("output")).to_have_text(f"1 to 50 of {LAST}")
        table.get_by_label("from row").fill(f"{CHUNK + 3}")
        table.get_by_label("from row").press("Enter")
        expect(table.locator("output")).to_contain_text("cannot be read")
        told = table.locator("output").inner_text()
    assert told == "recordings/0001.js cannot be read"
