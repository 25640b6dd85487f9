"""`lab plan` as a user calls it: its result, a program that the plant takes, and one line for bad input."""

import json
import re
import shlex
from pathlib import Path

import numpy as np
import pytest
from er_common.parameter_table import build as checked
from er_model_lab.cli.app import app
from er_model_lab.planning import motions_and_duties, planner, search
from er_model_lab.planning.limits import Sensors
from er_model_lab.planning.simulated_decision import measured
from er_model_lab.planning.virtual_rig import run_all
from er_models.files import load_model
from er_models.program import Program, document_of, load_program
from er_plant_sim.build import build
from er_plant_sim.settings import table
from er_records.write import write_csv
from typer.testing import CliRunner

from er_plant_sim import rig
from test.conftest import ROOT

pytestmark = pytest.mark.slow

CAR = "config/vehicles/inove_quarter_car.yaml"
DAMPER = "config/dampers/inove_guo.yaml"


@pytest.fixture(scope="module", autouse=True)
def quick():
    """A search of a few pieces and few simulated measurements."""
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(motions_and_duties, "SPEEDS", (1.0, 4.0))
        patch.setattr(search, "MOTIONS_KEPT", 1)
        patch.setattr(search, "SWEEPS", 0)
        patch.setattr(planner, "SETS", 1)
        patch.setattr(planner, "MEASUREMENTS", 1)
        yield


def lab(*words):
    return CliRunner().invoke(app, [str(w) for w in words])


def plan(out, *words):
    """What the command prints of a plan for the car, with its program in `out`."""
    result = lab(
        "plan", "--model", ROOT / CAR, "--between", "dead_time", "amplifier_lag", "--out", out,
        "--duration", 12, "--seed", 3, *words,
    )  # fmt: skip
    assert result.exit_code == 0, result.output
    return result.output


@pytest.fixture(scope="module")
def made(tmp_path_factory):
    """Folder with a planned program, its result and report, and what was printed."""
    folder = tmp_path_factory.mktemp("plan")
    shown = plan(folder / "next.yaml", "--json", folder / "r.json", "--report", folder / "report")
    return folder, json.loads((folder / "r.json").read_text()), shown


def test_the_result_says_what_was_asked_and_where_the_program_is(made):
    folder, r, shown = made
    assert r["command"] == "plan"
    assert r["between"] == ["dead_time", "amplifier_lag"]
    assert r["verdict"] in ("told_apart", "one_way", "not_told_apart")
    assert r["program_file"] == str(folder / "next.yaml")
    assert r["provenance"]["seed"] == 3
    assert f"program: {folder / 'next.yaml'}" in shown.replace("\n", "")
    assert "planned_forces" in (folder / "report" / "index.html").read_text()
    program = document_of(load_program(folder / "next.yaml"))
    assert r["programs"][0]["program"]["road"] == program["road"]
    assert r["programs"][0]["program"]["duty"] == program["duty"]


def test_the_plant_runs_the_planned_program_within_its_limits(made, root):
    folder, r, _ = made
    seen = driven(root, folder / "next.yaml")
    assert np.abs(seen["deflection"]).max() <= r["limits"]["stroke"]
    assert np.abs(seen["velocity"]).max() <= r["limits"]["velocity"]
    assert seen["duty"].max() <= r["limits"]["duty"]
    assert not seen["saturated"].any()
    assert np.abs(seen["velocity"]).max() > 0.5 * r["limits"]["velocity"]


def driven(root, program):
    """What the rig of the plant node does with a program, tick by tick."""
    given = {"model_file": str(root / CAR), "safe_duty": 0.1, "program_file": str(program)}
    made = build(checked(table(given), given, {}))
    state, rows = rig.start(made), []
    while not rig.finished(made, state):
        measurement = rig.sense(made, state)
        state, applied = rig.decide(made, state)
        rows.append(
            (
                measurement.deflection,
                measurement.deflection_velocity,
                applied.duty,
                applied.saturated,
            )
        )
        state = rig.advance(made, state)
    names = ("deflection", "velocity", "duty", "saturated")
    return dict(zip(names, np.array(rows, float).T, strict=True))


