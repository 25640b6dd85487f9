"""The peers of the lab, on twenty seconds with a friction or with nothing hidden, and the table of them all."""

import importlib.util

import pytest
from er_models.files import load_model

from test.conftest import ROOT
from test.peers import __main__ as program
from test.peers import boosted, least_squares, sindy
from test.peers.data import given
from test.sample import write_sample

MODEL = load_model(ROOT / "config/dampers/inove_guo.yaml")
FEW = ("coulomb_friction", "preload", "gas_spring")


@pytest.fixture(scope="module")
def tasks(tmp_path_factory):
    found = {}
    for name, truth in (("friction", None), ("complete", MODEL)):
        folder = tmp_path_factory.mktemp(name)
        paths = [write_sample(folder / f"{s}.csv", seed=s, truth=truth) for s in (1, 2)]
        found[name] = given(MODEL, *paths)
    return found


@pytest.fixture
def few(monkeypatch):
    def candidates(model, _):
        return [model.catalogue[name] for name in FEW]

    monkeypatch.setattr(least_squares, "missing", candidates)
    monkeypatch.setattr(sindy, "missing", candidates)


def before(task):
    return task.rms_fresh(task.fresh.predict(task.model))


def test_least_squares_with_bic_finds_the_friction(tasks, few):
    found = least_squares.answer(tasks["friction"])
    assert found.names == ("coulomb_friction",)
    assert found.rms < 0.5 * before(tasks["friction"])


def test_trees_name_nothing_and_lower_the_error(tasks):
    found = boosted.answer(tasks["friction"])
    assert found.names == ()
    assert found.rms < 0.8 * before(tasks["friction"])


@pytest.mark.skipif(
    importlib.util.find_spec("pysindy") is None, reason="pysindy is not installed: python -m test.peers does it"
)  # fmt: skip
def test_sparse_regression_finds_the_friction_and_leaves_a_complete_model_alone(tasks, few):
    found = sindy.answer(tasks["friction"])
    assert found.names == ("coulomb_friction",)
    assert found.rms < 0.6 * before(tasks["friction"])
    assert sindy.answer(tasks["complete"]).rms < 1.1 * before(tasks["complete"])


def test_the_table_counts_right_and_false_names():
    def said(names, ratio):
        return {"names": names, "ratio": ratio, "seconds": 2.0}

    def row(hidden, lab, bic):
        answers = {"lab": lab, "bic": bic, "pysindy": bic, "trees": said([], 1.5)}
        return {"hidden": hidden, "seed": 1, "said": answers}

    rows = [
        row(["preload"], said(["preload"], 1.0), said(["gas_spring"], 2.0)),
        row(["preload"], said([], 1.2), said(["preload"], 1.0)),
        row([], said([], 1.0), said(["preload"], 1.1)),
    ]
    lines = program.table(rows).splitlines()
    lab, bic = lines[2], lines[-1]
    assert "1 of 2 (50%) | 0 of 1 (0%) | 1.10 (1.20) | 1.00 (1.00) | 2.0" in lab
    assert "1 of 2 (50%) | 1 of 1 (100%) | 1.50 (2.00)" in bic
