"""Records that do not belong together: a duty that only some have, forces of another size, a deflection off centre."""

import json
import re

import numpy as np
import pytest
from er_model_lab.cli.app import app
from er_model_lab.preflight.check import preflight
from er_models.errors import MissingChannel
from er_models.files import load_model
from er_models.prediction import motion, predict
from er_records.dataset import Dataset
from er_records.duty_known import driven
from er_records.record import Record
from er_records.write import write_csv
from lab_help import DT, FORCE_NOISE, GUO, imposed
from typer.testing import CliRunner


def record(name="run", seed=1, duty=1.0, without=(), force=1.0, zero=0.0, seconds=8.0):
    """The Guo damper on an imposed motion; duty: factor on its steps."""
    rng, n = np.random.default_rng(seed), round(seconds / DT)
    x, v, a, u = imposed(rng, n)
    channels = {
        "deflection": x + zero + 2e-5 * rng.standard_normal(n), "duty": duty * u,
        "deflection_velocity": v + 1e-3 * rng.standard_normal(n),
        "damper_force": predict(load_model(GUO), motion(DT, x, v, duty * u, a)) + FORCE_NOISE * rng.standard_normal(n),
    }  # fmt: skip
    channels["damper_force"] *= force
    return Record(name, np.arange(n) * DT, {c: y for c, y in channels.items() if c not in without})


def test_a_record_without_duty_beside_driven_ones_is_left_out():
    known, blind = record("known"), record("blind", 2, without=("duty",))
    found = driven(Dataset.of([known, blind]))
    (kept,) = found.learn
    assert (kept.name, kept.complete, found.score) == ("known", False, ())
    assert kept.notes[-1].startswith(
        "blind: left out, as the duty is missing and others are driven"
    )
    found = driven(Dataset.of([known, blind], [record("more", 3), blind]))
    assert [[r.name for r in part] for part in (found.learn, found.score)] == [["known"], ["more"]]


@pytest.mark.parametrize("duty", [0.0, None])
def test_where_no_record_is_driven_none_is_left_out(duty):
    off = record("off", duty=0.0) if duty is not None else record("off", without=("duty",))
    data = Dataset.of([off], [record("blind", 2, without=("duty",))])
    assert driven(data) is data


@pytest.mark.parametrize("order", [1, -1], ids=["score", "learn"])
def test_without_a_duty_in_what_is_learnt_from_or_scores_nothing_can_be_said(order):
    learnt, scoring = [record("known"), record("blind", 2, without=("duty",))][::order]
    with pytest.raises(MissingChannel, match="'duty' is needed since others are driven"):
        driven(Dataset.of([learnt], [scoring]))


def test_the_command_says_so_and_ends_with_incomplete(tmp_path):
    write_csv(record("known"), tmp_path / "known.csv")
    write_csv(record("blind", 2, without=("duty",)), tmp_path / "blind.csv")
    words = ["compare", str(tmp_path), "--model", str(GUO), "--json", str(tmp_path / "r.json")]
    done = CliRunner().invoke(app, words)
    assert done.exit_code == 3
    found = json.loads((tmp_path / "r.json").read_text())
    assert found["complete"] is False
    assert found["rmse"] < 0.25
    assert any(n.startswith("blind: left out") for n in found["notes"])


SIZES = {
    "as it is": (1.0, 0.0, []), "kN": (1e-3, 0.0, ["damper_force"]), "another damper": (100.0, 0.0, ["damper_force"]),
    "off centre": (1.0, 0.05, ["deflection"]),
}  # fmt: skip


@pytest.mark.parametrize("case", SIZES)
def test_data_of_another_size_or_off_centre_are_warned_of(case):
    force, zero, said = SIZES[case]
    found = preflight([record(force=force, zero=zero)], load_model(GUO))
    warned = [f for f in found.findings if f.check == "size"]
    assert [f.channel for f in warned] == said
    assert found.passed
    assert all(f.remedy and f.level == "warning" for f in warned)
    assert not any(f.check == "size" for f in preflight([record(force=force, zero=zero)]).findings)


def test_compare_says_that_the_deflection_is_off_centre_in_lines_that_fit(tmp_path):
    write_csv(record(zero=0.05), tmp_path / "off.csv")
    done = CliRunner().invoke(app, ["compare", str(tmp_path / "off.csv"), "--model", str(GUO)])
    assert done.exit_code == 0
    told = " ".join(line.strip() for line in done.output.splitlines())
    middle = re.search(r"the deflection's middle is at ([\d.]+) mm", told)
    assert middle
    assert float(middle[1]) == pytest.approx(50.0, abs=3.0)
    assert "another (deflection_zero)" in told
