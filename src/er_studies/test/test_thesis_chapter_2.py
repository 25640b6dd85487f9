"""Chapter 2 made again: figures, page and command."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from er_model_lab.output.report.page import write_report
from er_studies.thesis.chapter_2 import FINE, FORMS, Chapter2, chapter_2, departures, recorded
from er_studies.thesis.chapter_2_text import HEAD_ZEROS, lines, peaks, rates, result, ride, zeros
from er_studies.thesis.command import app
from er_studies.thesis.report.chapter_2 import sections, view
from typer.testing import CliRunner

ROOT = Path(__file__).resolve().parents[3]
PROGRAM = """
schema: er_program 1
duration: 0.25
seed: 3
road: {kind: iso8608, road_class: C, peak_velocity: 0.12}
duty: {kind: steps, low: 0.0, high: 1.0, hold_min: 0.02, hold_max: 0.1}
"""


@pytest.fixture(scope="module")
def config(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The shipped models with a shorter ride."""
    folder = tmp_path_factory.mktemp("config")
    for name in ("dampers", "vehicles"):
        (folder / name).symlink_to(ROOT / "config" / name)
    (folder / "simulations").mkdir()
    (folder / "simulations" / "chapter_2.yaml").write_text(PROGRAM)
    return folder


@pytest.fixture(scope="module")
def found(config: Path) -> Chapter2:
    """Everything of chapter 2, with the steps it says on the way."""
    said: list[str] = []
    made = chapter_2(config, said.append)
    assert len(said) == len(FORMS) + 2
    return made


def test_every_form_is_the_compiled_model(found: Chapter2) -> None:
    """Each departs by the error of the integrators only, and one in a leaking car by no more."""
    for signals in found.ride.forms.values():
        assert departures(signals, found.ride.record).max() < 2e-3
    assert departures(found.ride.descriptor, found.ride.leaking).max() < 2e-3
    assert departures(found.ride.descriptor, found.ride.record).max() > 0.02
    assert len(ride(found)) == len(FORMS) + 1


def test_record_of_short_steps_keeps_its_samples(found: Chapter2) -> None:
    """A record in fine steps has one row per sample and starts at rest."""
    r = found.ride
    again = recorded(found.model, r.road, r.duty)
    assert again.shape == (r.t.size, 4)
    assert FINE > 1
    np.testing.assert_array_equal(again, r.record)
    np.testing.assert_allclose(again[0, [0, 3]], 0.0)


def test_tables_say_what_was_found(found: Chapter2) -> None:
    """Peaks beside the thesis's, and which errors decay, as text and as data."""
    assert peaks(found)[1] == ("z_us / z_r", "4, 20", "4.30, 18.43", "1.163, 1.052")
    decays = {row[:3]: row[4] for row in zeros(found)}
    assert decays["relative", "road", "accelerations"] == "yes"
    assert decays["absolute", "road", "accelerations"] == "no"
    assert decays["relative", "road + lost force", "accelerations"] == "no"
    assert decays["relative", "road + lost force", "accelerations + deflection"] == "yes"
    assert next(rates(s) for s in found.systems if s.velocities == "relative") == []
    data = json.loads(json.dumps(result(found), allow_nan=False))
    assert data["peaks"]["z_s"]["ours"][0]["hertz"] == pytest.approx(3.83, abs=0.01)
    assert max(data["departures"]["relative"].values()) < 2e-3
    assert [tuple(row) for row in data["tables"][0]["rows"]] == peaks(found)
    last = data["tables"][2]
    assert (last["head"], last["rows"]) == ([*HEAD_ZEROS], [[*row] for row in zeros(found)])
    text = "\n".join(lines(found))
    assert "3.83" in text
    assert "-27.4" in text


def test_page_holds_every_picture(found: Chapter2, tmp_path: Path) -> None:
    """One page with its pictures as PNG and SVG, no curve empty."""
    made = sections(found, result(found))
    names = {f.name for s in made for f in s.figures}
    assert {"passive_car", "suspension", "fluid", "whole_car", "ride", "leak", "sensing"} <= names
    for figure in (f for s in made for f in s.figures):
        for mark in (m for panel in figure.panels for m in panel.marks if hasattr(m, "y")):
            assert np.isfinite(mark.y).sum() > 10
    page = write_report(view(found, result(found)), tmp_path, made)
    html = page.read_text(encoding="utf-8")
    assert "4.30, 18.43" in html
    assert {p.stem for p in (tmp_path / "figures").glob("*.svg")} == names


def test_command_prints_the_tables_and_writes_them(config: Path, tmp_path: Path) -> None:
    """`./er study thesis chapter2` ends well and its result is that of the functions."""
    place = tmp_path / "result.json"
    told = CliRunner().invoke(app, ["chapter2", "--config", str(config), "--json", str(place)])
    assert told.exit_code == 0, told.output
    assert "4.30, 18.43" in told.output
    assert json.loads(place.read_text())["command"] == "thesis chapter2"


def test_a_car_that_the_forms_cannot_hold_is_one_line(config: Path, tmp_path: Path) -> None:
    """A damped tyre is named, with exit status 2."""
    for name in ("dampers", "simulations"):
        (tmp_path / name).symlink_to(config / name)
    text = (config / "vehicles" / "inove_quarter_car.yaml").read_text()
    text += "  tyre_damping:\n    c_t: {value: 7.0, unit: N s/m}\n"
    (tmp_path / "vehicles").mkdir()
    (tmp_path / "vehicles" / "inove_quarter_car.yaml").write_text(text)
    told = CliRunner().invoke(app, ["chapter2", "--config", str(tmp_path)])
    assert told.exit_code == 2
    assert "leave out one of tyre_damping" in told.output
    assert told.output.count("\n") == 1
