"""What terminal and page tell: one statement, one data set; the fall from the model as given; the worst regions."""

from __future__ import annotations

import itertools
import re
from dataclasses import replace

import numpy as np
import pytest
from er_model_lab.output.report.sections import falling_error, headline, summary, where_it_fails
from er_model_lab.output.text.fall import stages
from er_model_lab.output.text.notes import by_weight
from er_model_lab.output.text.regions import failures
from er_model_lab.output.text.units import arrow, change, engineering, moves, newtons, parameter
from er_model_lab.output.text.verdict_text import standing_words, verdict_sentence, verdict_title
from er_model_lab.results.values import estimates
from er_models.files import load_model
from lab_help import GUO
from report_views import TABLES, entry, record, table, view
from test_report_terminal import printed

ONE_WORD = re.compile(r"(falls|rises) from (\S+ N) to (\S+ N)")


def test_nothing_falls_to_where_it_was() -> None:
    """Over random errors, many of them equal to the digits that are shown."""
    rng = np.random.default_rng(3)
    for before in 10.0 ** rng.uniform(-3, 4, 3000):
        after = float(before * rng.choice([1.0, 1.0 + 1e-4 * rng.normal(), rng.uniform(0.2, 2.0)]))
        said = moves(float(before), after)
        for word, old, new in ONE_WORD.findall(said):
            assert old != new
            assert (word == "falls") == (after < before)
        assert said.startswith("stays") == (newtons(before) == newtons(after))
        assert ("unchanged" in arrow(before, after)) == (newtons(before) == newtons(after))
        assert change(before, after) not in ("+0 %", "\N{MINUS SIGN}0 %")


@pytest.mark.parametrize("verdict", ["missing_effect", "partial", "ambiguous", "identified"])
def test_no_verdict_tells_a_fall_that_is_none(verdict: str) -> None:
    rng = np.random.default_rng(4)
    for _ in range(60):
        given, refit, after = 3.24 * (1.0 + rng.choice([0.0, 1e-5, 0.1], 3) * rng.normal(size=3))
        v = view(
            verdict=verdict, rmse_as_given=given, rmse={"train": refit, "held_out": refit},
            rmse_after={"train": after, "held_out": after},
            steps=[{"added": None, "rmse_held_out": refit}, {"added": "coulomb_friction", "rmse_held_out": after}],
        )  # fmt: skip
        facts = falling_error.section(v).facts
        for said in (verdict_sentence(v), facts["fall"], *(row[2] for row in facts["rows"])):
            for word, old, new in ONE_WORD.findall(said):
                assert old != new, said
                assert (word == "falls") == (float(old.split()[0]) > float(new.split()[0]))


def grown(**result: object):
    """A view whose refit made held-out data worse, and whose two effects were found as a pair."""
    pair = [entry("coulomb_friction", 0.5), entry("end_stop", 0.4)]
    for e, beside in zip(pair, (0.45, 0.58), strict=True):
        e |= {"rmse_before": beside, "status": "present"}
    steps = [
        {"added": None, "rmse_held_out": 0.6},
        {"added": "coulomb_friction + end_stop", "rmse_held_out": 0.2},
    ]
    told = {"rmse_as_given": 0.5, "rmse_as_given_train": 0.55, "candidates": pair, "steps": steps}
    return view(effects=["coulomb_friction", "end_stop"], **(told | result))


