"""The Python interface: what `import er_model_lab` offers, and that it stays light."""

import json
import subprocess
import sys

import numpy as np
import pytest
from er_models.files import load_model
from er_models.prediction import motion, predict
from lab_help import GUO, imposed

import er_model_lab as lab

DT = 0.005
HEAVY = {
    "rclpy",
    "typer",
    "rich",
    "matplotlib",
    "plotly",
    "pandas",
    "sklearn",
    "jinja2",
    "er_ros_common",
}


@pytest.fixture(scope="module")
def made():
    """Arrays of a damper with friction that the shipped model does not have."""
    rng = np.random.default_rng(3)
    n = 3000
    x, v, a, u = imposed(rng, n)
    truth = load_model(GUO).with_effect("coulomb_friction", {"F_c": 1.0, "v_0": 0.003})
    force = predict(truth, motion(DT, x, v, u, a)) + 0.15 * rng.standard_normal(n)
    noisy = {
        "deflection": x + 2e-5 * rng.standard_normal(n),
        "deflection_velocity": v + 1e-3 * rng.standard_normal(n),
        "duty": u, "damper_force": force,
    }  # fmt: skip
    return {"t": np.arange(n) * DT, **noisy}


@pytest.fixture(scope="module")
def found(made):
    return lab.diagnose(lab.from_arrays(**made), lab.load_model(GUO), seed=1)


def test_everything_that_is_offered_is_there_and_says_what_it_is():
    for name in lab.__all__:
        thing = getattr(lab, name)
        assert name == "__version__" or (thing.__doc__ or "").strip(), name
    assert set(lab.__all__) <= set(dir(lab))
    with pytest.raises(AttributeError, match="no attribute 'diagnoze'"):
        lab.diagnoze  # noqa: B018


