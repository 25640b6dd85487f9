"""The command: writes gains, shows the certificate, fails in one line."""

from __future__ import annotations

import sys
from pathlib import Path

import pytest
from er_models.model import Model
from er_observers.running.ready import ready
from er_observers.synth import app
from typer.testing import CliRunner

from er_observers import synth


def test_writes_gains_that_load(
    car: Model, car_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """The table names what was shown; the file is whole."""
    out = tmp_path / "gains.yaml"
    result = CliRunner().invoke(
        app, ["nlpv_polytopic", "--model", str(car_file), "--out", str(out)]
    )
    assert result.exit_code == 0, result.output
    for word in ("gamma", "sweep", "margin", "poles", "decay"):
        assert word in result.output
    assert ready(out, car, "nlpv_polytopic").figures["slowest"] < -0.5
    monkeypatch.setattr(synth, "SCENARIOS", synth.SCENARIOS[:1])
    shown = CliRunner().invoke(app, ["evaluate", "--model", str(car_file), "--gains", str(out)])
    assert shown.exit_code == 0, shown.output
    assert "NRMSE" in shown.output


def test_errors_are_one_line_and_nothing_is_overwritten(
    car_file: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """A damper is no vehicle; too small a disc has no solution."""
    out = tmp_path / "gains.yaml"
    out.write_text("precious", encoding="utf-8")
    damper = car_file.parent.parent / "dampers" / "inove_guo.yaml"
    cases: tuple[tuple[Path, list[str], int, str], ...] = (
        (damper, [], 2, "quarter_car"),
        (car_file.parent / "none.yaml", [], 2, "no file"),
        (car_file, ["--radius", "12"], 1, "solver"),
        (car_file, ["--sector", "circle"], 2, "slope, lipschitz"),
        (car_file, ["--duty", "1", "0"], 2, "duty: expected 0 to 1, the lower first"),
        (car_file, ["--noise", "0", "1"], 2, "numbers above 0"),
        (car_file, ["--damping", "1.5"], 2, "damping"),
    )
    for model, extra, status, word in cases:
        command = ["synth", "nlpv_polytopic", "--model", str(model), "--out", str(out), *extra]
        monkeypatch.setattr(sys, "argv", command)
        with pytest.raises(SystemExit) as ending:
            synth.main()
        assert ending.value.code == status
        text = capsys.readouterr().err
        assert text.count("\n") == 1
        assert word in text
    assert out.read_text(encoding="utf-8") == "precious"


def test_a_model_is_not_overwritten_by_its_gains(
    car_file: Path,
    tmp_path: Path,
    monkeypatch: pytest.MonkeyPatch,
    capsys: pytest.CaptureFixture[str],
) -> None:
    """Neither are gains sought for minutes that cannot be written afterwards."""
    model = tmp_path / "car.yaml"
    model.write_bytes(car_file.read_bytes())
    before = model.read_bytes()
    link = tmp_path / "link.yaml"
    link.symlink_to(model)
    cases = (
        (["unified", "--model", str(model), "--out", str(link)], "another place than --model"),
        (["unified", "--model", str(model), "--out", str(tmp_path)], "a file name"),
        (["compare", "chapter_5_step"], "'compare' is now './er study observers'"),
        (["variants", "--model", str(model)], "'variants' is now './er study variants'"),
        (["figures", "--out", str(tmp_path)], "'figures' is now './er study figures'"),
        (["fault_trials"], "'fault_trials' is now './er study fault_trials'"),
    )
    for command, word in cases:
        monkeypatch.setattr(sys, "argv", ["synth", *command])
        with pytest.raises(SystemExit) as ending:
            synth.main()
        assert ending.value.code == 2
        text = capsys.readouterr().err
        assert text.count("\n") == 1
        assert word in text
    assert model.read_bytes() == before