def test_the_fall_begins_at_the_model_as_given_and_a_pair_is_told_by_what_each_adds() -> None:
    found = stages(grown())
    assert [(s.name, s.error) for s in found] == [
        ("model as given", 0.5), ("refitted", 0.6), ("+ Coulomb friction + End stop", 0.2),
    ]  # fmt: skip
    assert found[2].alone == (("Coulomb friction", 0.58), ("End stop", 0.45))
    section = falling_error.section(grown())
    assert section.facts["rows"][2][3] == [
        "End stop beside Coulomb friction: falls from 0.580 N to 0.200 N",
        "Coulomb friction beside End stop: falls from 0.450 N to 0.200 N",
    ]
    bars = {m.name: m for m in section.figures[0].panels[0].marks if hasattr(m, "base")}
    risen, taken = bars["error rises"], bars["taken away"]
    assert (risen.at[0], risen.base[0], risen.size[0]) == pytest.approx((1.0, 0.5, 0.1))
    assert (taken.at[0], taken.base[0], taken.size[0]) == pytest.approx((2.0, 0.2, 0.4))
    assert risen.colours != taken.colours
    lines = printed(grown()).partition("the error falls")[2].splitlines()
    told = [" ".join(line.split("#")[0].split()) for line in lines if "#" in line][:6]
    assert told == [
        "model as given 0.500 N", "refitted 0.600 N", "+ Coulomb friction + End stop 0.200 N",
        "Coulomb friction alone 0.580 N", "End stop alone 0.450 N", "noise floor 0.200 N",
    ]  # fmt: skip


def test_the_fall_ends_at_the_model_that_was_made() -> None:
    """Effects that later ones made needless are taken out again: no step shows what is left then."""
    pruned = replace(grown(rmse_after={"train": 0.2, "held_out": 0.21}), command="improve")
    assert [(s.name, s.error) for s in stages(pruned)][-1] == ("needless effects out", 0.21)
    assert "to 0.210 N" in verdict_sentence(pruned)
    assert stages(replace(grown(), command="improve")) == stages(grown())


def test_a_refit_that_made_held_out_data_worse_is_told() -> None:
    said = verdict_sentence(grown())
    assert "falls from 0.500 N to 0.200 N (the refit alone: 0.600 N)" in said
    assert "on held-out data its error rises from 0.500 N to 0.600 N." in said
    assert "rises" not in verdict_sentence(grown(rmse_as_given=0.7))


def test_the_headline_holds_the_share_of_its_own_numbers() -> None:
    """85 % of the training data stood beside held-out errors of which 44 % were the model's."""
    v = view(explainable=0.85, noise_floor=0.5)
    facts = headline.section(v).facts
    assert facts["share"] == pytest.approx(1.0 - (0.5 / 0.6) ** 2)
    assert facts["data"] == "held-out data"
    first = printed(v).partition("\n\n")[0]
    assert "on held-out data: unexplained" in first
    assert "31 %" in first
    assert "85 %" not in first


def test_each_error_stands_beside_the_noise_of_its_own_data() -> None:
    facts = summary.section(
        view(rmse_as_given=0.7, rmse_as_given_train=0.8, noise_floor_train=0.1)
    ).facts
    assert facts["head"] == ["as given", "refitted", "after", "noise"]
    assert facts["rows"][:2] == [
        ("rms error, training data", ["0.800 N", "0.610 N", "0.210 N", "0.100 N"]),
        ("rms error, held-out data", ["0.700 N", "0.600 N", "0.200 N", "0.200 N"]),
    ]


def test_the_outputs_of_a_car_have_each_its_own_unit_and_noise() -> None:
    sides = {
        "rmse_as_given": 2e-3,
        "rmse": 1e-3,
        "rmse_after": 5e-4,
        "noise_floor": 2e-5,
        "noise": 2e-5,
    }
    told = summary.section(view(channels={"deflection": {"unit": "m", **sides}})).facts["channels"]
    assert told["head"] == ["as given", "refitted", "after", "noise"]
    assert told["rows"] == [("deflection", ["2.00 mm", "1.00 mm", "0.500 mm", "20.0 µm"])]
    alone = {"unit": "m/s2", "rmse": 0.5, "relative": 0.25, "noise": 0.02}
    told = summary.section(view(channels={"sprung_acceleration": alone})).facts["channels"]
    assert told["rows"] == [("sprung acceleration", ["0.500 m/s2", "25 %", "20.0 mm/s2"])]


