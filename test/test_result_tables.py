"""Tables of the result pages are those of the figures that are stored; where other code made these, a test says so."""

import json
import re

import pytest
from er_models.errors import InputError

from test.conftest import ROOT
from test.result_tables.__main__ import main, written
from test.result_tables.given import given
from test.result_tables.stored import DATA, Run, within
from test.result_tables.tables import RUNS, TABLES


@pytest.mark.parametrize("name", TABLES)
def test_the_page_shows_what_is_stored(name):
    run, table = TABLES[name]
    text = (ROOT / "docs/results" / run.page).read_text(encoding="utf-8")
    i, j = within(text, name)
    assert text[i:j] == table(run.stored()["values"]), "./er exec python -m test.result_tables"


@pytest.mark.parametrize("name", RUNS)
def test_the_code_that_made_the_figures_is_the_code_that_is_here(name):
    run = RUNS[name]
    stored = run.stored()
    assert stored["command"] == run.command
    if stored["code"] != run.code:
        pytest.skip(f"docs/results/{run.page}: other code made its tables of `./er {run.command}`")


def test_tables_of_figures_are_made_not_typed():
    """A table is one of figures where most cells behind its first column begin with a digit."""
    for page in DATA.parent.glob("*.md"):
        text = page.read_text(encoding="utf-8")
        rest = re.sub(r"<!-- table (.+?) -->\n.*?<!-- end of \1 -->\n", "", text, flags=re.S)
        for lines in re.findall(r"(?:^\|.*\n)+", rest, re.M):
            cells = [c.strip(" *") for row in lines.splitlines()[2:] for c in row.split("|")[2:-1]]
            assert 2 * sum(cell[:1].isdigit() for cell in cells) <= len(cells), (
                f"{page.name}: {lines}"
            )


def test_the_fused_observer_is_not_behind():
    """What docs/observers.md claims: with the sensor never, and up to 20 um of its noise not behind those without."""
    values = RUNS["classes"].stored()["values"]
    for drive, errors in values.items():
        noise, place = drive.split(" um, ")
        rivals = errors if int(noise) > 20 else {**values[f"20 um, {place}"], **errors}
        least = min(error for name, error in rivals.items() if name != "fused")
        assert errors["fused"] < 1.05 * least, drive


def test_what_a_command_wrote_is_stored_with_its_code(tmp_path, monkeypatch):
    monkeypatch.setattr("test.result_tables.stored.DATA", tmp_path)
    run = Run("some", "study some", "some.md", ("src/er_common/er_common",))
    (tmp_path / "written.json").write_text('{"a": 1}')
    run.store(tmp_path / "written.json")
    assert run.stored() == {"command": "study some", "code": run.code, "values": {"a": 1}}
    (tmp_path / "written.json").write_text("none")
    with pytest.raises(InputError, match="what study some wrote"):
        run.store(tmp_path / "written.json")


def test_tables_of_a_page_are_stored_where_a_command_writes_no_json(tmp_path, monkeypatch):
    monkeypatch.setattr("test.result_tables.stored.DATA", tmp_path)
    run = Run("some", "some", "some.md", (), lambda tables: {"first": tables[0]}, "--table FILE")
    (tmp_path / "written.md").write_text(
        "# Title\n\n| a | b |\n|---|--:|\n| 1 | - |\n\n| c |\n|---|\n"
    )
    run.store(tmp_path / "written.md")
    assert run.stored()["values"] == {"first": {"head": ["a", "b"], "rows": [["1", "-"]]}}
    (tmp_path / "written.md").write_text("no table")
    with pytest.raises(InputError, match="what some wrote"):
        run.store(tmp_path / "written.md")


def test_tables_that_a_command_gives_out_are_stored_in_their_order(tmp_path, monkeypatch):
    monkeypatch.setattr("test.result_tables.stored.DATA", tmp_path)
    (run, first), (same, second) = given("some", "some", "some.md", (), "one", "two").values()
    tables = [{"head": [each], "rows": [[each.upper()]]} for each in "abc"]
    tables[1]["title"] = "seed 1"
    (tmp_path / "written.json").write_text(json.dumps({"seed": 1, "tables": tables}))
    run.store(tmp_path / "written.json")
    values = same.stored()["values"]
    assert {*values} == {"one", "two"}
    assert first(values) == "| a |\n| --- |\n| A |\n"
    assert second(values) == "seed 1\n\n| b |\n| --- |\n| B |\n"


def test_a_page_changed_by_hand_is_put_right(tmp_path):
    right = {}
    for page in {run.page for run, _ in TABLES.values()}:
        text = right[page] = (DATA.parent / page).read_text(encoding="utf-8")
        for name in (name for name, (run, _) in TABLES.items() if run.page == page):
            i, j = within(text, name)
            text = f"{text[:i]}by hand\n{text[j:]}"
        (tmp_path / page).write_text(text)
    written(tmp_path)
    for page, text in right.items():
        assert (tmp_path / page).read_text(encoding="utf-8") == text
    with pytest.raises(InputError, match="table nothing"):
        within("no table", "nothing")


def test_a_file_that_is_missing_is_one_line(capsys):
    assert main(["classes", "nowhere.json"]) == 2
    assert capsys.readouterr().err.count("\n") == 1
    assert json.loads(RUNS["classes"].file.read_text())["command"] == "study classes"
