"""What rows of a fleet become, where the truth is known; `python -m test.fleet_score` does it for more fleets."""

import numpy as np
import pytest
from er_model_lab.fleets.overview import overview
from er_model_lab.fleets.pooled import discoveries, pooled
from er_model_lab.fleets.trends import trend
from er_model_lab.results.fleet import FleetResult
from er_model_lab.results.fleet_view import fleet_view
from er_model_lab.results.values import clean
from er_model_lab.view import View

from test.fleet_score import TARGETS, score
from test.fleet_truth import fleet

pytestmark = pytest.mark.slow


def test_units_that_differ_are_found_and_hardly_any_other():
    """At effects of one standard deviation of the noise of the force; the twenty fleets of docs/results/fleet.md."""
    found = score(range(1001, 1021)).shown()
    assert {k: v for k, v in found.items() if not TARGETS[k][0] <= v <= TARGETS[k][1]} == {}


def test_effects_far_below_the_noise_are_not_made_up():
    found = score(range(50, 51), size=1e-3)
    assert found.wrong <= 1


def test_ten_alike_do_not_hide_each_other():
    rng = np.random.default_rng(3)
    y, s = rng.standard_normal(60), np.full(60, 0.3)
    y[:10] += 8.0
    found = pooled(np.arange(60), y, s, 0.0)
    assert found is not None
    assert discoveries(found.p, 0.05)[:10].all()
    alone = np.sqrt(np.var(y[10:], ddof=1) - 0.3**2)  # with the ten it would be 3
    assert found.between == pytest.approx(alone, rel=1e-3)


def test_a_unit_with_little_data_borrows_from_the_others():
    """Worked by hand: tau = 1, deviations 1 and 0.1 give weights 1/2 and 1/1.01."""
    rng = np.random.default_rng(4)
    y, s = rng.standard_normal(4000), np.full(4000, 0.1)
    s[0], y[0] = 1.0, 2.0
    found = pooled(np.arange(4000), y, s, 0.0)
    assert found is not None
    assert found.between == pytest.approx(1.0, abs=0.04)
    assert found.weight[:2] == pytest.approx([0.5, 1 / 1.01], abs=0.02)
    assert found.value[0] == pytest.approx(1.0, abs=0.07)
    assert found.value_sd[0] == pytest.approx(0.5**0.5, abs=0.02)


@pytest.mark.parametrize(
    ("form", "shape"),
    [
        ("line", lambda x: 0.1 * x), ("step", lambda x: 5.0 * (x > 30.0)),
        ("bend", lambda x: 0.2 * np.maximum(x - 50.0, 0.0)),
    ],
    ids=["line", "step", "bend"],
)  # fmt: skip
def test_a_change_has_its_form_its_place_and_its_size(form, shape):
    rng, x = np.random.default_rng(1), np.linspace(0.0, 100.0, 41)
    found = trend(x, shape(x) + 0.3 * rng.standard_normal(41), np.full(41, 0.09), 100)
    assert found is not None
    assert (found.form, found.p < 1e-10) == (form, True)
    assert found.low <= {"line": 0.0, "step": 30.0, "bend": 50.0}[form] <= found.high
    assert found.change == pytest.approx(shape(x)[-1], abs=4 * found.sd)
    flat = trend(x, 0.3 * rng.standard_normal(41), np.full(41, 0.09), 100)
    assert flat is not None
    assert flat.p > 0.01
    assert trend(x[:3], x[:3], x[:3] + 1.0, 9) is None
    assert trend(np.zeros(9), x[:9], x[:9] + 1.0, 9) is None


def test_time_is_an_axis_like_mileage():
    made = fleet(7, units=20, recordings=12)
    later = [{**r, "time": 3.0 * r["mileage"], "mileage": None} for r in made.recordings]
    far, long = (overview(made.units, rows) for rows in (made.recordings, later))
    told = {each["unit"]: each["changes"] for each in far.content["differ"]}
    assert any(told.values())
    for each in long.content["differ"]:
        assert each["in"]
        for change, other in zip(each["changes"], told.pop(each["unit"]), strict=True):
            assert (change["axis"], other["axis"]) == ("time", "mileage")
            assert (change["quantity"], change["form"]) == (other["quantity"], other["form"])
            assert change["at"] == pytest.approx(3.0 * other["at"])
            assert change["change"] == pytest.approx(other["change"])
    assert told == {}


def test_a_fleet_too_small_to_compare_is_still_told():
    made = fleet(7, units=2)
    told = overview(made.units, made.recordings)
    assert (told.content["units"], told.content["parameters"]) == (2, {})
    assert overview([], []).content["differ"] == []


def test_the_page_shows_the_strangest_first_and_takes_no_name_for_markup(tmp_path):
    made = fleet(7, units=12, recordings=6)
    sick = next(iter(sorted(made.effects)))
    evil = "</script><b>7"
    rows, parts = (
        [{**r, "unit": evil if r["unit"] == sick else r["unit"]} for r in each]
        for each in (made.units, made.recordings)
    )
    found = overview(rows, parts)
    differ = found.content["differ"]
    pages = {differ[0]["unit"]: "units/00.html"}
    seen = fleet_view(
        rows, found.units, differ, lambda u: [p for p in parts if p["unit"] == u], pages
    )
    more = {"command": "fleet", "failed": [], "notes": [], "tables": {}, "complete": True}
    view = View("fleet", "m", "12 units", clean(found.content | more), (), fleet=seen)
    page = FleetResult(view, pages={"units/00.html": b"one"}).report(tmp_path)
    html = page.read_text()
    assert (tmp_path / "units/00.html").read_bytes() == b"one"
    assert '<a href="units/00.html">' in html
    assert evil not in html
    for section in ("fleet", "units", "effects", "parameters", "changes"):
        assert f'<section id="{section}">' in html
    assert [r["p"] for r in seen.rows] == sorted(r["p"] for r in seen.rows)


def test_a_value_that_was_never_moved_is_none():
    made = fleet(3, units=8, recordings=4)
    for row in (*made.units, *made.recordings):
        for sd, name in (
            (0.0, "a.still"),
            (1e-17, "a.stiller"),
            (1e9, "a.unseen"),
            (None, "a.unknown"),
        ):
            row["values"][name] = [1.0, sd, "s"]
    told = overview(made.units, made.recordings).content["parameters"]
    assert told.keys() == {"passive.k0", "passive.c0", "guo_yield.f_c", "response.tau"}
