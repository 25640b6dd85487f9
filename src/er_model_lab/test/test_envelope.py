"""What new data do not show stays as it was, and a model that is written can be read again."""

from dataclasses import replace

import pytest
from er_model_lab.fitting.envelope import in_bounds, with_unfelt
from er_model_lab.fitting.fit import Box, fit
from er_models.errors import InputError
from er_models.files import load_model, save_model
from lab_help import GUO, problem_of

DAMPERS = GUO.parent


@pytest.fixture(scope="module")
def made():
    return problem_of(None, {}, seconds=6.0)


def off(problem):
    """The data without a field."""
    return replace(problem, motion=replace(problem.motion, u=0.0 * problem.motion.u))


@pytest.mark.parametrize("name", ["utfsm_mr", "inove_guo_tau_table", "inove_guo"])
@pytest.mark.parametrize("field", [True, False])
def test_what_is_written_is_read_again(name, field, made, tmp_path):
    _, problem = made
    given = load_model(DAMPERS / f"{name}.yaml")
    data = problem if field else off(problem)
    box = Box(given, data.forward.free(given), data.scales)
    written = in_bounds(box.model_at(box.start()), data, given.scales)
    save_model(written, tmp_path / "new.yaml")
    assert load_model(tmp_path / "new.yaml").effects == written.effects
    assert name == "utfsm_mr" or written.scales.force == data.scales.force
    if not field:
        assert written.scales.duty == given.scales.duty


def test_what_is_per_duty_is_neutral_where_a_search_without_a_field_left_a_start_that_no_duty_allows(
    made,
):
    """Of data without a duty its scale is a thousandth: a start of 0.2 forces per duty was 9 kN per duty of 44 N."""
    model, problem = made
    values = {"F_h": 5.0, "F_u": 200.0 * problem.scales.force, "z_y": 2e-4, "b": 1e-4}
    grown = model.with_effect("friction_with_play", values)
    written = in_bounds(grown, off(problem), model.scales)
    assert written.value("friction_with_play", "F_u") == 0.0
    assert written.value("friction_with_play", "F_h") == 5.0
    assert written.effects["guo_yield"] == model.effects["guo_yield"], "which a model brought"
    with pytest.raises(InputError, match="F_u"):
        in_bounds(grown, problem, model.scales)


def test_a_value_beyond_every_bound_is_named_with_what_is_allowed(made):
    model, problem = made
    late = model.with_effect("velocity_lag", {"T_v": 0.07})
    with pytest.raises(
        InputError, match=r"velocity_lag.T_v: expected -0.02 to 0.05 s, found 0.07"
    ):
        in_bounds(late, problem, model.scales)


def test_a_stop_beyond_what_was_recorded_stays_where_it_is_and_one_within_does_not(made):
    model, problem = made
    reach = problem.scales.deflection
    for share, moved in ((3.0, False), (0.5, True)):
        given = model.with_effect(
            "end_stop", {**model.with_effect("end_stop").effects["end_stop"], "x_b": share * reach}
        )
        found = fit(given, problem).model
        kept = with_unfelt(found, given, problem).value("end_stop", "x_b")
        assert (kept != pytest.approx(share * reach, rel=1e-6)) is moved
    assert found.value("end_stop", "x_b") <= 2.0 * reach
