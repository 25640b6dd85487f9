"""An effect in a file of the user's own: the example of CONTRIBUTING.md, and every way to get one wrong."""

import hashlib
import json
import os
import re
import shutil
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from er_common.parameter_table import build as checked
from er_model_lab.cli.app import app
from er_models.catalogue import CATALOGUE, Catalogue
from er_models.errors import InputError
from er_models.files import load_model, save_model
from er_models.own import effects
from er_models.prediction import motion, predict
from er_models.simulation import simulate
from er_plant_sim.build import build
from er_plant_sim.rig import advance, decide, sense, start
from er_plant_sim.settings import table
from typer.testing import CliRunner

from test.conftest import ROOT
from test.sample import write_sample

NAME = "voltage_crosstalk"
CAR = ROOT / "config/vehicles/inove_quarter_car.yaml"
DAMPER = ROOT / "config/dampers/inove_guo.yaml"


def example() -> str:
    """The file in the chapter "Your own effect"."""
    chapter = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8").split("## Your own effect")[1]
    return re.search(r"```python\n(.*?)```", chapter, re.S)[1]


@pytest.fixture(scope="module")
def own(tmp_path_factory):
    """The example as a file."""
    path = tmp_path_factory.mktemp("own") / "crosstalk.py"
    path.write_text(example(), encoding="utf-8")
    return path


def few():
    """What every damper and car has, and the example's rival: little to compile."""
    kept = ("preload", "quarter_car")
    return Catalogue(tuple(e for e in CATALOGUE.effects if e.stage == "core" or e.name in kept))


@pytest.fixture
def both(own, monkeypatch):
    """The example, and an effect of the car, beside few others: one kernel serves every test that simulates."""
    monkeypatch.setattr("er_models.own.CATALOGUE", few())
    folder = own.parent / "both"
    folder.mkdir(exist_ok=True)
    (folder / "bushing.py").write_text(BUSHING, encoding="utf-8")
    return Path(shutil.copy(own, folder)), folder / "bushing.py"


def lab(*words):
    return CliRunner().invoke(app, [str(w) for w in words])


def one_line(result, *words):
    assert result.exit_code == 2, result.output
    lines = [line for line in result.output.strip().splitlines() if line]
    assert len(lines) == 1, result.output
    for word in words:
        assert word in lines[0]


def with_crosstalk(file, *files):
    """A model file's model with the example's effect, of the catalogue with these files."""
    return load_model(file, effects(files)).with_effect(NAME, {"K": 4.0})


def test_the_example_is_about_forty_lines():
    assert 25 < len(example().splitlines()) <= 40


def test_lab_effects_lists_it_and_shows_its_card(own, tmp_path):
    listed = lab("effects", "--effects-from", own, "--json", tmp_path / "e.json")
    assert listed.exit_code == 0, listed.output
    names = [e["effect"] for e in json.loads((tmp_path / "e.json").read_text())["effects"]]
    assert names == [*CATALOGUE.names, NAME]
    card = lab("effects", NAME, "--effects-from", own).output
    assert "F_m := F_m + K u" in card
    assert "[N/duty]" in card or "N/duty" in card
    one_line(lab("effects", NAME), NAME)


DT, N = 0.005, 200
ROAD = 0.003 * np.sin(2 * np.pi * 3.0 * np.arange(N) * DT)


