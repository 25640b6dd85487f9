"""`lab map` as a command: what it prints and writes, and the one line for what it cannot do."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
import yaml
from er_model_lab.cli.app import app
from er_model_lab.cli.mapping import _answers
from er_model_lab.output.terminal.mapping import BARS, WIDTH, sketch
from typer.testing import CliRunner

import er_model_lab as lab

N, DT = 1500, 0.004
T = DT * np.arange(N)
X = 25.0 * np.sin(2 * np.pi * T)
F = -2.0 * np.sign(np.cos(2 * np.pi * T)) - 0.1 * np.cos(2 * np.pi * T)
CURRENT = 1.6 * (T > 3.0)


def text(head: str, units: str, x: np.ndarray) -> str:
    """A table as German rigs write it."""
    table = np.column_stack([T, x, F, CURRENT]).tolist()
    rows = [";".join(f"{v:.6f}".replace(".", ",") for v in row) for row in table]
    return "\n".join([head, units, *rows]) + "\n"


def folder(tmp_path: Path) -> Path:
    """Two German files with a row of units, the force turned, the current as it is; one without a current."""
    first = text("Zeit;Kolbenweg;Kraft;Strom", "s;mm;kN;A", X)
    (tmp_path / "a.csv").write_text(first, encoding="utf-8")
    other = text("Zeit;Kolbenweg;Kraft;Temp", "s;mm;kN;K", 1.004 * X)
    (tmp_path / "b.csv").write_text(other, encoding="utf-8")
    return tmp_path


def run(*words: str) -> tuple[int, str, str]:
    """Exit status, output and errors of a command."""
    done = CliRunner().invoke(app, ["map", *words])
    return done.exit_code, done.stdout, done.stderr


def test_a_folder_is_mapped_and_read_from_then_on(tmp_path: Path) -> None:
    data = folder(tmp_path)
    result = tmp_path.parent / f"{tmp_path.name}.json"
    status, shown, _ = run(str(data), "--json", str(result))
    assert status == 0
    for part in (
        "Kolbenweg",
        "kN",
        "-25.1 to 25.1",
        "250",
        "damper_force",
        "mapping: ",
        "reads as 2 records, 12 s",
    ):
        assert part in shown
    names = yaml.safe_load((data / "names.yaml").read_text(encoding="utf-8"))
    assert names == {
        "t": "Zeit", "deflection": "Kolbenweg", "duty": {"from": "Strom", "full_scale": 1.6},
        "damper_force": {"from": "Kraft", "sign": -1}, "temperature": "Temp",
    }  # fmt: skip
    found = json.loads(result.read_text(encoding="utf-8"))
    assert found["names"] == names
    assert found["written"] == str(data / "names.yaml")
    assert {c["column"]: c["channel"] for c in found["columns"]}["Kraft"] == "damper_force"
    first = lab.load(data).records[0]
    np.testing.assert_allclose(first.channels["damper_force"], -1e3 * F, atol=1.0)
    assert lab.map(data).names == names


def test_answers_are_options_and_nothing_is_overwritten(tmp_path: Path) -> None:
    data = folder(tmp_path)
    assert (
        run(str(data), "--set", "duty={from: Strom, full_scale: 2}", "--set", "temperature=")[0]
        == 0
    )
    before = (data / "names.yaml").read_text(encoding="utf-8")
    assert "full_scale: 2" in before
    assert "Temp" not in before
    status, _, said = run(str(data))
    assert (status, said.count("\n")) == (2, 1)
    assert "--replace" in said
    assert (data / "names.yaml").read_text(encoding="utf-8") == before
    assert run(str(data), "--dry-run")[0] == 0
    assert (data / "names.yaml").read_text(encoding="utf-8") == before
    assert run(str(data), "--replace")[0] == 0
    assert "full_scale: 1.6" in (data / "names.yaml").read_text(encoding="utf-8")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (["--set", "Kraft"], "CHANNEL=COLUMN"),
        (["--set", "duty={from: Strom"], "{from: COLUMN"),
        (["--set", "damper_force=Last"], "found Zeit [s], Kolbenweg [mm]"),
        (["--set", "force=Kraft"], "did you mean damper_force"),
        (["--out", "a.csv"], "a.csv"),
    ],
)
def test_what_is_wrong_is_one_line(
    tmp_path: Path, words: list[str], said: str, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(folder(tmp_path))
    status, _, error = run(".", *words)
    assert (status, error.count("\n")) == (2, 1)
    assert said in error
    assert not (tmp_path / "names.yaml").exists()


def test_what_cannot_be_told_is_asked_for_by_its_option(tmp_path: Path) -> None:
    rng = np.random.default_rng(0)
    rows = [
        f"{t:.4f},{a:.4f},{b:.4f}" for t, (a, b) in zip(T, rng.normal(size=(N, 2)), strict=True)
    ]
    (tmp_path / "x.csv").write_text("\n".join(["Zeit,p1,p2", *rows]) + "\n")
    status, _, said = run(str(tmp_path))
    assert status == 2
    assert '--set deflection="COLUMN [unit]"' in said
    assert not (tmp_path / "names.yaml").exists()


def test_a_terminal_is_asked(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    answers = iter(["Zeit [s]", "2", "-", "-", "Kraft [kN]"])
    monkeypatch.setattr("typer.prompt", lambda *_, **__: next(answers))
    assert _answers(lab.map(folder(tmp_path))) == {
        "t": "Zeit [s]", "deflection": "Kolbenweg [mm]", "deflection_velocity": None, "duty": None,
        "damper_force": "Kraft [kN]",
    }  # fmt: skip


def test_a_sketch_shows_a_few_periods() -> None:
    drawn = sketch(np.sin(2 * np.pi * T))
    assert len(drawn) == WIDTH
    assert {BARS[0], BARS[-1]} <= set(drawn) <= set(BARS)
    assert set(sketch(np.zeros(9))) == {"─"}


def test_answers_at_a_terminal_are_names_numbers_and_units(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    x = 30.0 * np.sin(2 * np.pi * T)
    path = tmp_path / "run.csv"
    table = np.column_stack([T, x, np.gradient(x, T), np.sign(np.gradient(x, T))])
    np.savetxt(path, table, delimiter=",", header="q1,dist,q2,Kraft", comments="")
    answers, offered = iter(["1", "2 [mm]", "-", "-", "Kraft"]), list[str]()

    def prompt(asked: str, default: str) -> str:
        offered.append(default)
        return next(answers)

    monkeypatch.setattr("typer.prompt", prompt)
    given = _answers(lab.map(path))
    assert given == {
        "t": "q1", "deflection": "dist [mm]", "deflection_velocity": None, "duty": None, "damper_force": "Kraft"
    }  # fmt: skip
    assert offered == ["q1", "dist [mm]", "q2 [mm/s]", "-", "Kraft"]
    assert lab.map(path, given).names["deflection"] == {"from": "dist", "unit": "mm"}
