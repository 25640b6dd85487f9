"""The command line of the lab: contract of its results, and one clear line for every bad input."""

import json
import shutil

import numpy as np
import pytest
from er_model_lab.cli.app import app
from er_model_lab.verbs.diagnose import diagnose
from er_model_lab.verbs.improve import MOST_PASSES
from er_model_lab.verbs.load import load
from er_models.files import load_model
from er_models.seed import LARGEST
from typer import TyperException
from typer.testing import CliRunner

from test.sample import write_sample

MODEL = "config/dampers/inove_guo.yaml"
KEYS = {
    "verdict", "effects", "alternatives", "noise_floor", "rmse", "nrmse", "explainable", "candidates", "steps",
}  # fmt: skip
VERDICTS = {
    "adequate",
    "missing_effect",
    "ambiguous",
    "partial",
    "unknown_effect",
    "insufficient_data",
}


@pytest.fixture(scope="module")
def data(tmp_path_factory):
    """Twenty seconds of a damper with Coulomb friction, motion and force with noise."""
    return write_sample(tmp_path_factory.mktemp("data") / "run.csv", seed=1)


def lab(*words):
    return CliRunner().invoke(app, [str(w) for w in words])


def test_diagnose_writes_the_json_of_the_contract(data, root, tmp_path):
    result = lab(
        "diagnose", data, "--model", root / MODEL, "--json", tmp_path / "r.json", "--seed", 3
    )
    assert result.exit_code == 0, result.output
    r = json.loads((tmp_path / "r.json").read_text())
    assert set(r) >= KEYS
    assert r["verdict"] in VERDICTS
    assert r["effects"] == ["coulomb_friction"]
    assert set(r["rmse"]) >= {"train", "held_out"}
    first = r["candidates"][0]
    assert first["effect"] == "coulomb_friction"
    value, sd, unit = first["parameters"]["F_c"]
    assert unit == "N"
    assert abs(value - 1.0) < 4.0 * sd
    assert {c["status"] for c in r["candidates"]} <= {
        "present",
        "absent",
        "not_excited",
        "confounded",
    }


def test_add_shows_the_fall_and_the_new_model_loads(data, root, tmp_path):
    out = tmp_path / "better.yaml"
    result = lab(
        "add", "coulomb_friction", data, "--model", root / MODEL, "--out", out, "--json", tmp_path / "r.json",
        "--report", tmp_path / "report",
    )  # fmt: skip
    assert result.exit_code == 0, result.output
    r = json.loads((tmp_path / "r.json").read_text())
    assert [s["added"] for s in r["steps"]] == [None, "coulomb_friction"]
    assert r["steps"][1]["rmse_held_out"] < 0.7 * r["steps"][0]["rmse_held_out"]
    assert r["steps"][1]["evidence"] > 3.0 * r["steps"][1]["threshold"] > 0.0
    assert (r["steps"][1]["blocks"], r["steps"][1]["records"]) == (1.0, 1.0)
    model = load_model(out)
    assert model.value("coulomb_friction", "F_c") == pytest.approx(1.0, abs=0.1)
    assert model.history[-1]["added"] == ["coulomb_friction"]
    page = (tmp_path / "report" / "index.html").read_text()
    assert "coulomb" in page.lower()


def test_an_effect_that_is_added_in_vain_is_said_to_be(data, root, tmp_path):
    json_file, out = tmp_path / "r.json", tmp_path / "m.yaml"
    words = ["--model", root / MODEL, "--out", out, "--json", json_file]
    result = lab("add", "end_stop", data, *words)
    assert result.exit_code == 0, result.output
    assert "End stop (bump rubber) does not explain the error" in result.output
    assert "catalogue" not in result.output
    first, second = json.loads(json_file.read_text())["steps"]
    assert (first["added"], second["added"]) == (None, "end_stop")
    assert second["rmse_held_out"] == pytest.approx(first["rmse_held_out"], rel=0.02)
    assert "end_stop" in load_model(out).effects


@pytest.mark.slow
def test_improve_is_the_same_twice(data, root, tmp_path):
    results = []
    for name in ("a", "b"):
        json_file = tmp_path / f"{name}.json"
        lab(
            "improve",
            data,
            "--model",
            root / MODEL,
            "--out",
            tmp_path / "m.yaml",
            "--json",
            json_file,
        )
        r = json.loads(json_file.read_text())
        r.pop("provenance")
        results.append(r)
    assert results[0] == results[1]
    assert results[0]["final_verdict"] == "adequate"