@pytest.mark.slow
def test_the_car_is_simulated_with_it(both):
    duty = np.repeat([0.0, 0.2], N // 2)
    model = with_crosstalk(CAR, *both)
    plain, run = (simulate(m, DT, ROAD, duty) for m in (load_model(CAR), model))
    change = run["damper_force"] - plain["damper_force"]
    assert change == pytest.approx(4.0 * duty, abs=1e-9)
    assert np.array_equal(run["deflection"], plain["deflection"])


def test_its_model_file_loads_with_the_very_file_only(own, tmp_path):
    model = with_crosstalk(DAMPER, own)
    path = tmp_path / "mine.yaml"
    save_model(model, path)
    digest = hashlib.sha256(own.read_bytes()).hexdigest()
    entry = {"file": "crosstalk.py", "sha256": digest, "effects": [NAME]}
    assert yaml.safe_load(path.read_text())["effects_from"] == [entry]
    again = load_model(path, effects([own]))
    assert again.effects == model.effects
    assert again.digest() == model.digest() != load_model(DAMPER).digest()
    with pytest.raises(InputError, match=r"the file crosstalk.py given as --effects-from") as none:
        load_model(path)
    changed = tmp_path / "crosstalk.py"
    changed.write_text(own.read_text().replace("K * u", "K * u * u"))
    with pytest.raises(InputError, match=r"crosstalk.py with the content") as other:
        load_model(path, effects([changed]))
    for caught in (none, other):
        assert "\n" not in str(caught.value)
        assert str(path) in str(caught.value)


@pytest.mark.parametrize(
    "text",
    ["crosstalk.py", "[crosstalk.py]", "[{file: a.py}]", "[{file: a, sha256: b, effects: c}]"],
)
def test_a_broken_record_of_the_file_is_named(text, tmp_path):
    path = tmp_path / "m.yaml"
    path.write_text(DAMPER.read_text() + f"effects_from: {text}\n")
    with pytest.raises(InputError, match=r"effects_from\[0\]"):
        load_model(path)


@pytest.mark.slow
def test_a_changed_equation_is_compiled_anew(own, tmp_path, monkeypatch):
    monkeypatch.setattr("er_models.own.CATALOGUE", few())
    other, own = tmp_path / "crosstalk.py", shutil.copy(own, tmp_path / "own.py")
    other.write_text(own.read_text().replace("K * u", "2.0 * K * u"))
    inputs = motion(0.005, np.zeros(9), np.zeros(9), np.full(9, 0.3))
    forces = [predict(with_crosstalk(DAMPER, path), inputs) for path in (own, other, own)]
    assert forces[0] == pytest.approx(np.full(9, 1.2))
    assert forces[1] == pytest.approx(np.full(9, 2.4))
    assert np.array_equal(forces[0], forces[2])


def test_several_files_join_and_one_given_twice_counts_once(own, tmp_path):
    other = tmp_path / "other.py"
    other.write_text(
        own.read_text().replace(f'"{NAME}"', '"second"').replace("EFFECT = ", "ONE = ")
        + "\n\nEFFECTS = [ONE]\n"
    )
    catalogue = effects([own, other, own])
    assert catalogue.names[-2:] == (NAME, "second")
    assert catalogue is effects([own, other])
    assert {e.name for e in catalogue.candidates()} >= {NAME, "second"}
    assert not {o.file for o in catalogue.origins.values()} ^ {"crosstalk.py", "other.py"}
    assert effects([]) is CATALOGUE
    twin = tmp_path / "twin.py"
    twin.write_text(own.read_text())
    with pytest.raises(InputError, match=f"twin.py: name: .* found {NAME}"):
        effects([own, twin])


@pytest.mark.slow
def test_diagnose_finds_it_by_name_and_add_writes_it(own, tmp_path):
    data = write_sample(tmp_path / "run.csv", seed=1, truth=with_crosstalk(DAMPER, own))
    given = ("--model", DAMPER, "--effects-from", own, "--json", tmp_path / "r.json")
    result = lab("diagnose", data, *given)
    assert result.exit_code == 0, result.output
    r = json.loads((tmp_path / "r.json").read_text())
    assert (r["verdict"], r["effects"]) == ("missing_effect", [NAME])
    assert r["provenance"]["effects_from"][NAME]["file"] == "crosstalk.py"
    out = tmp_path / "mine.yaml"
    result = lab("add", NAME, data, *given, "--out", out)
    assert result.exit_code == 0, result.output
    r = json.loads((tmp_path / "r.json").read_text())
    value, sd, _ = r["candidates"][0]["parameters"]["K"]
    assert abs(value - 4.0) < 4.0 * sd < 1.0
    assert r["steps"][1]["rmse_held_out"] < 0.7 * r["steps"][0]["rmse_held_out"]
    compared = lab(
        "compare", data, "--model", out, "--effects-from", own, "--json", tmp_path / "c.json"
    )
    assert compared.exit_code == 0, compared.output
    c = json.loads((tmp_path / "c.json").read_text())
    assert c["rmse"] < 1.3 * c["noise_floor"]
    one_line(lab("compare", data, "--model", out), "mine.yaml", "crosstalk.py")


def plant(**given):
    return build(checked(table(given), {"model_file": str(CAR), "safe_duty": 0.2} | given, {}))


@pytest.mark.slow
def test_the_plant_runs_a_model_with_it(both, tmp_path):
    save_model(with_crosstalk(DAMPER, *both), tmp_path / "mine.yaml")
    program = str(ROOT / "config/experiments/chirp.yaml")
    given = {"program_file": program, "damper_file": str(tmp_path / "mine.yaml")}
    files = tuple(str(file) for file in both)
    forces = []
    for rig in (plant(program_file=program), plant(**given, effects_from=files)):
        state = start(rig)
        for _ in range(20):
            state = advance(rig, decide(rig, state)[0])
        forces.append((sense(rig, state).force, state.gate.duty))
    assert forces[0][1] > 0.0
    assert forces[1][0] - forces[0][0] == pytest.approx(4.0 * forces[1][1], abs=1e-9)
    with pytest.raises(InputError, match="--effects-from"):
        plant(**given)
    with pytest.raises(InputError, match="found no file"):
        plant(**given, effects_from=("nowhere.py",))


HOOK = "def sense(K: float, f_m: float, u: float) -> float:"
BODY = "return f_m + K * u"
PARAM = '"N/duty", -2.0, 2.0, 0.0, (0.05, -0.05)'
IDLE = 'Param("L", "1", 0.0, 1.0, 0.0, (0.1,), "idle")'
MISTAKES = {
    "syntax": ("EFFECT = Effect(", "EFFECT = Effect((", "line 11", "valid Python"),
    "no effect": ("EFFECT = ", "MINE = ", "EFFECT = Effect(...)", "neither"),
    "not an effect": ("EFFECT = ", "EFFECT = 3\nMINE = ", "an Effect", "int"),
    "fails": ("from er_models", "import nowhere_at_all\nfrom er_models", "line 3", "nowhere_at_all"),
    "exits": ("from er_models", "raise SystemExit(0)\nfrom er_models", "line 3", "SystemExit"),
    "unknown argument": (HOOK, HOOK.replace("u:", "q:"), "line 1", "'q' is no parameter or signal"),
    "signal of elsewhere": (HOOK, HOOK.replace("u:", "z_t:"), f"{NAME}.sense", "'z_t'"),
    "own state of none": (HOOK, HOOK.replace("u:", "w:"), f"{NAME}.sense", "'w'"),
    "unknown hook": ('{"sense": sense}', '{"sensing": sense}', "unknown hook 'sensing'"),
    "unknown strength": ('{"sense": sense}', '{"sense": sense}, within=(("K", 2.0, "Q"),)', "within", "'Q'"),
    "clash": (f'"{NAME}"', '"preload"', "no other effect has", "preload"),
    "bad name": (f'"{NAME}"', '"cross talk"', "letters, digits and _"),
    "bad stage": ('"sensing"', '"sensor"', "one of force", "'sensor'"),
    "unknown rival": ('("preload",)', '("prelude",)', "rivals", "'prelude'"),
    "unknown unit": ("N/duty", "kN/duty", "K.unit", "'kN/duty'"),
    "bounds": ("-2.0, 2.0", "2.0, -2.0", "a lower bound below the upper"),
    "start outside": ("(0.05, -0.05)", "(5.0,)", "K.starts"),
    "neutral outside": (PARAM, PARAM.replace("2.0, 0.0,", "2.0, 9.0,"), "K.neutral"),
    "no neutral": (PARAM, PARAM.replace("2.0, 0.0,", "2.0, None,"), "a neutral value"),
    "not neutral": (BODY, "return f_m + K * u + 0.1", "as without the effect", "at its neutral"),
    "not finite": (BODY, "return f_m + K / u", "a finite value", "u = 0", "nan"),
    "no number": (BODY, 'return "force"', "one number"),
    "not compiled": (BODY, "return f_m + K * len(open('x').read())", "numba can compile", "open"),
    "unused parameter": ("        Param(", f"        {IDLE},\n        Param(", "a parameter of some hook"),
    "parameter like a signal": ("K", "v", "no signal has", "'v'"),
    "a lambda of a closure": ('{"sense": sense}', '{"sense": (lambda c: lambda K, f_m: f_m + c * K)(1.0)}',
                              "a plain function"),
}  # fmt: skip


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_bad_file_is_one_line(mistake, own, tmp_path):
    old, new, *words = MISTAKES[mistake]
    text = own.read_text()
    assert old in text
    path = tmp_path / "mine.py"
    path.write_text(text.replace(old, new))
    one_line(lab("effects", "--effects-from", path), "mine.py", *words)


@pytest.mark.parametrize("content", [None, b"", b"\xff\xfe", b"EFFECT = '\x00'"])
def test_no_file_of_effects_at_all(content, tmp_path):
    path = tmp_path / "mine.py"
    if content is not None:
        path.write_bytes(content)
    one_line(lab("effects", "--effects-from", path), "mine.py")
    one_line(lab("effects", "--effects-from", tmp_path), tmp_path.name, "a folder")


def open_to_all(path):
    path.chmod(0o666)


def given_away(path):
    if os.geteuid() != 0:
        pytest.skip("only root can give a file away")
    os.chown(path, 65534, 65534)


def a_pipe(path):
    path.unlink()
    os.mkfifo(path)


def too_long(path):
    path.write_bytes(path.read_bytes() + b"#" * (1 << 20))


def without_effect(path):
    path.write_text(path.read_text().replace("EFFECT = ", "MINE = "))


@pytest.mark.parametrize(
    ("spoil", "words"),
    [
        (open_to_all, "others may write to it"),
        (given_away, "it belongs to another user"),
        (a_pipe, "it is no ordinary file"),
        (too_long, "it has more than 1048576 bytes"),
        (without_effect, "expected EFFECT = Effect(...), or EFFECTS with several, found neither"),
    ],
)
def test_what_is_refused_has_not_run(spoil, words, own, tmp_path):
    path, mark = tmp_path / "mine.py", tmp_path / "mark"
    path.write_text(f"import os\nos.mkdir({str(mark)!r})\n" + own.read_text())
    effects([path])
    mark.rmdir()  # it would have been seen
    spoil(path)
    one_line(lab("effects", "--effects-from", path), "mine.py", words)
    assert not mark.exists()
    path.unlink()  # it is still a module's file here, and who reads all modules would wait for the pipe for ever


def test_every_command_with_a_model_takes_the_file(own):
    from typer.main import get_command

    for name, command in get_command(app).commands.items():
        options = {option for p in command.params for option in p.opts}
        if "--model" in options:
            assert "--effects-from" in options, name


@pytest.mark.slow
def test_an_effect_of_the_car_may_be_ones_own(both):
    """Damping beside the damper moves the car as the same damping inside it, but the load cell does not see it."""
    catalogue = effects(both)
    beside = replace(load_model(CAR), catalogue=catalogue)
    beside = beside.with_effect("bushing_damping", {"c_b": 9.0})
    values = load_model(CAR).effects["passive"]
    inside = load_model(CAR).with_effect("passive", {**values, "c0": values["c0"] + 9.0})
    wanted, found = (simulate(m, DT, ROAD, 0.0 * ROAD) for m in (inside, beside))
    assert found["deflection"] == pytest.approx(wanted["deflection"], abs=1e-9)
    unseen = 9.0 * found["deflection_velocity"]
    assert wanted["damper_force"] - found["damper_force"] == pytest.approx(unseen, abs=1e-6)
    assert "bushing_damping" not in {e.name for e in catalogue.candidates()}


BUSHING = '''
"""Damping of the bushings."""
from er_models.effect import Effect, Param, Signature


def spring_force(c_b: float, v: float) -> float:
    return c_b * v


EFFECT = Effect(
    "bushing_damping", "vehicle", "Damping of the bushings", "Rubber bushings are viscous.",
    (Param("c_b", "N s/m", 0.0, 2.0, 0.0, (0.05,), "damping"),), {"spring_force": spring_force},
    Signature("none", "acceleration-velocity", "slow sine of the road"), "a test",
)
'''
