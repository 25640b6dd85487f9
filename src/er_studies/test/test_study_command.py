"""``./er study`` knows its words, and says in one line what is wrong."""

from __future__ import annotations

import pytest
from er_model_lab.cli.app import app as lab
from er_studies.command_line import command_line
from typer.testing import CliRunner

from er_studies import study


@pytest.mark.parametrize("name", ["thesis", "import"])
def test_what_the_lab_had_is_there(name: str) -> None:
    assert CliRunner().invoke(study.app, [name, "--help"]).exit_code == 0
    told = CliRunner().invoke(lab, [name, "--out", "x"], prog_name="./er lab")
    assert told.exit_code == 2
    assert told.output == f"./er lab: '{name}' is now './er study {name}' (./er lab --help)\n"


def test_the_command_line_is_kept_as_it_was_typed(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr("sys.argv", [study.__file__, "thesis", "chapter2", "--report", "my page"])
    assert command_line() == "./er study thesis chapter2 --report 'my page'"
    monkeypatch.setattr("sys.argv", ["pytest", "thesis", "chapter2"])
    assert command_line() == ""


@pytest.mark.parametrize("found", ["-1", "4294967296", "abc", "1.5"])
def test_a_seed_that_is_none_is_named(found: str) -> None:
    told = CliRunner().invoke(study.app, ["thesis", "chapter1", "--seed", found])
    assert told.exit_code == 2
    assert f"expected a whole number from 0 to 4294967295, found {found}" in told.output


def test_a_chapter_that_is_none_is_named() -> None:
    told = CliRunner().invoke(study.app, ["thesis", "chapter9"], prog_name="study")
    assert told.exit_code == 2
    assert told.output.startswith("study thesis: invalid value for 'chapter': ")
    assert told.output.count("\n") == 1
