"""Several models on the same data: the table, what is overlaid, and what the model file tells of itself."""

import json
from dataclasses import replace

import numpy as np
import pytest
from er_model_lab.cli.app import app
from er_model_lab.output.report.page import figures
from er_model_lab.output.report.sections import history, models
from er_model_lab.results.side_by_side import Rival, fitted_to, names, overlaid, table
from er_model_lab.view import RecordView
from er_models.files import load_model, save_model
from lab_help import GUO, problem_of
from report_views import HISTORY, TABLES, compared
from typer.testing import CliRunner

SECONDS = 30


def rival(name, error, fitted=False, seed=0):
    """A model that leaves noise of 0.2 N, common to all of the same seed, and an error of its own."""
    rng = np.random.default_rng(seed)
    t = np.arange(200 * SECONDS) / 200.0
    measured = 5.0 * np.sin(7.0 * t)
    own = np.random.default_rng([ord(c) for c in name]).standard_normal(t.size)
    before = measured - 0.2 * rng.standard_normal(t.size) - error * own
    scored = t > 0.3
    view = RecordView("r", t, t, t, t, measured, before, None, scored, np.zeros(t.size, bool))
    model = replace(load_model(GUO), name=name, file=f"{name}.yaml")
    return Rival(model, (view,), fitted, TABLES)


def test_errors_and_the_band_of_the_difference():
    rivals = [rival("worse", 0.5), rival("better", 0.1), rival("same", 0.5)]
    rivals[2] = replace(rivals[2], records=rivals[0].records)
    first, better, same = table(rivals, 0.2, 0)
    assert first["rmse"] == pytest.approx(np.hypot(0.2, 0.5), rel=0.02)
    assert better["rmse"] == pytest.approx(np.hypot(0.2, 0.1), rel=0.02)
    assert better["against_first"]["change"] == pytest.approx(better["rmse"] - first["rmse"])
    low, high = better["against_first"]["band"]
    assert low < better["against_first"]["change"] < high < 0.0
    assert high - low < 0.03
    assert same["against_first"] == {"change": 0.0, "band": [0.0, 0.0]}
    assert better["explainable"] == pytest.approx(0.2, abs=0.05)
    assert first["nrmse"] == pytest.approx(first["rmse"] / 10.0, rel=1e-3)


def test_the_band_holds_nine_tenths_of_what_chance_makes_of_the_change():
    """The spread of the change over sixty records of the same two models is that of the band."""
    found = [
        table([rival(f"worse{k}", 0.5, seed=k), rival(f"better{k}", 0.4, seed=k)], 0.2, 0)[1]
        for k in range(60)
    ]
    changes = np.array([f["against_first"]["change"] for f in found])
    widths = [f["against_first"]["band"][1] - f["against_first"]["band"][0] for f in found]
    assert float(np.mean(widths)) == pytest.approx(2.0 * 1.645 * changes.std(ddof=1), rel=0.3)


def test_equal_names_are_told_apart_and_predictions_keep_their_order():
    one, two = rival("guo", 0.1), rival("guo", 0.4)
    assert names([one, two]) == ("guo (guo.yaml) #1", "guo (guo.yaml) #2")
    new = replace(two, model=replace(two.model, file="new.yaml"))
    assert names([one, new]) == ("guo (guo.yaml)", "guo (new.yaml)")
    (laid,) = overlaid([one, two, rival("other", 0.2)])
    assert [n for n, _ in laid.others] == ["guo (guo.yaml) #2", "other"]
    assert laid.others[0][1] is two.records[0].before


def test_the_report_overlays_the_models_and_tells_the_history():
    rivals = [rival("a", 0.5), rival("b", 0.1, fitted=True)]
    base = compared()
    result = {**base.result, "models": table(rivals, 0.2, 0), "history": HISTORY}
    view = replace(
        base, model="a", result=result, records=overlaid(rivals),
        rival_regions=(("a", TABLES), ("b", TABLES)),
    )  # fmt: skip
    drawn = {f.name: f for f in figures(view)}
    assert {"models", "models_where"} <= set(drawn)
    force = [m.name for m in drawn["time_series"].panels[0].marks]
    assert force[:3] == ["measured", "a", "b"]
    second = drawn["time_series"].panels[1].marks[-1]
    left = rivals[1].records[0].measured - rivals[1].records[0].before
    assert np.array_equal(second.y, left)
    rows = models.section(view).facts["rows"]
    assert [r["seen"] for r in rows] == ["", "fitted to these data"]
    assert history.section(view).facts["rows"][0]["change"] == "+ Coulomb friction"
    assert history.section(view).facts["rows"][0]["fall"] == "0.500 N → 0.200 N"
    assert models.section(compared()) is None
    assert history.section(compared()) is None


def test_the_command_sets_models_side_by_side(tmp_path):
    model, problem = problem_of("coulomb_friction", {"F_c": 1.0, "v_0": 0.003}, seconds=12.0)
    z, m = problem.raw[0].z, problem.motion
    columns = {
        "t": np.arange(m.n) * m.dt, "deflection": z[:, 0], "deflection_velocity": z[:, 1], "duty": m.u,
        "damper_force": problem.force, "sprung_acceleration": z[:, 2], "unsprung_acceleration": 0.0 * m.u,
    }  # fmt: skip
    data, right = tmp_path / "run.csv", tmp_path / "right.yaml"
    np.savetxt(
        data,
        np.column_stack(list(columns.values())),
        delimiter=",",
        header=",".join(columns),
        comments="",
    )
    truth = model.with_effect("coulomb_friction", {"F_c": 1.0, "v_0": 0.003})
    save_model(replace(truth, name="right"), right)
    words = ["compare", data, "--model", GUO, "--model", right, "--json", tmp_path / "r.json"]
    done = CliRunner().invoke(app, [str(w) for w in words])
    assert done.exit_code == 0, done.output
    r = json.loads((tmp_path / "r.json").read_text())
    first, second = r["models"]
    assert first["rmse"] == pytest.approx(r["rmse"])
    assert second["model"] == "right"
    assert second["rmse"] < 0.4 * first["rmse"]
    assert second["against_first"]["band"][1] < 0.0
    assert "right" in done.output
    assert len(done.output.splitlines()) <= 40
    assert not fitted_to(truth, "abc")
    assert fitted_to(replace(truth, history=({"data": "abc"},)), "abc")
