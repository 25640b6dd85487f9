"""The lab with every damper of chapter 1 that is shipped, on short records of its own."""

import math

import pytest
from er_model_lab.verbs.compare import compare
from er_model_lab.verbs.diagnose import diagnose
from er_model_lab.verbs.improve import improve
from er_model_lab.verbs.load import load, load_model
from er_models.files import save_model

from test.conftest import ROOT
from test.sample import with_friction, write_sample

FOLDER = ROOT / "config" / "dampers"
LEVELS = (0.0, 0.1, 0.15, 0.2, 0.25, 0.3)
"""The duties of Table 1.4: a table of response times needs data at each of them."""
DAMPERS = (
    "inove_bingham_complete",
    "inove_guo_static",
    "inove_guo_tau_quadratic",
    "inove_guo_complete",
)


def asked(damper, truth, folder, seconds):
    """Seconds of a true damper as data, and the model that is asked about them."""
    path = write_sample(
        folder / "run.csv", seed=1, seconds=seconds, truth=truth, levels=LEVELS, hold=60
    )
    return load(path), load_model(FOLDER / f"{damper}.yaml")


@pytest.mark.parametrize("damper", DAMPERS)
def test_compare_leaves_the_noise(damper, tmp_path):
    """A model against its own record: 0.15 N of the force sensor, and what the noise of the motion makes of it."""
    truth = load_model(FOLDER / f"{damper}.yaml")
    result = compare(*asked(damper, truth, tmp_path, 6.0))
    assert 0.13 < result.rmse < 0.19
    assert result.nrmse < 0.015


@pytest.mark.slow
@pytest.mark.parametrize("damper", ["inove_bingham_complete", "inove_guo_tau_table"])
def test_diagnose_finds_nothing_missing(damper, tmp_path):
    truth = load_model(FOLDER / f"{damper}.yaml")
    assert diagnose(*asked(damper, truth, tmp_path, 10.0)).verdict == "adequate"


@pytest.mark.slow
@pytest.mark.parametrize("damper", ["inove_guo_tau_quadratic", "inove_guo_two_sided"])
def test_improve_finds_the_friction_that_is_missing(damper, tmp_path):
    out = tmp_path / "better.yaml"
    result = improve(*asked(damper, with_friction(damper), tmp_path, 12.0))
    assert result.effects == ("coulomb_friction",)
    assert result.rmse_after.held_out < 0.19
    save_model(result.model, out)
    found = load_model(out)
    friction, sd = (
        found.value("coulomb_friction", "F_c"),
        found.deviations["coulomb_friction"]["F_c"],
    )
    assert math.isclose(friction, 1.0, abs_tol=4.0 * sd)
    assert sd < 0.2
    assert set(load_model(FOLDER / f"{damper}.yaml").effects) < set(found.effects)
