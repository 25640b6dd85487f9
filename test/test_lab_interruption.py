"""Ctrl-C in `lab improve` keeps what is done, and the same command goes on from there."""

import json
from contextlib import contextmanager

import pytest
from er_model_lab.load import load
from er_model_lab.resume import resume
from er_models.files import load_model
from typer.testing import CliRunner

from er_model_lab import cli, cli_missing
from test.conftest import ROOT
from test.sample import with_friction, write_sample

MODEL = ROOT / "config/dampers/inove_guo.yaml"
BOTH = {"coulomb_friction", "preload"}


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    truth = with_friction("inove_guo").with_effect("preload", {"F_0": 1.5})
    return write_sample(tmp_path_factory.mktemp("data") / "run.csv", seed=4, truth=truth)


def improve(data, folder, stop_in_round, monkeypatch):
    """Run the command; Ctrl-C comes in that round of trying effects (0: never)."""
    seen = []

    def tick(effect):
        seen.append(effect)
        if seen.count(effect) == stop_in_round and len(set(seen)) > 5:
            raise KeyboardInterrupt

    @contextmanager
    def progress(*_):
        yield tick

    monkeypatch.setattr(cli_missing, "progress", progress)
    words = [
        "improve",
        data,
        "--model",
        MODEL,
        "--out",
        folder / "m.yaml",
        "--json",
        folder / "r.json",
    ]
    return CliRunner().invoke(cli.app, [str(w) for w in words])


def test_what_was_done_is_kept_and_gone_on_from(data, tmp_path, monkeypatch):
    stopped = improve(data, tmp_path, 2, monkeypatch)
    assert stopped.exit_code == 130, stopped.output
    first = json.loads((tmp_path / "r.json").read_text())
    assert first["interrupted"] is True
    assert len(first["steps"]) == 2
    (kept,) = first["effects"]
    assert kept in BOTH
    left = load_model(tmp_path / "m.yaml")
    assert kept in left.effects
    assert not set(left.effects) >= BOTH
    assert left.history[-1]["interrupted"] is True

    model = load_model(MODEL)
    other = load([write_sample(tmp_path / "other.csv", seed=5)])
    changed = model.with_effect("preload", {"F_0": 1.0})
    here = load([data])
    passes = [
        resume(tmp_path / "m.yaml", m, d, model.catalogue).passes
        for m, d in ((model, here), (model, other), (changed, here))
    ]
    assert passes == [1, 0, 0]  # another model, or other data, begin anew

    done = improve(data, tmp_path, 0, monkeypatch)
    assert done.exit_code == 0, done.output
    r = json.loads((tmp_path / "r.json").read_text())
    assert r["interrupted"] is False
    assert [s["added"] for s in r["steps"][:2]] == [s["added"] for s in first["steps"]]
    assert set(r["effects"]) == BOTH
    assert "went on" in r["notes"][0]
    errors = [s["rmse_held_out"] for s in r["steps"]]
    assert errors[-1] < 0.5 * errors[1] < 0.5 * errors[0]
    model = load_model(tmp_path / "m.yaml")
    assert set(model.effects) >= BOTH
    assert model.history[-1]["interrupted"] is False


def test_before_anything_is_done_nothing_is_written(data, tmp_path, monkeypatch):
    result = improve(data, tmp_path, 1, monkeypatch)
    assert result.exit_code == 130
    assert "nothing was written" in result.output
    assert list(tmp_path.iterdir()) == []