def test_improve_refits_a_model_that_lacks_nothing(root, tmp_path):
    given = load_model(root / MODEL)
    values = {**given.effects["passive"], "c0": 1.3 * given.value("passive", "c0")}
    truth = given.without_effect("passive").with_effect("passive", values)
    data, out = write_sample(tmp_path / "run.csv", seed=6, truth=truth), tmp_path / "new.yaml"
    result = lab(
        "improve", data, "--model", root / MODEL, "--out", out, "--json", tmp_path / "r.json"
    )
    assert result.exit_code == 0, result.output
    r = json.loads((tmp_path / "r.json").read_text())
    assert (r["verdict"], r["effects"]) == ("adequate", [])
    model = load_model(out)
    assert model.value("passive", "c0") == pytest.approx(values["c0"], rel=0.03)
    assert model.history[-1]["added"] == []


def test_compare_writes_its_json(data, root, tmp_path):
    result = lab("compare", data, "--model", root / MODEL, "--json", tmp_path / "r.json")
    assert result.exit_code == 0, result.output
    r = json.loads((tmp_path / "r.json").read_text())
    assert {"rmse", "nrmse", "noise_floor", "explainable", "worst"} <= set(r)
    assert r["rmse"] > 2.0 * r["noise_floor"]


def test_compare_says_what_lies_beyond_what_a_model_was_fitted_to(data, root, tmp_path):
    fitted, further = tmp_path / "fitted.yaml", tmp_path / "further.csv"
    made = lab("add", "coulomb_friction", data, "--model", root / MODEL, "--out", fitted)
    assert made.exit_code == 0, made.output
    within = lab("compare", data, "--model", fitted, "--json", tmp_path / "within.json")
    assert within.exit_code == 0, within.output
    assert json.loads((tmp_path / "within.json").read_text())["beyond"] is None
    head, *rows = data.read_text().splitlines()
    same = [name in ("t", "duty", "damper_force") for name in head.split(",")]
    table = np.loadtxt(rows, delimiter=",") * np.where(same, 1.0, 3.0)
    np.savetxt(further, table, "%.9g", delimiter=",", header=head, comments="")
    result = lab("compare", further, "--model", fitted, "--json", tmp_path / "further.json")
    assert result.exit_code == 0, result.output
    r = json.loads((tmp_path / "further.json").read_text())
    assert r["beyond"]["share"] > 0.1
    assert r["beyond"]["rms_beyond"] > r["beyond"]["rms_inside"]
    assert "beyond what 'fitted' was fitted to (deflection" in " ".join(r["notes"])


def test_effects_lists_the_catalogue_and_shows_a_card():
    listed = lab("effects")
    assert listed.exit_code == 0
    assert "coulomb_friction" in listed.output
    card = lab("effects", "coulomb_friction")
    assert "tanh" in card.output
    assert lab("effects", "coulomb_fricton").exit_code == 2


def test_the_catalogue_takes_the_options_of_all_commands(tmp_path):
    for level, car in (("damper", False), ("vehicle", True)):
        listed = lab("effects", "--level", level, "--seed", 1, "--json", tmp_path / "e.json")
        assert listed.exit_code == 0
        assert ("tyre_damping" in listed.output) == car
        names = [e["effect"] for e in json.loads((tmp_path / "e.json").read_text())["effects"]]
        assert ("tyre_damping" in names) == car
    assert lab("effects", "tyre_damping", "--report", tmp_path / "card").exit_code == 0
    page = (tmp_path / "card" / "index.html").read_text()
    assert "data:image/svg+xml" in page
    assert "F_t += c_t v_t" in page


def test_places_that_cannot_be_written_are_named_before_anything_is_computed(data, root, tmp_path):
    file = tmp_path / "file"
    file.write_text("in the way")
    model, nothing = ["--model", root / MODEL], tmp_path / "absent.csv"
    for option, place in (("--json", file / "r.json"), ("--report", file), ("--json", tmp_path)):
        one_line(lab("diagnose", nothing, *model, option, place), 2, option, str(place))
    one_line(lab("improve", nothing, *model, "--out", file / "new.yaml"), 2, "--out", "file")


