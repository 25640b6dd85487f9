"""What the page draws, as figures: findings where they are, and the fall of the error step by step."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import pytest
from er_model_lab.page import plots
from er_model_lab.results.records import Step as Fallen
from er_model_lab.session.desk import Desk
from er_model_lab.session.script import script
from er_model_lab.session.steps import Source, Step, Stretch
from er_models.measured import MeasuredTerm
from er_models.model import Model
from er_records.write import write_csv

import er_model_lab as lab
from test.sample import write_sample

KNOTS = (-0.2, -0.2, -0.2, -0.2, 0.2, 0.2, 0.2, 0.2)


@pytest.fixture(scope="module")
def data(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """Measurements whose load cell stands still for 0.4 s."""
    folder = tmp_path_factory.mktemp("data")
    first = lab.load(write_sample(folder / "sound.csv", seed=1, seconds=9.0)).records[0]
    y = first.channels["damper_force"].copy()
    y[1000:1080] = 0.66 * y.max()
    write_csv(
        replace(first, channels={**first.channels, "damper_force": y}), folder / "spoilt.csv"
    )
    return folder / "spoilt.csv"


@pytest.fixture
def desk(data: Path, tmp_path: Path) -> Desk:
    made = Desk(tmp_path)
    made.bring([Source(data)], lab.load_model("inove_guo"), "inove_guo")
    made.jobs.wait()
    return made


def shaded(desk: Desk, name: str) -> list[tuple[float, float]]:
    shapes = plots.force(desk, plots.LIGHT)["layout"]["shapes"]
    return [(s["x0"], s["x1"]) for s in shapes if s["name"] == name]


def test_what_is_wrong_is_shaded_beside_what_is_held_out(desk: Desk) -> None:
    assert shaded(desk, "warning") == [pytest.approx((5.0, 5.395))]
    desk.hold([Stretch(0, 6.0, 8.0)])
    desk.jobs.wait()
    assert shaded(desk, "warning") == [pytest.approx((5.0, 5.395))]
    held = shaded(desk, "held out")
    assert 6.0 <= held[0][0] < 6.5, "what runs in does not score"
    assert held[-1][1] == pytest.approx(8.0, abs=0.02)
    shapes = plots.force(desk, plots.LIGHT)["layout"]["shapes"]
    told = [s["name"] for s in shapes if s["showlegend"]]
    assert sorted(told) == ["held out", "warning"], "each kind once in the legend"
    assert len({s["fillcolor"] for s in shapes}) == 2


def with_term(model: Model) -> Model:
    term = MeasuredTerm(("velocity",), (KNOTS,), (3.0, 0.0, 0.0, 3.0), (0.0, 0.0, 0.0, 0.0))
    return replace(model, terms=(term,))


def test_an_improvement_is_a_bar_for_each_effect_and_measured_terms_have_their_colour(
    desk: Desk, monkeypatch: pytest.MonkeyPatch
) -> None:
    better = with_term(desk.now.known.with_effect("coulomb_friction", {"F_c": 1.0, "v_0": 0.003}))
    (term,) = better.terms
    way = [(None, 0.9, 1.0), ("coulomb_friction", 0.3, 0.4), (term.name, 0.2, 0.3)]

    class Found:
        model, interrupted = better, False
        steps = tuple(Fallen(added, held, train) for added, train, held in way)

    monkeypatch.setattr("er_model_lab.verbs.improve.improve", lambda *_, **__: Found())
    desk.improve(measured_terms=True)
    desk.jobs.wait()
    fall = desk.fall()
    assert [s.says for s in fall] == [
        "model inove guo", "refitted", "+ coulomb friction", f"+ {term.name.replace('_', ' ')}",
    ]  # fmt: skip
    assert [s.errors.held_out for s in fall[1:3]] == [1.0, 0.4]
    assert fall[3].errors == desk.errors(), "of the model that is shown"
    bars = plots.waterfall(fall, 0.1, plots.LIGHT)["data"]
    assert [(b["name"], list(b["x"])) for b in bars] == [
        ("learnt from", [0, 1, 2]), ("held out", [0, 1, 2]),
        ("measured term, learnt from", [3]), ("measured term, held out", [3]),
    ]  # fmt: skip
    assert len({b["marker"]["color"] for b in bars}) == 3
    assert bars[0]["y"][1:] == [0.9, 0.3]

    desk.take_back(term.name)
    desk.jobs.wait()
    assert not desk.now.known.terms
    assert [s.says for s in desk.fall()][-1] == f"taken back: {term.name.replace('_', ' ')}"
    said = script(desk.session)
    assert "lab.improve(data, model, measured_terms=True, seed=SEED" in said
    assert f"lab.refit(data, model.without_term({term.name!r}), seed=SEED" in said


def test_needless_effects_end_the_fall(desk: Desk) -> None:
    model = desk.now.known
    step = Step("improve", "", {"fall": [[None, 0.9, 1.0], ["coulomb_friction", 0.3, 0.4]]})
    desk.session = desk.session.then(desk.now.learnt(model, step))
    assert [s.says for s in desk.fall()][-1] == "needless effects out"


def test_rivals_are_those_that_a_run_can_tell_from_an_effect() -> None:
    pytest.importorskip("nicegui", reason="the package nicegui is not installed")
    from er_model_lab.page.panels.plan import rivals

    tied = SimpleNamespace(effect="coulomb_friction", confounded_with=("preload",))
    result, model = SimpleNamespace(candidates=(tied,)), lab.load_model("inove_guo")
    found = rivals(result, model, "coulomb_friction")
    assert found == ["preload", "stribeck_friction", "shear_thinning", "bouc_wen_hysteresis"]
    assert rivals(result, model, "mount_compliance") != []
    assert "velocity_lag" not in rivals(result, model, "mount_compliance")
    assert rivals(result, model, "coulomb_friction + preload") == []
