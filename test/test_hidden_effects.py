"""The lab on data whose hidden effect it was not told, made by equations and an integrator of their own."""

import pytest
from er_model_lab.verbs.compare import compare
from er_model_lab.verbs.improve import improve
from er_model_lab.verbs.load import load, load_model

from test.blind.generator import make_case

pytestmark = pytest.mark.slow
MODEL = "config/dampers/inove_guo.yaml"
SECONDS = 10.0


@pytest.fixture
def model(root):
    return load_model(root / MODEL)


def improved(effect, seed, tmp_path, model):
    """What the lab makes of data with a hidden effect."""
    data = tmp_path / "data"
    make_case(effect, seed, n_records=3, seconds=SECONDS, out=data)
    return improve(load(data), model)


@pytest.mark.parametrize(
    ("effect", "seed"),
    [("coulomb_friction", 3), ("dead_time", 3), ("field_viscosity", 11), ("velocity_lag", 3)],
)
def test_the_hidden_effect_is_named_and_the_error_falls_to_the_floor(
    effect, seed, tmp_path, model
):
    result = improved(effect, seed, tmp_path, model)
    assert result.verdict == "missing_effect"
    assert result.effects == (effect,)
    assert result.rmse_after.held_out < 1.15 * result.noise_floor
    assert result.steps[-1].rmse_held_out < result.steps[0].rmse_held_out
    assert effect in result.model.effects


def test_a_complete_model_is_called_adequate_and_left_alone(tmp_path, model):
    result = improved(None, 7, tmp_path, model)
    assert result.verdict == "adequate"
    assert result.effects == ()
    assert set(result.model.effects) == set(model.effects)


def test_an_effect_outside_the_catalogue_is_not_given_a_known_name(tmp_path, model):
    result = improved("outside:position_periodic", 2, tmp_path, model)
    assert result.verdict in ("unknown_effect", "partial")
    assert result.to_dict()["unexplained"]["depends_on"]


def test_one_sine_at_one_duty_never_gives_a_certain_name(tmp_path, model):
    from test.blind.generator import more_records

    case = make_case("coulomb_friction", 4, n_records=1, seconds=6.0, out=tmp_path / "made")
    data = tmp_path / "data"
    more_records(case, 9, out=data, n_records=3, program="one_sine")
    assert improve(load(data), model).verdict in ("insufficient_data", "ambiguous", "adequate")


def test_compare_says_where_it_fails(tmp_path, model):
    make_case("end_stop", 3, n_records=3, seconds=SECONDS, out=tmp_path / "data")
    result = compare(load(tmp_path / "data"), model)
    assert result.rmse > result.noise_floor
    assert "deflection" in {w["quantity"] for w in result.worst}