def test_the_same_seed_gives_the_same_program(made, tmp_path):
    plan(tmp_path / "next.yaml")
    assert (tmp_path / "next.yaml").read_text() == (made[0] / "next.yaml").read_text()


def test_what_a_diagnosis_suggests_runs_as_printed(root, tmp_path, monkeypatch):
    """Without field no effect of the actuation shows: the diagnosis says how to reveal one."""
    data = tmp_path / "run.csv"
    write_csv(without_field(root), data)
    shown = lab("diagnose", data, "--model", root / DAMPER, "--json", tmp_path / "d.json")
    r = json.loads((tmp_path / "d.json").read_text())
    (command,) = r["next"]
    pasted = re.search(r"^next: ((?:.*\\\n)*.*)$", shown.output, re.MULTILINE)
    words = shlex.split(command)
    assert pasted is not None
    assert shlex.split(pasted[1].replace("\\\n", " ")) == words
    assert words[:3] == ["./er", "lab", "plan"]
    hidden = {c["effect"] for c in r["candidates"] if c["status"] == "not_excited"}
    assert words[words.index("--reveal") + 1] in hidden
    monkeypatch.chdir(tmp_path)
    result = lab(*words[2:], "--duration", 12, "--vehicle", root / CAR)
    assert result.exit_code == 0, result.output
    assert load_program(tmp_path / "next.yaml").moves == "wheel"


def without_field(root):
    """Twelve seconds of the damper in a machine at zero duty, as its sensors record it."""
    road = {
        "kind": "multisine",
        "amplitudes": [0.005, 0.002, 0.001],
        "frequencies": [1.3, 3.1, 6.7],
    }
    program = Program(road, {"kind": "constant", "level": 0.0}, 12.0, 1, moves="damper")
    run = run_all({"": load_model(root / DAMPER)}, program, 0.005)[""]
    return measured(run, Sensors(2e-5, 1e-3, 0.025, 0.15), np.random.default_rng(2), "run")


WRONG = {
    "unknown effect": (("--between", "coulomb_fricton", "end_stop"), ("coulomb_fricton", "coulomb_friction")),
    "twice": (("--between", "end_stop", "end_stop"), ("end_stop", "twice")),
    "unknowable": (("--between", "velocity_gain", "end_stop"), ("velocity_gain", "cannot be known")),
    "neither": ((), ("--between", "--reveal")),
    "duty": (("--reveal", "end_stop", "--duty-max", 1.5), ("--duty-max", "1.5")),
    "stroke": (("--reveal", "end_stop", "--stroke", -1), ("--stroke", "-1")),
    "level": (("--reveal", "end_stop", "--level", "vehicle"), ("--level", "damper")),
    "no data": (("--reveal", "end_stop", "--data", "absent.csv"), ("absent.csv",)),
    "a damper as vehicle": (("--reveal", "end_stop", "--vehicle", DAMPER), ("quarter_car", "inove_guo.yaml")),
    "a folder": (("--reveal", "end_stop", "--out", "config"), ("--out", "a file name")),
}  # fmt: skip


@pytest.mark.parametrize("mistake", WRONG)
def test_bad_input_is_one_line(mistake, root, monkeypatch):
    monkeypatch.chdir(root)
    words, named = WRONG[mistake]
    result = lab("plan", "--model", DAMPER, *words)
    assert result.exit_code == 2, result.output
    lines = [line for line in result.output.strip().splitlines() if line]
    assert len(lines) == 1, result.output
    for word in named:
        assert str(word) in lines[0]


def test_a_program_for_a_machine_is_marked_and_no_car_takes_it(root, tmp_path):
    out = tmp_path / "machine.yaml"
    result = lab(
        "plan", "--model", root / DAMPER, "--reveal", "end_stop", "--out", out, "--duration", 12
    )
    assert result.exit_code == 0, result.output
    program = load_program(out)
    assert program.moves == "damper"
    road = program.signals(np.arange(0.0, program.duration, 0.005))[0]
    assert np.abs(road).max() <= 0.012
    given = {"model_file": str(Path(root) / CAR), "safe_duty": 0.1, "program_file": str(out)}
    with pytest.raises(Exception, match="moves: expected wheel"):
        build(checked(table(given), given, {}))
