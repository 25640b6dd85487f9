"""`lab identify` on dampers made from the printed tables: values, deviations, gaps, and the command."""

import json
import math
import re
from dataclasses import replace

import numpy as np
import pytest
from er_model_lab.cli.app import app
from er_model_lab.identification import identified
from er_model_lab.identification.findings import findings, missing
from er_model_lab.identification.present import parameters
from er_models.files import load_model
from er_plant_sim.build import build
from er_plant_sim.settings import PlantParameters
from er_records.dataset import Dataset
from typer.testing import CliRunner

from test.identify_data import TRUTHS, program
from test.identify_score import estimates, rows, started


@pytest.mark.parametrize("damper", ["guo", "bingham"])
def test_every_parameter_comes_back_from_values_three_times_off(damper):
    for e in estimates(TRUTHS[damper], seed=5, seconds=3.0):
        assert abs(e.value - e.true) < 4.0 * e.sd, e
        limit = 0.15 if e.status == "weak" else 0.01
        assert e.sd < limit * e.true, e


def test_a_damper_a_hundred_times_stronger_is_identified_from_the_same_model():
    truth = replace(TRUTHS["guo"], strength=100.0)
    for e in estimates(truth, seed=6, seconds=3.0):
        assert abs(e.value - e.true) < 4.0 * e.sd, e


def test_k1_and_c1_are_called_weakly_visible_and_moving_together():
    found = identified(
        Dataset.of(program(TRUTHS["guo"], 7, 3.0, (0.0, 0.1, 0.3))), started(TRUTHS["guo"], 7)
    )
    said = " ".join(findings(found))
    for name, other in (("k1", "c1"), ("c1", "k1")):
        assert re.search(
            rf"weakly visible.*guo_yield.{name} \([^)]*moves with guo_yield.{other}, ", said
        )
    status = {n: e["status"] for v in parameters(found).values() for n, e in v.items()}
    assert status == {
        "k0": "identified", "c0": "identified", "f_c": "identified", "k1": "weak", "c1": "weak",
        "tau": "identified",
    }  # fmt: skip
    assert missing(found) == []
    assert "never steps" in said
    assert "offset" not in said
    assert "lacks" not in said
    assert "would follow" not in said


def test_one_duty_leaves_the_exponent_as_given_and_says_what_hangs_on_it():
    truth = TRUTHS["bingham"]
    model = started(truth, 8)
    found = identified(Dataset.of(program(truth, 8, 3.0, (0.0, 0.2))), model)
    entries = parameters(found)["bingham_yield"]
    assert entries["beta"]["status"] == "not_identified"
    assert entries["beta"]["value"] == model.value("bingham_yield", "beta")
    assert entries["sigma"]["status"] == "conditional"
    sigma = 12.8157 * 0.2 ** (0.2373 - entries["beta"]["value"])
    assert entries["sigma"]["value"] == pytest.approx(sigma, rel=0.01)
    said = " ".join(missing(found))
    assert "one duty only (0.200)" in said
    assert "valid for that value only: bingham_yield.sigma" in said


def test_without_zero_duty_the_passive_terms_come_from_all_data():
    truth = TRUTHS["guo"]
    found = identified(Dataset.of(program(truth, 9, 3.0, (0.1, 0.3))), started(truth, 9))
    assert missing(found) == ["no stretch at zero duty: no stage for k0, c0"]
    entry = parameters(found)["passive"]["c0"]
    assert abs(entry["value"] - 64.6433) < 4.0 * entry["sd"]


def test_a_static_model_of_a_damper_that_lags_is_said_to_lack_something(root):
    model = load_model(root / "config/dampers/inove_guo_static.yaml")
    found = identified(Dataset.of(program(TRUTHS["guo"], 10, 3.0, (0.0, 0.2))), model)
    assert "the values are those of a model that lacks something" in findings(found)[0]


def test_an_offset_of_the_force_is_said():
    records = program(TRUTHS["guo"], 11, 3.0, (0.0, 0.2))
    moved = [
        replace(r, channels={**r.channels, "damper_force": r.channels["damper_force"] + 0.5})
        for r in records
    ]
    found = identified(Dataset.of(moved), started(TRUTHS["guo"], 11))
    assert any("mean of 0.49" in s and "offset of the force" in s for s in findings(found))


def test_a_law_that_misses_the_levels_is_said():
    truth = replace(TRUTHS["guo"], tau=TRUTHS["guo_complete"].tau)
    found = identified(
        Dataset.of(program(truth, 12, 3.0, (0.0, 0.1, 0.3))), started(TRUTHS["guo"], 12)
    )
    assert found.table is not None
    assert found.table.tau == pytest.approx([0.0137, 0.0631], rel=0.05)
    assert any("a model with another tau(u) would follow it" in s for s in findings(found))


