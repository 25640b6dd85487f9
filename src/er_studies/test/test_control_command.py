"""`er control`: tables, figures and the long ride, with the estimator in the loop; bad names are one line."""

from __future__ import annotations

from pathlib import Path

import pytest
from er_ftc_controller.synth import app as controller
from er_models.errors import ErError
from er_observers.synth import app as observers
from er_studies.control.command import app
from typer import Typer
from typer.testing import CliRunner


def done(*words: str) -> tuple[int, str]:
    result = CliRunner().invoke(app, list(words))
    if isinstance(result.exception, ErError):
        raise result.exception
    return result.exit_code, result.output


def test_a_leak_is_found_and_acted_on_without_being_told(tmp_path: Path) -> None:
    out = tmp_path / "table.md"
    status, text = done(
        "compare", "thesis_6_4_1", "--fault", "leakage", "--seeds", "1", "--out", str(out)
    )
    assert status == 0
    assert out.read_text().strip() == text.strip()
    cells = {
        line.split("|")[2].strip(): [c.strip() for c in line.split("|")[3:-1]]
        for line in text.splitlines()
        if line.startswith("| leakage |") and "%" not in line.split("|")[3]
    }
    assert list(cells) == [
        "passive", "skyhook", "nominal", "force_feedback", "faults_known", "fault_tolerant",
    ]  # fmt: skip
    ours, told, nominal = (cells[n] for n in ("fault_tolerant", "faults_known", "nominal"))
    assert float(ours[0]) < float(nominal[0])
    assert abs(float(ours[0]) - float(told[0])) < 0.03 * float(told[0])
    assert ours[4] == ours[6] == "0"


def test_it_stays_stable_with_faults_that_come_and_go() -> None:
    status, text = done("endurance", "--minutes", "1")
    assert status == 0
    assert ": stable" in text
    changes = int(text.split("changes of mode: ")[1].split(";")[0])
    assert changes >= 2


def test_figures_are_drawn(tmp_path: Path) -> None:
    status, _ = done("figures", str(tmp_path), "--faults", "known")
    assert status == 0
    found = sorted(p.name for p in tmp_path.iterdir())
    assert found == ["rig_iso.png", "thesis_6_4_1.png", "thesis_6_4_2.png"]
    assert all(p.stat().st_size > 10_000 for p in tmp_path.iterdir())


@pytest.mark.parametrize(
    ("words", "complaint"),
    [
        (("compare", "thesis_6_4_9"), "did you mean"),
        (("compare", "--fault", "leak"), "leakage"),
        (("compare", "--faults", "guessed"), "known"),
    ],
)
def test_bad_names_are_one_line(words: tuple[str, ...], complaint: str) -> None:
    with pytest.raises(ErError, match=complaint) as caught:
        done(*words)
    assert "\n" not in str(caught.value)


@pytest.mark.parametrize(
    ("program", "words", "line"),
    [
        (app, ["compare", "--seeds", "0"], "er x compare: invalid value for '--seeds': "),
        (controller, [], "er x: missing option '--model' (er x --help)"),
        (observers, ["unified"], "er x unified: missing option '--model' (er x unified --help)"),
    ],
)
def test_wrong_usage_is_one_line(program: Typer, words: list[str], line: str) -> None:
    result = CliRunner().invoke(program, words, prog_name="er x")
    assert (result.exit_code, result.stdout) == (2, "")
    assert result.stderr.startswith(line)
    assert result.stderr.count("\n") == 1
