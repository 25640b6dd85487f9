"""Start models of any kind and size, with and without a duty; rigs that later data leave; identify without a field."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from er_model_lab.cli.app import app
from er_model_lab.fitting.kinds import KINDS
from er_models.effect import arguments
from er_models.files import load_model, save_model
from er_models.prediction import motion, predict
from lab_help import GUO, imposed
from typer.testing import CliRunner

import er_model_lab as lab
from er_models import files

DT, N = 0.005, 3000
SIZES = ((20.0, 0.005), (1500.0, 0.04), (50e3, 0.2))
"""Force [N] and stroke [m]."""


def measured(force: float, stroke: float, *, duty: bool, n: int = N):
    """A damper of any size with friction and unequal damping, along a motion of its own size."""
    rng = np.random.default_rng(3)
    x, v, _, u = imposed(rng, n)
    scale = stroke / np.max(np.abs(x))
    x, v, u = scale * x, scale * v, u / np.max(u)
    slope = np.where(v > 0.0, 0.6, 0.3) * force / np.max(np.abs(v))
    width = 0.02 * np.max(np.abs(v))
    F = slope * v + 0.1 * force * np.tanh(v / width)
    F += 0.3 * force * u * np.tanh(v / width) if duty else 0.0
    F += 2e-3 * force * rng.standard_normal(n)
    more = {"duty": u} if duty else {}
    return lab.from_arrays(
        np.arange(n) * DT, deflection=x, deflection_velocity=v, damper_force=F, **more
    )


@pytest.mark.parametrize("size", SIZES)
@pytest.mark.parametrize("kind", sorted(KINDS))
@pytest.mark.parametrize("duty", [True, False])
def test_a_start_model_has_the_size_and_the_rig_of_its_data(
    size: tuple[float, float], kind: str, duty: bool, tmp_path: Path
) -> None:
    force, stroke = size
    data = measured(force, stroke, duty=duty)
    model = lab.new(data, kind, name="mine")
    assert tuple(model.effects) == KINDS[kind].effects
    assert model.rig["stroke"] == pytest.approx(stroke)
    assert ("duty_max" in model.rig) is duty
    (record,) = data.records
    u = record.channels.get("duty", np.zeros(N))
    left = record.channels["damper_force"] - predict(
        model, motion(DT, record.channels["deflection"], record.channels["deflection_velocity"], u)
    )
    spread = np.std(record.channels["damper_force"])
    assert (
        np.sqrt(np.mean(left**2))
        < (0.6 if duty and kind in ("passive", "friction") else 0.4) * spread
    )
    save_model(model, tmp_path / "mine.yaml")
    assert load_model(tmp_path / "mine.yaml").effects == model.effects


def test_a_start_model_is_one_that_the_lab_adds_to() -> None:
    data = measured(1500.0, 0.04, duty=False, n=1200)
    result = lab.add(data, lab.new(data, "passive"), "coulomb_friction")
    assert result.model.value("coulomb_friction", "F_c") == pytest.approx(150.0, rel=0.1)


@pytest.mark.parametrize("kind", ["passive", "friction"])
def test_identify_needs_no_duty_where_the_model_follows_none(kind: str) -> None:
    data = measured(1500.0, 0.04, duty=False)
    result = lab.identify(data, lab.new(data, kind))
    assert result.model.effects.keys() == {*KINDS[kind].effects}
    assert result.to_dict()["rmse_after"]["train"] <= 1.001 * result.to_dict()["rmse"]["train"]
    with pytest.raises(lab.MissingChannel, match="duty"):
        lab.identify(data, lab.load_model("inove_guo"))


def test_every_kind_without_field_follows_no_duty() -> None:
    model = lab.load_model("inove_guo")
    for kind in ("passive", "friction"):
        for effect in KINDS[kind].effects:
            hooks = model.catalogue[effect].hooks
            assert "target" not in hooks
            assert not any("u" in arguments(h) for h in hooks.values())


def test_a_rig_that_the_data_leave_is_rewritten_and_kept_in_the_history() -> None:
    data = measured(1500.0, 0.04, duty=True)
    guo = load_model(GUO)
    grown = lab.add(data, guo, "coulomb_friction")
    assert grown.model.rig["stroke"] == pytest.approx(0.04, rel=0.02)
    assert grown.model.rig["duty_max"] == pytest.approx(1.0)
    assert "force_noise" not in grown.model.rig
    last = grown.model.history[-1]
    assert last["rig_before"] == dict(guo.rig)
    assert last["envelope_before"]["force"] == guo.scales.force
    assert [n for n in grown.to_dict()["notes"] if n.startswith("the data leave the model's rig")]
    again = lab.add(data, replace(grown.model, file=""), "preload")
    assert "rig_before" not in again.model.history[-1]
    assert not [n for n in again.to_dict()["notes"] if "model's rig" in n]


def test_a_constant_force_joins_the_model_or_is_named() -> None:
    (record,) = measured(1500.0, 0.04, duty=False).records
    x, force = record.channels["deflection"], record.channels["damper_force"]

    def with_constant(constant: float):
        return lab.from_arrays(record.t, deflection=x, damper_force=force + constant)

    gas = lab.new(with_constant(-1200.0), "passive")
    assert gas.value("preload", "F_0") == pytest.approx(-1200.0, rel=0.05)
    with pytest.raises(lab.InputError, match=r"offset: 1e\+04|offset: 9"):
        lab.new(with_constant(-1e4), "passive")


PAGE = Path(__file__).parents[3] / "docs" / "model_file.md"


def test_the_example_of_the_page_is_a_model_and_every_key_is_explained(tmp_path: Path) -> None:
    text = PAGE.read_text(encoding="utf-8")
    (tmp_path / "strut.yaml").write_text(text.split("```yaml\n")[1].split("```")[0])
    assert lab.load_model(tmp_path / "strut.yaml").deviations == {"passive": {"k0": 120.0}}
    assert all(f"| `{key}` |" in text for key in files._KEYS)
    for kind, each in KINDS.items():
        assert f"| `{kind}` |" in text
        assert all(f"`{effect}`" in text for effect in each.effects)


def run(*words: str) -> tuple[int, str, str]:
    """Exit status, output and errors of a command."""
    done = CliRunner().invoke(app, words)
    return done.exit_code, done.stdout, done.stderr


def table(path: Path) -> Path:
    """A small record as a file."""
    (record,) = measured(1500.0, 0.04, duty=False).records
    columns = {"t": record.t, **record.channels}
    rows = np.column_stack(list(columns.values()))
    np.savetxt(path, rows, delimiter=",", header=",".join(columns), comments="")
    return path


def test_the_commands_write_and_list(tmp_path: Path) -> None:
    data, out, result = table(tmp_path / "run.csv"), tmp_path / "m.yaml", tmp_path / "r.json"
    words = ("new", "mine", "--from", str(data), "--out", str(out), "--kind", "passive")
    status, shown, _ = run(*words, "--json", str(result))
    assert status == 0
    assert "stroke 0.04" in shown
    assert json.loads(result.read_text())["rig"]["stroke"] == pytest.approx(0.04)
    assert lab.load_model(out).name == "mine"
    before = out.read_text()
    status, _, said = run(*words)
    assert (status, said.count("\n"), "--replace" in said) == (2, 1, True)
    assert out.read_text() == before
    assert run(*words, "--replace")[0] == 0
    status, shown, _ = run("models", "--json", str(result))
    assert status == 0
    found = json.loads(result.read_text())
    assert {*found["kinds"]} == {*KINDS}
    kinds = {m["name"]: m["kind"] for m in found["models"]}
    assert {*kinds.values()} == {"er", "mr", "passive", "friction", "car"}
    for name, kind in {
        "monotube_passive": "passive",
        "mr_hysteretic": "mr",
        "friction_brake": "friction",
    }.items():
        assert kinds[name] == kind
    assert kinds["inove_guo"] == "er"
    assert all(m["name"] in shown for m in found["models"])


@pytest.mark.parametrize(
    ("words", "said"),
    [
        (("--kind", "magic"), "unknown kind 'magic'; known: er, mr, passive, friction"),
        (("--kind", "er", "--out", "run.csv"), "run.csv"),
    ],
)
def test_what_is_wrong_is_one_line(
    words: tuple[str, ...], said: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    monkeypatch.chdir(tmp_path)
    table(tmp_path / "run.csv")
    status, _, error = run("new", "mine", "--from", "run.csv", "--out", "m.yaml", *words)
    assert (status, error.count("\n")) == (2, 1)
    assert said in error
    assert not (tmp_path / "m.yaml").exists()
