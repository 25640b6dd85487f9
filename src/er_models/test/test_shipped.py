"""What comes with the package is found by its name, wherever the package lies."""

from __future__ import annotations

from pathlib import Path

import pytest
from er_models.card import card_markdown
from er_models.catalogue import CATALOGUE
from er_models.errors import InputError
from er_models.files import load_model
from er_models.shipped import MODELS, file_of, names, shipped

ROOT = Path(__file__).resolve().parents[3]


@pytest.mark.parametrize("kind", ["dampers", "vehicles", "gains", "experiments"])
def test_what_is_shipped_is_what_config_holds(kind: str) -> None:
    there = sorted((ROOT / "config" / kind).glob("*.yaml"))
    assert there
    assert names(kind) == tuple(path.stem for path in there)
    assert all(shipped(path.stem, kind).read_text() == path.read_text() for path in there)


def test_every_effect_has_its_card() -> None:
    assert set(names("cards")) == {effect.name for effect in CATALOGUE.effects}
    card = shipped("freeplay", "cards")
    assert card.read_text(encoding="utf-8") == card_markdown(CATALOGUE["freeplay"])
    assert card.with_suffix(".svg").is_file()


def test_a_model_is_loaded_by_its_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "inove_guo").mkdir()
    assert load_model("inove_guo").name == load_model(ROOT / "config/dampers/inove_guo.yaml").name
    assert load_model("inove_quarter_car").is_vehicle


def test_a_file_wins_over_a_name(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    (tmp_path / "inove_guo").write_text(shipped("inove_bingham", "dampers").read_text())
    assert load_model("inove_guo").name == load_model("inove_bingham").name


@pytest.mark.parametrize("path", ["absent.yaml", "there/absent"])
def test_a_path_is_never_taken_for_a_name(path: str) -> None:
    assert file_of(path, *MODELS) == Path(path)


def test_an_unknown_name_says_what_there_is() -> None:
    with pytest.raises(InputError) as caught:
        load_model("inove_gou")
    said = str(caught.value)
    assert said.startswith("inove_gou: expected a path, or a name among the shipped dampers or")
    assert said.endswith(f"vehicles: {', '.join(names(*MODELS))}, found neither")
