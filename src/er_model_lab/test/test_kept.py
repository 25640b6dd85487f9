"""What was worked out once is found again, and only that."""

from functools import partial

import numpy as np
import pytest
from er_common.kept import kept as kept_by
from er_model_lab.verbs.compare import compare
from er_models.cache.folder import cache_folder, state_folder
from er_models.files import load_model
from er_models.prediction import motion, predict
from er_records.in_memory import from_arrays
from lab_help import DT, GUO, imposed

from er_common import kept as module

kept = partial(kept_by, ("er_model_lab", "er_records"))


@pytest.fixture
def cache(tmp_path, monkeypatch):
    """A cache of its own."""
    monkeypatch.setenv("ER_CACHE_DIR", str(tmp_path))
    return cache_folder()


@pytest.mark.usefixtures("cache")
def test_it_is_made_once_of_the_same_and_again_of_other_data():
    found = kept(("a", np.arange(3.0)), lambda: {"rmse": 1.5})
    assert found == {"rmse": 1.5}
    assert kept(("a", np.arange(3.0)), never) == found
    assert kept(("a", np.array([0.0, 1.0, 2.0 + 1e-15])), lambda: 2) == 2


@pytest.mark.usefixtures("cache")
def test_other_libraries_make_it_again(monkeypatch):
    kept("a", lambda: 1)
    monkeypatch.setattr(module, "version", lambda name: "0")
    assert kept("a", lambda: 2) == 2


@pytest.mark.usefixtures("cache")
@pytest.mark.parametrize("changed", ["er_model_lab", "er_records"])
def test_other_sources_of_any_package_make_it_again(changed, monkeypatch):
    kept("a", lambda: 1)
    other = lambda name: (f"{name}-{'0' if name == changed else '1'}", "")  # noqa: E731
    same = lambda name: (f"{name}-1", "")  # noqa: E731
    monkeypatch.setattr(module, "state", same)
    assert kept("a", lambda: 2) == 2
    assert kept("a", never) == 2
    monkeypatch.setattr(module, "state", other)
    assert kept("a", lambda: 3) == 3


def test_what_somebody_changed_is_made_again(cache):
    kept("a", lambda: 1)
    [path] = cache.rglob(f"*{module.ENDING}")
    path.write_bytes(path.read_bytes()[:-1] + b"x")
    assert kept("a", lambda: 2) == 2


def test_few_are_kept_and_none_that_is_large(cache, monkeypatch):
    monkeypatch.setattr(module, "FEW", 3)
    monkeypatch.setattr(module, "LARGEST", 1000)
    for k in range(6):
        kept(k, lambda: 1)
    kept("large", lambda: bytes(2000))
    assert len([*cache.rglob(f"*{module.ENDING}")]) == 3
    assert kept("large", lambda: 2) == 2


@pytest.mark.usefixtures("cache")
def test_where_nothing_can_be_kept_it_is_made(monkeypatch, caplog):
    def full(*_):
        raise OSError(28, "No space left on device")

    monkeypatch.setattr(module.sealed, "write", full)
    assert kept("a", lambda: 1) == 1
    assert "No space left on device: the result is not kept" in caplog.text
    assert state_folder("x-1").is_dir()


def test_a_comparison_seen_again_is_the_same_to_the_last_digit(monkeypatch):
    model, (x, v, a, u) = load_model(GUO), imposed(np.random.default_rng(3), 1600)
    data = from_arrays(
        t=np.arange(1600) * DT, deflection=x, deflection_velocity=v, duty=u,
        damper_force=predict(model, motion(DT, x, v, u, a)),
    )  # fmt: skip
    first = compare(data, model)
    monkeypatch.setattr("er_model_lab.level.damper.noise_floor", never)
    again = compare(data, model)
    assert again.to_dict() == first.to_dict()
    assert again.view.provenance == first.view.provenance
    other = model.with_effect("passive", {**model.effects["passive"], "c0": 60.0})
    with pytest.raises(AssertionError, match="again"):
        compare(data, other)


def never(*_):
    raise AssertionError("it is made again")
