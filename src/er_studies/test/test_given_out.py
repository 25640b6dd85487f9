"""Figures of a study: arrays become lists, and what JSON does not know is refused, not written."""

import json

import numpy as np
import pytest
from er_models.files import write_json
from er_studies.given_out import Table, give, say, seconds


def test_figures_and_tables_are_written(tmp_path, capsys):
    write_json(tmp_path / "figures.json", {"a": np.array([1.0, 2.0]), "b": ("x", 3)})
    assert json.loads((tmp_path / "figures.json").read_text()) == {"a": [1.0, 2.0], "b": ["x", 3]}
    say("| a wide table |" * 20, tmp_path / "table.md")
    assert capsys.readouterr().out == (tmp_path / "table.md").read_text()


def test_tables_are_printed_as_markdown_and_written_as_they_are(tmp_path, capsys):
    first, second = Table(("a", "b"), [("1", "-")]), Table(("c",), [("x",)], "2 drives")
    give([first, second], tmp_path / "tables.json", seed=3)
    written = json.loads((tmp_path / "tables.json").read_text())
    assert written["seed"] == 3
    assert written["tables"][1] == {"head": ["c"], "rows": [["x"]], "title": "2 drives"}
    told = "| a | b |\n| --- | --- |\n| 1 | - |\n\n2 drives\n\n| c |\n| --- |\n| x |\n\n"
    assert capsys.readouterr().out == told


def test_a_median_that_is_never_reached_is_said():
    assert seconds([1.0, 0.26, np.inf]) == "1.0"
    assert seconds([1.0, np.inf, np.inf]) == "never"


def test_nothing_is_written_unasked_or_wrong(tmp_path):
    write_json(None, {"a": 1.0})
    with pytest.raises(ValueError, match="JSON"):
        write_json(tmp_path / "figures.json", {"a": float("inf")})
    assert list(tmp_path.iterdir()) == []