def written(folder, records):
    """Records as CSV files."""
    folder.mkdir()
    for r in records:
        columns = {"t": r.t, **r.channels}
        table = np.stack(list(columns.values()), axis=1)
        np.savetxt(
            folder / f"{r.name}.csv", table, delimiter=",", header=",".join(columns), comments=""
        )
    return folder


def lab(*words):
    return CliRunner().invoke(app, [str(w) for w in words])


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    """Nine records at three duties."""
    records = program(TRUTHS["guo"], 13, 3.0, (0.0, 0.15, 0.3))
    return written(tmp_path_factory.mktemp("data") / "DATA", records)


def test_the_command_writes_a_model_that_the_plant_runs(data, root, tmp_path):
    given, out = root / "config/dampers/inove_guo.yaml", tmp_path / "new.yaml"
    files = [tmp_path / "a.json", tmp_path / "b.json"]
    more = written(tmp_path / "MORE", program(TRUTHS["guo"], 15, 3.0, (0.15,)))
    for file in files:
        result = lab("identify", data, "--model", given, "--out", out, "--json", file,
                     "--hold-out", more, "--seed", 4)  # fmt: skip
        assert result.exit_code == 0, result.output
    a, b = (json.loads(f.read_text()) for f in files)
    assert a == b
    assert a["verdict"] == "identified"
    assert set(a["rmse_after"]) == {"train", "held_out"}
    assert a["rmse_after"]["held_out"] < 1.1 * a["noise_floor"]
    assert len(a["correlation"]["matrix"]) == len(a["correlation"]["names"]) == 6
    assert [s["done"] for s in a["stages"]] == [True, True, True]
    model = load_model(out)
    entry = a["parameters"]["response"]["tau"]
    assert (model.value("response", "tau"), model.deviations["response"]["tau"]) == (
        entry["value"], entry["sd"],
    )  # fmt: skip
    last = model.history[-1]
    assert "response.tau" in last["identified"]
    assert (last["held"], last["from"], last["seed"]) == ([], "inove_guo", 4)
    rig = build(
        PlantParameters(
            model_file=str(root / "config/vehicles/inove_quarter_car.yaml"), damper_file=str(out),
            program_file=str(root / "config/experiments/step.yaml"), safe_duty=0.0,
        )
    )  # fmt: skip
    assert rig is not None


def test_gaps_have_exit_status_3_and_a_missing_channel_4(root, tmp_path):
    given, out = root / "config/dampers/inove_bingham.yaml", tmp_path / "new.yaml"
    records = program(TRUTHS["bingham"], 14, 3.0, (0.2,))
    one = written(tmp_path / "one", records)
    result = lab("identify", one, "--model", given, "--out", out, "--json", tmp_path / "r.json")
    assert result.exit_code == 3, result.output
    assert "no stretch at zero duty" in result.output
    assert json.loads((tmp_path / "r.json").read_text())["complete"] is False
    kept = load_model(out)
    assert kept.value("bingham_yield", "beta") == 0.2373
    assert "beta" not in kept.deviations["bingham_yield"]
    out.unlink()
    bare = [
        replace(r, channels={k: y for k, y in r.channels.items() if k != "duty"}) for r in records
    ]
    result = lab("identify", written(tmp_path / "bare", bare), "--model", given, "--out", out)
    assert result.exit_code == 4, result.output
    assert "duty" in result.output
    assert not out.exists()


def test_bad_usage_has_exit_status_2(data, root, tmp_path):
    given = tmp_path / "own.yaml"
    given.write_text((root / "config/dampers/inove_guo.yaml").read_text())
    assert lab("identify", data, "--model", given, "--out", given).exit_code == 2
    assert lab("identify", data, "--model", given, "--out", tmp_path / "n.yaml",
               "--level", "vehicle").exit_code == 2  # fmt: skip
    assert not (tmp_path / "n.yaml").exists()


@pytest.mark.slow
def test_the_report_draws_parameters_and_response_times(data, root, tmp_path):
    result = lab("identify", data, "--model", root / "config/dampers/inove_guo_tau_quadratic.yaml",
                 "--out", tmp_path / "n.yaml", "--report", tmp_path / "report")  # fmt: skip
    assert result.exit_code == 3, result.output
    page = (tmp_path / "report" / "index.html").read_text()
    assert "weakly visible" in page
    for name in ("correlation", "response_time", "residual_maps"):
        assert (tmp_path / "report" / "figures" / f"{name}.svg").stat().st_size > 1000


@pytest.mark.slow
@pytest.mark.parametrize("damper", ["guo_complete", "bingham_complete"])
def test_the_two_sided_tables_come_back(damper):
    runs = [estimates(TRUTHS[damper], seed, 4.0) for seed in (21, 22)]
    z = [abs(e.value - e.true) / e.sd for run in runs for e in run]
    assert np.mean(np.array(z) < 3.0) >= 0.93
    assert max(z) < 5.0
    assert all(math.isfinite(float(row[2])) for row in rows(runs))