def test_the_import_loads_nothing_heavy_and_a_diagnosis_no_plots():
    """Measured in a process of its own: this one has loaded everything."""
    script = (
        f"import sys, er_model_lab; print({HEAVY!r} & set(sys.modules), 'numpy' in sys.modules)"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    assert done.stdout.split() == ["set()", "False"]
    script = (
        "import sys, er_model_lab as lab\n"
        "for name in lab.__all__: getattr(lab, name)\n"
        f"print({HEAVY!r} & set(sys.modules))"
    )
    done = subprocess.run(
        [sys.executable, "-c", script], capture_output=True, text=True, check=True
    )
    assert done.stdout.strip() == "set()"


def test_a_diagnosis_of_arrays_names_the_effect_with_its_evidence(found):
    assert (found.verdict, found.effects) == ("missing_effect", ("coulomb_friction",))
    assert found.rmse.held_out > 2.0 * found.rmse_after.held_out
    assert found.rmse_after.held_out == pytest.approx(found.noise_floor, rel=0.1)
    (friction,) = found.evidence
    assert friction.status == "present"
    assert friction.size > friction.threshold
    value = friction.parameters["F_c"]
    assert abs(value.value - 1.0) < 4.0 * value.sd
    assert value.unit == "N"
    assert found.model.value("coulomb_friction", "F_c") == value.value
    assert [step.added for step in found.steps] == [None, "coulomb_friction"]


def test_a_result_prints_itself_with_units_and_as_a_table(found):
    text = repr(found)
    assert text.startswith(
        "<DiagnosisResult inove_guo; missing_effect: coulomb_friction; held out "
    )
    assert " N" in text
    assert "\n" not in text
    html = found._repr_html_()
    assert "<table>" in html
    assert "coulomb_friction" in html
    frame = found.to_frame()
    assert next(iter(frame["effect"])) == "coulomb_friction"
    assert "size [N]" in frame.columns


def test_a_result_is_frozen_and_its_dictionary_is_the_json_of_the_command(found):
    with pytest.raises(AttributeError):
        found.model = None
    data = found.to_dict()
    assert json.loads(json.dumps(data)) == data
    assert data["command"] == "diagnose"
    data["effects"].append("changed")
    assert found.effects == ("coulomb_friction",)


def test_a_figure_is_drawn_when_asked_for_and_an_unknown_one_is_named(found, tmp_path):
    assert "residual_maps" in found.figures
    assert found.figure("residual_maps").axes
    with pytest.raises(
        lab.InputError, match=r"figure: expected one of .*residual_maps.*, found nothing"
    ):
        found.figure("nothing")
    assert found.report(tmp_path / "report").read_text(encoding="utf-8").startswith("<!")


def test_a_table_with_its_own_names_and_units_is_the_same_data(made):
    pd = pytest.importorskip("pandas")
    table = pd.DataFrame({
        "Zeit [s]": made["t"], "Weg [mm]": 1e3 * made["deflection"], "v": made["deflection_velocity"],
        "Tastgrad": made["duty"], "Kraft [kN]": 1e-3 * made["damper_force"],
    })  # fmt: skip
    names = {
        "t": "Zeit [s]", "deflection": "Weg [mm]", "deflection_velocity": "v", "duty": "Tastgrad",
        "damper_force": "Kraft [kN]",
    }  # fmt: skip
    (record,) = lab.from_frame(table, names).records
    (plain,) = lab.from_arrays(**made).records
    for channel, samples in plain.channels.items():
        np.testing.assert_allclose(record.channels[channel], samples, rtol=1e-12, atol=1e-12)
    assert any("converted from kN" in note for note in record.notes)


def test_a_table_without_a_time_column_has_it_as_index(made):
    pd = pytest.importorskip("pandas")
    table = pd.DataFrame({k: v for k, v in made.items() if k != "t"}, index=made["t"])
    (record,) = lab.from_frame(table).records
    np.testing.assert_array_equal(record.t, made["t"])


@pytest.mark.parametrize(
    ("change", "said"),
    [
        ({"force": 1.0}, "unknown channel 'force'"),
        ({"duty": [0.0, 0.1]}, "duty: expected 3000 samples"),
        ({"duty": "off"}, "duty: expected numbers, found str"),
    ],
)
def test_arrays_that_are_none_are_refused_in_words(made, change, said):
    with pytest.raises(lab.ErError, match=said):
        lab.from_arrays(**(made | change))


def test_errors_name_arguments_and_no_option_of_the_command_line(made):
    data, model = lab.from_arrays(**made), lab.load_model(GUO)
    for call in (
        lambda: lab.diagnose(data, model, level="car"),
        lambda: lab.diagnose(data, model, held_out=data),
        lambda: lab.diagnose(data, model, rule=lab.Rule(false_alarm=2.0)),
        lambda: lab.add(data, model, "guide_friction"),
        lambda: lab.plan(model),
        lambda: lab.plan(model, between=("gas_spring", "end_stop"), duration=1e9),
    ):
        with pytest.raises(lab.ErError) as raised:
            call()
        assert "--" not in str(raised.value)
        assert "\n" not in str(raised.value)


def test_data_that_only_score_are_not_learnt_from(made):
    half = {name: samples[:1500] for name, samples in made.items()}
    rest = {name: samples[1500:] for name, samples in made.items()}
    data, held = lab.from_arrays(**half), lab.from_arrays(**rest, name="rest")
    result = lab.add(data, lab.load_model(GUO), "coulomb_friction", held_out=held, seed=1)
    assert result.to_dict()["provenance"]["records"] == ["arrays", "rest"]
    assert result.rmse_after.held_out < result.rmse.held_out


def test_comparison_check_and_identification_have_their_own_facts(made):
    data, model = lab.from_arrays(**made), lab.load_model(GUO)
    compared = lab.compare(data, model)
    assert compared.rmse > compared.noise_floor
    assert compared.worst
    assert repr(compared).startswith("<ComparisonResult inove_guo; unexplained ")
    checked = lab.check(data)
    assert checked.verdict == "usable"
    assert {"check", "level"} <= set(checked.to_frame().columns)
    identified = lab.identify(data, model, seed=1)
    assert identified.model.name == "inove_guo_identified"
    assert {"value", "sd", "unit"} <= set(identified.to_frame().columns)
