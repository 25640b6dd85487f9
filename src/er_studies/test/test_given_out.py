"""Figures of a study: arrays become lists, and what JSON does not know is refused, not written."""

import json

import numpy as np
import pytest
from er_models.files import write_json
from er_studies.given_out import say


def test_figures_and_tables_are_written(tmp_path, capsys):
    write_json(tmp_path / "figures.json", {"a": np.array([1.0, 2.0]), "b": ("x", 3)})
    assert json.loads((tmp_path / "figures.json").read_text()) == {"a": [1.0, 2.0], "b": ["x", 3]}
    say("| a wide table |" * 20, tmp_path / "table.md")
    assert capsys.readouterr().out == (tmp_path / "table.md").read_text()


def test_nothing_is_written_unasked_or_wrong(tmp_path):
    write_json(None, {"a": 1.0})
    with pytest.raises(ValueError, match="JSON"):
        write_json(tmp_path / "figures.json", {"a": float("inf")})
    assert list(tmp_path.iterdir()) == []
