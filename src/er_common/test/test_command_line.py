"""Results carry the command as it was typed, where one was."""

import sys
from pathlib import Path

import pytest
from er_common.command_line import by_er, command_line

APP = "/repository/src/er_model_lab/er_model_lab/cli/app.py"


@pytest.mark.parametrize("program", [APP, "/usr/bin/er-lab"])
def test_the_command_can_be_typed_again(program, monkeypatch):
    monkeypatch.setattr(sys, "argv", [program, "compare", "my run.csv", "--seed", "3"])
    assert command_line() == "./er lab compare 'my run.csv' --seed 3"
    assert by_er() == (program == APP)


def test_nothing_was_typed_where_another_program_asks(monkeypatch):
    monkeypatch.setattr(sys, "argv", [str(Path(sys.prefix) / "pytest/__main__.py"), "test"])
    assert command_line() == ""
    assert not by_er()