def test_a_good_model_is_called_good_before_what_is_missing() -> None:
    small = {"nrmse": {"train": 0.009, "held_out": 0.009}}
    for verdict, words in (
        ("partial", "small rest: Coulomb"),
        ("unknown_effect", "no known effect"),
    ):
        assert verdict_title(view(verdict=verdict, **small)).startswith("Good model, small rest")
        assert words in verdict_title(view(verdict=verdict, **small))
        assert "errs by 0.3 % of the force's range" in verdict_sentence(
            view(verdict=verdict, **small)
        )
        assert "Good" not in verdict_title(view(verdict=verdict))
    assert "Good" not in verdict_title(view(verdict="missing_effect", **small))


def test_what_helps_by_more_than_chance_is_not_called_absent() -> None:
    e = entry("shear_thinning", 0.3) | {"p_value": 1e-24}
    assert standing_words(view(), e) == "explained better by Coulomb friction"
    assert standing_words(view(), e | {"explained_by": []}) == "helps, but explains too little"
    assert standing_words(view(), entry("force_lag", 0.01)) == "not needed"


def test_a_value_in_an_engineers_unit_is_the_value() -> None:
    rng = np.random.default_rng(5)
    for unit, size in itertools.product(
        ("N", "N/m", "N s/m", "m", "s", "m/s", "1/m"), 10.0 ** np.arange(-6, 9.0)
    ):
        value, sd = size * rng.uniform(1, 9), size * rng.uniform(0.001, 2)
        factor, name = engineering(value, unit)
        assert name.endswith(unit)
        text = parameter([value, sd, unit]).replace("\N{MINUS SIGN}", "-")
        shown, deviation = (float(y) for y in text.split(" ")[0:3:2])
        factor, name = engineering(max(value, sd), unit)
        assert text.endswith(f" {name}")
        assert abs(shown / factor - value) <= 0.06 * sd
        assert deviation / factor == pytest.approx(sd, rel=0.06)
        if unit in ("N", "N/m", "N s/m"):
            assert len(text.split(" ")[0].partition(".")[0]) <= 4


def test_the_worst_region_of_velocity_deflection_and_duty_is_always_told_with_its_second() -> None:
    flat = table("deflection", "m", [-0.1, 0.0, 0.1], [0.5, 0.5], [0.49, 0.51])
    loud = [
        table(q, "s", [0.0, 1.0, 2.0], [2.0, 0.1], [0.99, 0.01]) for q in ("time", "work done")
    ]
    r = record("loud", 10.0, 1)
    t, place = r.t, (r.velocity > 0.0) & (r.velocity < 0.02)
    spoilt = replace(r, measured=r.measured + 50.0 * (place & (t >= 6.0) & (t < 7.0)))
    found = failures(
        [*loud, flat, *TABLES], [record("quiet", 10.0, 2), spoilt], after=False, most=4
    )
    assert [f.region.quantity for f in found] == ["velocity", "deflection", "duty", "time"]
    assert found[0].when == ("loud", 6.0)
    cut = failures(TABLES, [replace(spoilt, name="loud@120s")], after=False)
    assert cut[0].when == ("loud", 126.0), "of a stretch, the second of its record"
    assert found[1].region.edges == (0.0, 0.1)


def test_a_model_that_was_grown_shows_where_it_still_fails_and_where_it_failed() -> None:
    left = table("deflection", "m", [-0.1, 0.0, 0.1], [0.25, 0.3], [0.2, 0.8])
    v = replace(view(), regions_after=(left,))
    text = printed(v)
    still, before = text.partition("where it still fails")[2].split("where it failed before: ")
    assert "deflection 0 to 100 mm" in still.splitlines()[1]
    assert before.startswith("velocity 0 to 20 mm/s (0.900 N, 55 %)")
    r = v.records[0]
    off = replace(r, after=r.after + 9.0 * ((r.t >= 3.0) & (r.t < 4.0)))
    assert "record_1, 3 s" in printed(replace(v, records=(off,))), "of the last model"
    section = where_it_fails.section(v)
    assert [f.name for f in section.figures] == ["where_it_still_fails", "where_it_fails"]
    assert "deflection 0 to 100 mm" in section.facts["parts"][0]["worst"][0][0]
    quiet = replace(TABLES[1], regions=tuple(replace(r, excess=0.1) for r in TABLES[1].regions))
    told = printed(replace(v, regions_after=(quiet,)))
    assert "where most of the rest is" in told
    assert "where it still fails" not in told
    assert "where it still fails" in printed(replace(v, regions_after=(TABLES[1],)))


