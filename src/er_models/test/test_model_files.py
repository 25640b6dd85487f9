"""Model files: what is written is read again, and every mistake is one line."""

from __future__ import annotations

from pathlib import Path

import pytest
import yaml
from er_models.catalogue import CATALOGUE
from er_models.errors import ErError, InputError, UnknownName
from er_models.files import load_model, save_model
from er_models.model import Model
from er_models.scales import Scales
from models_help import CONFIG, LARGE, SMALL, bingham, car, guo, started

DAMPER = """
schema: er_model 1
name: some
envelope: {force: 20.0, deflection: 0.01, velocity: 0.15, duty: 0.3}
effects:
  passive:
    k0: {value: 200.0, unit: N/m}
    c0: {value: 60.0, unit: N s/m}
"""


@pytest.mark.parametrize("model", [guo(), bingham(), car()], ids=lambda m: m.name)
def test_round_trip(model: Model, tmp_path: Path) -> None:
    model = model.with_effect("coulomb_friction").with_effect("cavitation")
    model = Model(
        **{**vars(model), "deviations": {"passive": {"k0": 1.5}}, "history": ({"a": 1},)}
    )
    save_model(model, tmp_path / "deep" / "model.yaml")
    again = load_model(tmp_path / "deep" / "model.yaml")
    for field in ("name", "effects", "scales", "source", "deviations", "history", "rig"):
        assert getattr(again, field) == getattr(model, field), field
    assert again.digest() == model.digest()


@pytest.mark.parametrize("scales", [SMALL, LARGE])
def test_round_trip_of_the_whole_catalogue(scales: Scales, tmp_path: Path) -> None:
    model = started(scales, *CATALOGUE.names)
    save_model(model, tmp_path / "all.yaml")
    assert load_model(tmp_path / "all.yaml").effects == model.effects


def test_infinity_can_be_written(tmp_path: Path) -> None:
    model = guo().with_effect("cavitation", {"F_v": float("inf")})
    save_model(model, tmp_path / "m.yaml")
    assert load_model(tmp_path / "m.yaml").value("cavitation", "F_v") == float("inf")


def test_vehicle_refers_to_its_damper() -> None:
    assert car().is_vehicle
    assert not guo().is_vehicle
    assert car().effects["guo_yield"] == guo().effects["guo_yield"]
    assert car().scales == guo().scales


MISTAKES = {
    "unknown key": ("name: some", "nome: some", "nome: expected one of schema, name"),
    "wrong schema": ("er_model 1", "er_model 9", "schema: expected 'er_model 1', found 'er_model 9'"),
    "unknown effect": ("passive:", "pasive:", "effects.pasive: expected an effect of the catalogue"),
    "near effect": ("passive:", "pasive:", "did you mean passive"),
    "unknown parameter": ("k0:", "k_0:", "effects.passive.k_0: expected one of k0, c0"),
    "wrong unit": ("N/m}", "N/mm}", "effects.passive.k0.unit: expected N/m, found N/mm"),
    "out of bounds": ("60.0", "-60.0", "effects.passive.c0: expected 0 to"),
    "far out of bounds": ("200.0", "2e9", "effects.passive.k0: expected -4000 to 4e+04 N/m, found 2e"),
    "not a number": ("200.0", "stiff", "effects.passive.k0.value: expected a number, found 'stiff'"),
    "NaN": ("200.0", ".nan", "effects.passive.k0.value: expected a number, found nan"),
    "infinite": ("200.0", ".inf", "effects.passive.k0: expected -4000 to"),
    "yes": ("200.0", "yes", "effects.passive.k0.value: expected a number, found True"),
    "no value": ("value: 200.0, ", "", "effects.passive.k0.value: expected a number, found None"),
    "unknown value key": ("value: 60.0", "valeu: 60.0", "effects.passive.c0.valeu: expected one of"),
    "missing parameter": (
        "    c0: {value: 60.0, unit: N s/m}\n", "", "effects.passive.c0: expected a value in N s/m"
    ),
    "no mapping": ("  passive:\n    k0: {value: 200.0, unit: N/m}\n    c0: {value: 60.0, unit: N s/m}",
                   "  - passive", "effects: expected a mapping"),
    "negative envelope": ("force: 20.0", "force: -20.0", "envelope.force: expected a number above 0"),
    "missing envelope": ("force: 20.0, ", "", "envelope.force: expected a number above 0, found nothing"),
    "unknown envelope": ("duty: 0.3", "duty: 0.3, heat: 1.0", "envelope.heat: expected one of"),
    "history in words": ("name: some", "history: [measured by hand]", "history.0: expected a mapping of names"),
    "history no list": ("name: some", "history: {a: 1}", "history: expected a list of mappings, found dict"),
    "broken YAML": ("effects:", "effects: [", "expected valid YAML"),
    "absent damper": ("name: some", "damper: nowhere.yaml", "nowhere.yaml: expected a model file, found no file"),
}  # fmt: skip


