"""What the lab says in names of arguments, the command line says in options."""

import pytest
from er_model_lab.cli.options import in_options
from er_model_lab.cli.running import _worded
from er_model_lab.diagnosis.rule import Rule
from er_model_lab.level.investigate import level_of
from er_model_lab.planning.limits import Asked, Limits, limits_of, nothing_fits
from er_model_lab.planning.question import ask
from er_model_lab.results.result import CheckResult
from er_model_lab.verbs.add import _may_add
from er_model_lab.view import View
from er_models.errors import ErError, InputError
from er_models.files import load_model
from lab_help import GUO


def limits(**asked):
    return limits_of(load_model(GUO), Asked(**asked), 0.005)


def no_plan(*between, reveal=None):
    return ask(load_model(GUO), between, reveal)


WRONG = {
    "a rate": (lambda: Rule(false_alarm=0.0), "--false-alarm: expected a rate above 0 and below 1, found 0"),
    "a share": (lambda: Rule(smallest=2.0), "--smallest: expected a share from 0 to 1, found 2"),
    "help": (lambda: Rule(helps=-1.0), "--helps: expected a share from 0 to 1, found -1"),
    "level": (lambda: level_of("wheel"), "--level: expected damper or vehicle, found wheel"),
    "a tyre": (lambda: _may_add(load_model(GUO), "tyre_damping", "damper"), "--level vehicle adds it"),
    "stroke": (lambda: limits(stroke=0.0), "--stroke: expected a number above 0 in m, found 0"),
    "velocity": (lambda: limits(velocity=-1.0), "--velocity: expected a number above 0 in m/s, found -1"),
    "duty": (lambda: limits(duty=1.5), "--duty-max: expected a duty of at most 1, found 1.5"),
    "duration": (lambda: limits(duration=1.0), "--duration: expected 10 to 600 s, found 1"),
    "neither": (no_plan, "either --between EFFECT EFFECT or --reveal EFFECT, found neither"),
    "both": (lambda: no_plan("end_stop", "gas_spring", reveal="end_stop"), "or --reveal EFFECT, found both"),
    "twice": (lambda: no_plan("end_stop", "end_stop"), "--between: expected two different effects, found"),
}  # fmt: skip


@pytest.mark.parametrize("mistake", WRONG)
def test_an_error_names_the_option(mistake):
    work, said = WRONG[mistake]
    with pytest.raises(ErError) as told:
        work()
    assert said in in_options(told.value)
    assert "--" not in str(told.value)


def test_limits_within_which_nothing_fits_are_options():
    told = nothing_fits(Limits(0.012, 0.15, 0.3, 0.036))
    assert "expected limits (--stroke, --velocity, --duration) within" in in_options(told)


def test_a_file_that_holds_such_a_key_is_left_as_it_is():
    told = InputError("run.yaml", "duration", "a number above 0", "-1")
    assert in_options(told) == str(told)


def test_a_result_says_what_to_do_in_options():
    """As `check` and `diagnose` do, in the JSON, on the terminal and on the page."""
    content = {"findings": [{"remedy": "use level='vehicle'"}], "reasons": ["set helps to 0.15"]}
    view = View("check", "run", "", content, (), notes=("anyway=True goes on",))
    told = _worded(CheckResult(view))
    assert told.to_dict() == {
        "findings": [{"remedy": "use --level vehicle"}], "reasons": ["set --helps to 0.15"]
    }  # fmt: skip
    assert told.notes == ("--anyway goes on",)
    assert content["reasons"] == ["set helps to 0.15"]