def test_the_heat_map_is_dark_where_the_error_is() -> None:
    r = record("one", 60.0, 1, after=False)
    hot = (r.velocity > 0.03) & (r.deflection > 0.0)
    spoilt = replace(r, measured=r.before + np.where(hot, 5.0, 0.1))
    rows = [
        line.split("|")[1]
        for line in printed(replace(view(), records=(spoilt,))).splitlines()
        if line.count("|") == 2
    ]
    assert len(rows) == 7
    dark = [(k, j) for k, row in enumerate(rows) for j, c in enumerate(row) if c == "@"]
    assert dark
    assert all(k <= 3 and j > 0.6 * len(rows[0]) for k, j in dark), "above: extension; right: fast"
    assert set("".join(rows)) <= set(" .:+#@")


NOTES = (
    "t = 0 is the stamp 5 s", "deflection_velocity derived from the deflection", "these data go beyond what 'm' was",
    "the measured force is 1e+03 times the predicted one",
)  # fmt: skip


def test_the_note_that_changes_most_stands_first() -> None:
    assert by_weight(NOTES) == [*NOTES[::-1]]
    text = printed(replace(view(), notes=(*NOTES, *(f"trifle {k}" for k in range(9)))))
    assert [text.index(note[:20]) for note in NOTES[:0:-1]] == sorted(
        text.index(n[:20]) for n in NOTES[1:]
    )
    assert "10 more notes" in text


def test_all_parameters_are_told_with_bounds_and_where_they_came_from() -> None:
    before = load_model(GUO)
    after = before.with_effect("coulomb_friction", {"F_c": 0.8, "v_0": 0.003})
    most = after.bounds("passive", "c0")[1]
    effects = {**after.effects, "passive": {"k0": 270.0, "c0": most}}
    sd = {
        "passive": {"k0": 2.0, "c0": 1.0},
        "coulomb_friction": {"F_c": 0.01, "v_0": float("inf")},
    }
    found = estimates(before, replace(after, effects=effects, deviations=sd), {})
    assert set(found) == set(after.effects)
    k0, c0, f_c = found["passive"]["k0"], found["passive"]["c0"], found["coulomb_friction"]["F_c"]
    assert (k0["before"], k0["value"], k0["sd"]) == (before.value("passive", "k0"), 270.0, 2.0)
    assert k0["bounds"] == [*after.bounds("passive", "k0")]
    assert (k0["status"], c0["status"]) == ("identified", "at_bound")
    assert (f_c["before"], f_c["status"]) == (None, "added")
    assert found["coulomb_friction"]["v_0"]["status"] == "not_identified"
    assert found["response"]["tau"]["status"] == "given"
    wide = {"guo_yield": {"k1": 570.0, "c1": 10.0}}
    vague = estimates(before, replace(after, deviations=wide), {})["guo_yield"]
    assert [vague[n]["status"] for n in ("k1", "c1")] == ["not_identified", "identified"]
    car = load_model(GUO.parents[1] / "vehicles" / "inove_quarter_car.yaml")
    fitted = replace(car, deviations={"quarter_car": {"m_us": 1e-3}})
    masses = estimates(car, fitted, {})["quarter_car"]
    assert [masses[n]["status"] for n in ("m_s", "m_us")] == ["given", "identified"]