@pytest.mark.parametrize(
    ("words", "said"),
    [
        ("compare x.csv --model m.yaml --seed abc", "lab compare: invalid value for '--seed': "),
        ("compare x.csv", "lab compare: missing option '--model' (lab compare --help)"),
        ("compare --model m.yaml", "lab compare: missing argument 'DATA' (lab compare --help)"),
        ("compare x.csv --frob", "lab compare: no such option: --frob (lab compare --help)"),
        ("compare x.csv --model", "lab compare: option '--model' requires an argument (lab c"),
        ("plan --between preload", "lab plan: option '--between' requires 2 arguments (lab plan "),
        ("comprae", "lab: no such command 'comprae'. Did you mean 'compare'? (lab --help)"),
        ("thesis chapter1", "lab: 'thesis' is now './er study thesis' (lab --help)"),
        ("import mts x --out y", "lab: 'import' is now './er study import' (lab --help)"),
    ],
)
def test_wrong_usage_is_one_line_with_the_way_to_help(words, said):
    result = CliRunner().invoke(app, words.split(), prog_name="lab")
    one_line(result, 2, said)
    assert result.stdout == ""


@pytest.mark.parametrize("found", ["-1", "4294967296", "123456789012345678901234", "abc", "1.5"])
@pytest.mark.parametrize("command", ["compare x.csv", "plan --reveal preload", "effects"])
def test_a_seed_that_is_none_is_named(command, found):
    allowed = "expected a whole number from 0 to 4294967295, found "
    one_line(lab(*command.split(), "--seed", found), 2, "--seed", allowed + found)


@pytest.mark.slow
def test_the_largest_seed_lasts_to_the_last_pass_of_improve(data, root):
    seed = LARGEST + 1000 * MOST_PASSES
    found = diagnose(load(data), load_model(root / MODEL), seed=seed)
    assert found.effects == ("coulomb_friction",)


def test_a_caller_who_is_no_program_goes_on():
    app(["effects", "preload"], standalone_mode=False)
    with pytest.raises(TyperException, match="No such option"):
        app(["effects", "--frob"], standalone_mode=False)


def test_nothing_asked_shows_the_help():
    result = lab()
    assert result.exit_code == 2
    assert len(result.output.splitlines()) > 10


@pytest.mark.parametrize(
    "words",
    [
        "compare DATA --model M --json DATA",
        "compare FOLDER --model M --json DATA",
        "compare FOLDER --model M --json NAMES",
        "compare FOLDER --model M --json LINK",
        "compare ../FOLDER --model M --hold-out DATA --json DATA",
        "compare FOLDER --model M --model N --json N",
        "compare BAG --model M --json BAG/metadata.yaml",
        "compare BAG --model M --report BAG",
        "check DATA --json DATA",
        "diagnose FOLDER --model M --effects-from OWN --json OWN",
        "identify DATA --model M --out DATA",
        "improve FOLDER --model M --out DATA",
        "add preload FOLDER --model M --out NEW --json NEW",
        "add preload FOLDER --model M --out REPORT/index.html --report REPORT",
        "plan --model M --reveal preload --out M",
        "plan --model M --vehicle N --reveal preload --out N",
        "plan --model M --data FOLDER --reveal preload --json DATA",
        "effects --effects-from OWN --json OWN",
    ],
)
def test_no_result_goes_where_something_is_read_or_another_result(words, root, tmp_path):
    folder = tmp_path / "FOLDER"
    bag = tmp_path / "BAG"
    folder.mkdir()
    bag.mkdir()
    of = {
        "DATA": folder / "run.csv", "NAMES": folder / "run.csv.names.yaml", "M": tmp_path / "m.yaml",
        "N": tmp_path / "n.yaml", "OWN": tmp_path / "own.py", "BAG/metadata.yaml": bag / "metadata.yaml",
    }  # fmt: skip
    for path in of.values():
        path.write_text("as it was")
    of |= {"FOLDER": folder, "../FOLDER": folder / ".." / "FOLDER", "BAG": bag}
    of |= {"REPORT": tmp_path / "report", "REPORT/index.html": tmp_path / "report" / "index.html"}
    of |= {"NEW": tmp_path / "new.yaml", "LINK": tmp_path / "link.json"}
    of["LINK"].symlink_to(of["DATA"])
    one_line(lab(*(of.get(w, w) for w in words.split())), 2, "expected another place than")
    kept = [p for p in tmp_path.rglob("*") if p.is_file()]
    assert {p.read_text() for p in kept} == {"as it was"}
    assert not of["NEW"].exists()


