"""``./er study`` knows its words, and says in one line what is wrong."""

from __future__ import annotations

import runpy
import sys
from importlib import import_module
from pathlib import Path

import pytest
from er_model_lab.cli.app import app as lab
from er_models.errors import ErError
from er_studies.command_line import command_line
from er_studies.programs import program_of, run
from er_studies.thesis.command import app as thesis
from typer.testing import CliRunner

from er_studies import study


@pytest.mark.parametrize("given", [[], ["-h"], ["--help"]])
def test_lists_its_studies(
    given: list[str], monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("sys.argv", ["study.py", *given])
    with pytest.raises(SystemExit) as stop:
        study.main()
    assert stop.value.code == 0
    shown = capsys.readouterr().out
    assert all(f"er study {name} " in shown for name in study.PARTS)


@pytest.mark.parametrize("name", study.PARTS)
def test_every_study_is_a_program_with_a_help(
    name: str, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("sys.argv", ["study.py", name, "--help"])
    monkeypatch.delitem(sys.modules, study.PARTS[name], raising=False)
    with pytest.raises(SystemExit) as stop:
        study.main()
    assert stop.value.code == 0
    assert f"usage: er study {name} " in capsys.readouterr().out.lower()


def test_refuses_another_name(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    monkeypatch.setattr("sys.argv", ["study.py", "observer"])
    with pytest.raises(SystemExit) as stop:
        study.main()
    assert stop.value.code == 2
    said = capsys.readouterr().err
    assert said == f"er study: expected one of {', '.join(study.PARTS)}, found 'observer'\n"


@pytest.mark.parametrize("name", ["thesis", "import"])
def test_what_the_lab_had_is_here(name: str) -> None:
    assert name in study.PARTS
    told = CliRunner().invoke(lab, [name, "--out", "x"], prog_name="./er lab")
    assert told.exit_code == 2
    assert told.output == f"./er lab: '{name}' is now './er study {name}' (./er lab --help)\n"


def test_the_command_line_is_kept_as_it_was_typed(monkeypatch: pytest.MonkeyPatch) -> None:
    typed: list[str] = []
    monkeypatch.setattr(runpy, "run_module", lambda *_, **__: typed.append(command_line()))
    monkeypatch.setattr("sys.argv", ["study.py", "thesis", "chapter2", "--report", "my page"])
    study.main()
    assert typed == ["./er study thesis chapter2 --report 'my page'"]
    monkeypatch.setattr("sys.argv", ["pytest", "thesis", "chapter2"])
    assert command_line() == ""


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["chapter1", "--seed", "-1"], "expected a whole number from 0 to 4294967295, found -1"),
        (["chapter1", "--seed", "4294967296"], "from 0 to 4294967295, found 4294967296"),
        (["chapter1", "--seed", "1.5"], "from 0 to 4294967295, found 1.5"),
        (["chapter9"], "er study thesis: invalid value for 'chapter': "),
    ],
)
def test_wrong_usage_is_one_line(words: list[str], said: str) -> None:
    told = CliRunner().invoke(thesis, words, prog_name="er study thesis")
    assert (told.exit_code, told.stdout) == (2, "")
    assert said in told.stderr
    assert told.stderr.count("\n") == 1


@pytest.mark.parametrize(
    ("name", "words", "said"),
    [
        ("variants", "--model {m} --json {m}", "another place than --model"),
        ("observers", "--model {m} --csv {m}", "another place than --model"),
        ("observers", "--json both --csv both", "another place than --json"),
        ("figures", "--out {m} --format gif", "svg, png"),
    ],
)
def test_nothing_is_sought_that_cannot_be_written_afterwards(
    name: str, words: str, said: str, car_file: Path, tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str],
) -> None:  # fmt: skip
    model = tmp_path / "car.yaml"
    model.write_bytes(car_file.read_bytes())
    before = model.read_bytes()
    monkeypatch.setattr("sys.argv", [f"er study {name}", *words.format(m=model).split()])
    with pytest.raises(SystemExit) as ending:
        run(import_module(study.PARTS[name]).app)
    assert ending.value.code == 2
    told = capsys.readouterr().err
    assert told.startswith(f"er study {name}: ")
    assert told.count("\n") == 1
    assert said in told
    assert model.read_bytes() == before


def test_an_error_of_the_user_ends_with_its_status(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
) -> None:
    def broken() -> None:
        raise ErError("no such thing")

    monkeypatch.setattr("sys.argv", ["er study broken"])
    with pytest.raises(SystemExit) as ending:
        run(program_of(broken))
    assert ending.value.code == ErError.exit_status
    assert capsys.readouterr().err == "er study broken: no such thing\n"