@pytest.mark.parametrize("mistake", MISTAKES)
def test_a_mistake_is_one_line(mistake: str, tmp_path: Path) -> None:
    old, new, message = MISTAKES[mistake]
    assert old in DAMPER
    path = tmp_path / "model.yaml"
    path.write_text(DAMPER.replace(old, new), encoding="utf-8")
    with pytest.raises(ErError) as caught:
        load_model(path)
    assert message in str(caught.value)
    assert str(path.parent) in str(caught.value)
    assert "\n" not in str(caught.value)
    assert caught.value.exit_status == 2


def test_the_unspoilt_file_is_good(tmp_path: Path) -> None:
    path = tmp_path / "model.yaml"
    path.write_text(DAMPER, encoding="utf-8")
    assert load_model(path).value("passive", "c0") == 60.0


@pytest.mark.parametrize("content", [b"\xff\xfe\x00", b"", b"- 1\n- 2\n", b"a: b: c"])
def test_no_model_file_at_all(content: bytes, tmp_path: Path) -> None:
    path = tmp_path / "model.yaml"
    path.write_bytes(content)
    with pytest.raises(InputError) as caught:
        load_model(path)
    assert str(path) in str(caught.value)
    assert "\n" not in str(caught.value)


def test_what_an_effect_was_given_later_is_neutral_in_a_file_that_does_not_name_it(
    tmp_path: Path,
) -> None:
    path = tmp_path / "model.yaml"
    path.write_text(DAMPER + "  freeplay: {b: 1.0e-4}\n", encoding="utf-8")
    assert load_model(path).effects["freeplay"] == {"b": 1e-4, "q": 0.0}
    path.write_text(DAMPER + "  freeplay: {q: 1.0e-5}\n", encoding="utf-8")
    with pytest.raises(InputError, match=r"effects.freeplay.b: expected a value in m"):
        load_model(path)


def test_a_folder_is_no_model(tmp_path: Path) -> None:
    with pytest.raises(InputError, match="found a folder"):
        load_model(tmp_path)


def test_a_file_that_names_itself_as_damper(tmp_path: Path) -> None:
    path = tmp_path / "model.yaml"
    path.write_text(DAMPER + "damper: model.yaml\n", encoding="utf-8")
    with pytest.raises(InputError, match="damper: expected another file"):
        load_model(path)


def test_saving_where_nothing_can_be_saved_overwrites_nothing(tmp_path: Path) -> None:
    blocker = tmp_path / "file"
    blocker.write_text("kept", encoding="utf-8")
    with pytest.raises(InputError, match="a folder that can be written to"):
        save_model(guo(), blocker / "model.yaml")
    assert blocker.read_text(encoding="utf-8") == "kept"
    with pytest.raises(InputError):
        save_model(guo(), tmp_path)
    assert [p.name for p in tmp_path.iterdir()] == ["file"]


def test_digest_follows_the_behaviour_only() -> None:
    model = guo()
    renamed = Model(**{**vars(model), "name": "other", "source": "elsewhere"})
    reordered = Model(**{**vars(model), "effects": dict(reversed(model.effects.items()))})
    assert renamed.digest() == reordered.digest() == model.digest()
    values = {**model.effects["passive"], "k0": 263.1169}
    assert model.with_effect("passive", values).digest() != model.digest()
    assert model.with_effect("preload").digest() != model.digest()


def test_unknown_names_in_code() -> None:
    with pytest.raises(UnknownName, match="did you mean coulomb_friction"):
        guo().with_effect("coulomb_frictoin")
    with pytest.raises(UnknownName, match="parameter of passive 'k1'"):
        Model("m", {"passive": {"k1": 1.0}}, SMALL)


def test_a_model_in_code_needs_every_parameter() -> None:
    with pytest.raises(InputError, match=r"passive\.c0: expected a value in N s"):
        Model("m", {"passive": {"k0": 1.0}}, SMALL)


@pytest.mark.parametrize(
    "path", sorted(CONFIG.glob("dampers/*.yaml")) + sorted(CONFIG.glob("vehicles/*.yaml"))
)
def test_the_models_of_the_repository_name_their_source(path: Path) -> None:
    assert load_model(path).source
    assert yaml.safe_load(path.read_text(encoding="utf-8"))["schema"] == "er_model 1"


def test_no_effect_takes_a_value_that_it_does_not_have():
    model = guo()
    with pytest.raises(UnknownName, match="did you mean F_u or F_h"):
        model.with_effect("friction_with_play", {"F_p": 2.0})
    assert (
        model.with_effect("friction_with_play", {"F_h": 2.0}).value("friction_with_play", "F_h")
        == 2.0
    )
