"""Frequency responses of the observers' errors, and the command that draws them."""

from __future__ import annotations

import csv
from pathlib import Path

import numpy as np
import pytest
from er_models.model import Model
from er_observers.gains import Gains
from er_observers.programs import OBSERVERS
from er_observers.running.ready import ready
from er_studies.observers.frequency import command
from er_studies.observers.frequency.figures import FIGURES, responses
from er_studies.observers.frequency.responses import HERTZ, outputs, respond
from typer.testing import CliRunner

pytestmark = pytest.mark.slow


@pytest.fixture(scope="module")
def every(car: Model, gain_file: Path) -> dict[str, Gains]:
    """The committed gains of all observers."""
    return {name: ready(gain_file.parent / f"{name}.yaml", car, name) for name in OBSERVERS}


def test_static_error_of_the_gate_is_that_of_any_gain(every: dict[str, Gains]) -> None:
    """Fact 1: f_c / (k_s + k_0) of deflection per gate at duty 1, whatever the observer."""
    for name, gains in every.items():
        form = gains.form
        through = -form.C[0, 3] * form.B[3] / form.A[3, 3]
        found = respond(name, gains.claim, 1.0, "gate", np.array([1e-5])).gains[0]
        assert found[0] == pytest.approx(abs(through / form.C[0, 0]), rel=1e-4)


def test_the_unified_observer_does_not_feel_the_road(every: dict[str, Gains]) -> None:
    """Exact decoupling, at every frequency; the polytopic one feels it a little."""
    size = every["unified"].claim.scaling.state
    felt = {
        name: (respond(name, gains.claim, 0.5, "road").gains[:, :4] / size).max()
        for name, gains in every.items()
    }
    assert felt["unified"] < 1e-5 * felt["nlpv_polytopic"]


def test_noise_reaches_the_force_as_its_phasor_says(every: dict[str, Gains]) -> None:
    """The error's equation under a sine of 0.01 m/s2 on one sensor and then on the other."""
    claim = every["unified"].claim
    law, hertz, forces = claim.solution.law, 20.0, []
    pencil = 2j * np.pi * hertz * np.eye(law.order) - law.M[0]
    for sensor in (0, 1):
        noise = 0.01 * np.eye(2)[sensor]
        error = law.R @ np.linalg.solve(pencil, -law.J[0] @ noise) - law.S @ noise
        forces.append(abs(claim.form.F @ error))
    found = respond("unified", claim, 0.0, "noise", np.array([hertz])).gains[0, -1]
    assert found == pytest.approx(max(forces), rel=1e-9)


def test_every_figure_has_its_lines(every: dict[str, Gains]) -> None:
    """Fourteen figures: two vertices, eleven grid points, one line where the duty does not matter."""
    lines = {f.number: len(responses(f, every)) for f in FIGURES}
    assert len(lines) == 14
    assert (lines["3.1"], lines["4.1"], lines["4.2"], lines["5.4"]) == (1, 2, 11, 14)
    assert outputs(every["unified"].claim)[-1] == "force"


def test_command_writes_pictures_and_numbers(
    gain_file: Path, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    """Two figures here, to be quick; an unknown format is refused."""
    monkeypatch.setattr(command, "FIGURES", FIGURES[:2])
    call = ["--out", str(tmp_path), "--config", str(gain_file.parents[1])]
    result = CliRunner().invoke(command.app, call)
    assert result.exit_code == 0, result.output
    assert (tmp_path / "figure_3_2.svg").read_text(encoding="utf-8").lstrip().startswith("<?xml")
    rows = list(csv.reader((tmp_path / "figure_3_2.csv").open(encoding="utf-8")))
    assert len(rows) == 1 + len(HERTZ)
    assert len({len(row) for row in rows}) == 1
    assert len(list(csv.reader((tmp_path / "peaks.csv").open(encoding="utf-8")))) == 1 + 1 + 5
    refused = CliRunner().invoke(command.app, [*call, "--format", "gif"])
    assert "gif" in str(refused.exception)