def test_results_may_lie_beside_the_data(data, root, tmp_path):
    folder = tmp_path / "runs"
    folder.mkdir()
    shutil.copy(data, folder / "run.csv")
    words = ["compare", folder, "--model", root / MODEL, "--json", folder / "r.json"]
    for _ in range(2):  # also where it has been written before
        result = lab(*words)
        assert result.exit_code == 0, result.output


def one_line(result, status, *words):
    assert result.exit_code == status, result.output
    lines = [line for line in result.output.strip().splitlines() if line]
    assert len(lines) == 1, result.output
    for word in words:
        assert word in lines[0]


BROKEN = {
    "absent.csv": (None, 2, ("absent.csv",)),
    "empty.csv": ("", 2, ("empty.csv",)),
    "columns.csv": ("t,deflektion,damper_force\n0,0,0\n0.005,0,0\n", 2, ("deflektion",)),
    "few.csv": ("t,deflection,damper_force\n0,0,0\n0.005,0,0\n", 2, ("few.csv",)),
}


@pytest.mark.parametrize("name", BROKEN)
def test_bad_data_gets_one_line_and_nothing_is_written(name, root, tmp_path):
    text, status, words = BROKEN[name]
    path, out = tmp_path / name, tmp_path / "new.yaml"
    if text is not None:
        path.write_text(text)
    one_line(lab("improve", path, "--model", root / MODEL, "--out", out), status, *words)
    assert not out.exists()


def shifted(data, path, change):
    rows = data.read_text().splitlines()
    head, body = rows[0], [r.split(",") for r in rows[1:]]
    path.write_text("\n".join([head, *(",".join(r) for r in change(body))]) + "\n")
    return path


def test_unsorted_time_is_named(data, root, tmp_path):
    def swap(rows):
        rows[100], rows[101] = rows[101], rows[100]
        return rows

    path = shifted(data, tmp_path / "unsorted.csv", swap)
    one_line(lab("compare", path, "--model", root / MODEL), 2, "unsorted.csv", "t")


def test_a_run_of_nan_is_cut_and_the_status_says_so(data, root, tmp_path):
    def hole(rows):
        for row in rows[2000:2100]:
            row[4] = "nan"
        return rows

    path = shifted(data, tmp_path / "holes.csv", hole)
    result = lab("compare", path, "--model", root / MODEL, "--json", tmp_path / "r.json")
    assert result.exit_code == 3
    assert json.loads((tmp_path / "r.json").read_text())["complete"] is False


def test_a_missing_channel_has_its_own_status(data, root, tmp_path):
    rows = [line.split(",") for line in data.read_text().splitlines()]
    keep = [i for i, name in enumerate(rows[0]) if name != "damper_force"]
    path = tmp_path / "noforce.csv"
    path.write_text("\n".join(",".join(r[i] for i in keep) for r in rows) + "\n")
    one_line(lab("compare", path, "--model", root / MODEL), 4, "damper_force", "noforce.csv")


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("f_c:", "f_q:", ("guo_yield.f_q", "unknown key")),
        ("29.2780", "29278.0", ("guo_yield.f_c", "29278")),
        ("29.2780", ".nan", ("guo_yield.f_c", "nan")),
        ("unit: N/duty", "unit: kN", ("unit", "kN")),
        ("schema: er_model 1", "schema: er_model 9", ("schema",)),
    ],
)
def test_a_bad_model_file_is_named_by_key(old, new, words, data, root, tmp_path):
    path = tmp_path / "model.yaml"
    path.write_text((root / MODEL).read_text().replace(old, new))
    one_line(lab("compare", data, "--model", path), 2, "model.yaml", *words)


def test_add_refuses_what_makes_no_sense(data, root, tmp_path):
    out = tmp_path / "new.yaml"
    one_line(
        lab("add", "coulomb_frction", data, "--model", root / MODEL, "--out", out),
        2,
        "coulomb_friction",
    )
    one_line(lab("add", "passive", data, "--model", root / MODEL, "--out", out), 2, "already")
    copy = tmp_path / "own.yaml"
    shutil.copy(root / MODEL, copy)
    one_line(lab("add", "preload", data, "--model", copy, "--out", copy), 2, "own.yaml")
    assert copy.read_text() == (root / MODEL).read_text()


def test_levels_are_named(data, root):
    one_line(lab("diagnose", data, "--model", root / MODEL, "--level", "vehicle"), 2, "vehicle")
    one_line(lab("compare", data, "--model", root / MODEL, "--level", "wheel"), 2, "wheel")
