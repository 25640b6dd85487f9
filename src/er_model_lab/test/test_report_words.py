"""What the report says: verdicts in words, numbers with units, the worst regions, the ranking."""

from __future__ import annotations

import re
from dataclasses import replace

import pytest
from er_model_lab.output.report.palette import VERDICT
from er_model_lab.output.report.sections import headline
from er_model_lab.output.text.ranking import beside, effect_size, largest, limit, ranked
from er_model_lab.output.text.regions import worst
from er_model_lab.output.text.units import (
    estimate,
    gain,
    newtons,
    parameter,
    percent,
    short,
    ticks,
    where,
)
from er_model_lab.output.text.verdict_text import TITLES, verdict_sentence, verdict_title
from er_model_lab.residual.region import Region
from report_views import PLANNED, PREFLIGHT, TABLES, compared, entry, table, view

SAID = {
    "adequate": ("The model is adequate", ["0.600 N", "0.200 N", "No known effect"]),
    "missing_effect": (
        "Missing effect found: Coulomb friction",
        ["from 0.600 N to 0.200 N", "noise alone is 0.200 N"],
    ),
    "ambiguous": (
        "cannot say which",
        ["Coulomb friction or Shear thinning", "0.600 N and becomes 0.295 N or 0.400 N"],
    ),
    "partial": ("Part of what is missing was found: Coulomb friction", ["more is missing"]),
    "unknown_effect": ("catalogue does not know", ["no known effect explains"]),
    "insufficient_data": ("cannot decide", ["only 3 s of data"]),
    "identified": ("Every parameter was identified", ["falls from 0.600 N", "to 0.200 N"]),
    "identified_in_part": ("do not determine every parameter", ["falls from 0.600 N"]),
    "told_apart": ("tells them apart", ["2 times the noise"]),
    "one_way": ("not if the other is", ["2 times the noise"]),
    "not_told_apart": ("No program within the limits", ["2 times the noise"]),
    "revealed": ("A program that shows it", ["2 times the noise"]),
    "not_revealed": ("No program within the limits shows it", ["2 times the noise"]),
    "usable": ("can be used", ["1 of 1 regions are missing; 1 effects"]),
    "not_usable": (
        "cannot be used as they are",
        ["deflection of record 1: a channel that looks like mm"],
    ),
}


@pytest.mark.parametrize("verdict", list(SAID))
def test_each_verdict_is_said_in_plain_words_with_its_numbers(verdict: str) -> None:
    group = [["coulomb_friction", "shear_thinning"]] if verdict == "ambiguous" else []
    v = view(
        verdict=verdict,
        alternatives=group,
        coverage={"blocking": ["only 3 s of data"]},
        why=PLANNED["why"],
        preflight=PREFLIGHT if verdict != "usable" else {**PREFLIGHT, "findings": []},
    )
    title, pieces = SAID[verdict]
    assert title in verdict_title(v)
    for piece in pieces:
        assert piece in verdict_sentence(v), piece
    assert "_" not in verdict_title(v) + verdict_sentence(v), (
        "names of the code are no plain words"
    )


def test_an_adequate_model_is_not_said_to_lack_what_the_data_do_not_show() -> None:
    told = [{"effect": e, "status": "not_excited"} for e in ("dead_time", "duty_dead_band")]
    told.append({"effect": "preload", "status": "absent"})
    said = verdict_sentence(view(verdict="adequate", candidates=told))
    assert "than chance; 2 would not show in these data." in said
    assert "show" not in verdict_sentence(view(verdict="adequate", candidates=told[2:]))


def test_more_is_missing_where_only_the_data_learnt_from_show_it() -> None:
    """Few held-out runs: what is left there lies below the floor, and nobody would believe that more is missing."""
    found = {"noise_floor": 0.21, "rmse_after": {"train": 0.5, "held_out": 0.2}}
    said = verdict_sentence(view(verdict="partial", noise_floor_train=0.1, **found))
    assert "to 0.200 N. Held-out error has reached its noise (0.210 N)." in said
    assert "On the training data 0.500 N remain, noise is 0.100 N: more is missing" in said
    usual = verdict_sentence(view(verdict="partial", noise_floor_train=0.1, noise_floor=0.15))
    assert "to 0.200 N, but noise alone is 0.150 N: more is missing" in usual
    alike = {**found, "rmse_after": {"train": 0.1, "held_out": 0.2}}
    assert "remain" not in verdict_sentence(
        view(verdict="partial", noise_floor_train=0.1, **alike)
    )


def test_what_is_not_noise_is_not_called_noise_where_no_input_predicts_it() -> None:
    """A hum is in what is left whatever the model, and so in the floor."""
    sentence = verdict_sentence(view(verdict="unknown_effect", noise_floor=0.599))
    assert "noise alone" not in sentence
    assert "0.600 N" in sentence
    assert "not noise either" in sentence


def test_tied_effects_that_leave_different_errors_are_not_said_to_explain_it_alike() -> None:
    group = ["coulomb_friction", "shear_thinning"]
    for left, said in ((0.203, "Each explains"), (0.4, "0.600 N and becomes 0.200 N or 0.400 N")):
        told = [{"effect": e, "rmse_held_out": r} for e, r in zip(group, (0.2, left), strict=True)]
        sentence = verdict_sentence(
            view(verdict="ambiguous", alternatives=[group], candidates=told)
        )
        assert said in sentence


def test_the_words_cover_the_verdicts_of_the_lab() -> None:
    from typing import get_args

    from er_model_lab.diagnosis.verdict import Verdict as Diagnosed
    from er_model_lab.identification.findings import Verdict
    from er_model_lab.planning.present import Verdict as Planned
    from er_model_lab.preflight.check import Verdict as Checked

    known = {*get_args(Diagnosed), *get_args(Verdict), *get_args(Planned), *get_args(Checked)}
    assert set(TITLES) == set(VERDICT) == set(SAID) == known


def test_a_comparison_has_no_verdict_but_a_share() -> None:
    assert verdict_title(compared()) == "89 % of the squared error is the model's"
    assert verdict_sentence(compared()) == "The error is 0.600 N; noise alone is 0.200 N."


def test_white_text_can_be_read_on_every_banner() -> None:
    def luminance(colour: str) -> float:
        parts = [int(colour[i : i + 2], 16) / 255 for i in (1, 3, 5)]
        linear = [c / 12.92 if c <= 0.04045 else ((c + 0.055) / 1.055) ** 2.4 for c in parts]
        return 0.2126 * linear[0] + 0.7152 * linear[1] + 0.0722 * linear[2]

    for verdict, colour in VERDICT.items():
        assert 1.05 / (luminance(colour) + 0.05) > 4.5, verdict
        assert headline.section(view(verdict=verdict)).facts["colour"] == colour


def test_several_missing_effects_are_listed() -> None:
    v = view(effects=["coulomb_friction", "end_stop"])
    assert verdict_title(v) == "Missing effect found: Coulomb friction and End stop"
    assert verdict_sentence(v).startswith("With them")


def test_what_was_taken_shows_its_size_however_small_it_is_beside_the_first() -> None:
    both = [entry("preload", 222.0), entry("gas_spring", 0.871), entry("end_stop", 0.871)]
    found = view(effects=["preload", "gas_spring"], candidates=both)
    said = [gain(effect_size(found, e), beside(found, e)) for e in both]
    assert said == ["222 N", "0.871 N", "no gain"]


@pytest.mark.parametrize(
    ("triple", "said"),
    [
        ([0.93596, 0.00879, "N"], "0.9360 ± 0.0088 N"),
        ([-0.00165, 0.000112, "s"], "−1.65 ± 0.11 ms"),
        ([173467.0, 184222.0, "N s/m3"], "170 ± 180 kN s/m3"),
        ([2.5e-9, 1.1e-10, "m"], "2.50 ± 0.11 nm"),
        ([0.5, None, "1"], "0.500 (not determined by these data)"),
        ([0.5, float("inf"), "N"], "0.500 N (not determined by these data)"),
        ([0.0132, 0.0, "m/s"], "13.2 mm/s"),
        ([8956924.0, 883397.0, "N/m3"], "8960 ± 880 kN/m3"),
        ([1.5e-14, None, "N"], "1.50e−14 N (not determined by these data)"),
        ([0.0, 0.2, "1/m"], "0.00 ± 0.20 1/m"),
    ],
)
def test_the_deviation_decides_the_digits_of_a_parameter(triple: list[object], said: str) -> None:
    assert parameter(triple) == said


@pytest.mark.parametrize(
    ("value", "sd", "before", "said"),
    [
        (-0.1, 9.6, 263.117, ("263.1 N/m", "−0.1 ± 9.6 N/m")),
        (0.0, None, 0.0365, ("36.50 mN/m", "0 mN/m")),
        (2490.0, 120.0, 64.64, ("64.64 N/m", "2490 ± 120 N/m")),
        (5.0e4, float("inf"), 2.0e4, ("20.00 kN/m", "50.0 kN/m")),
    ],
)
def test_the_larger_of_value_and_deviation_says_in_which_unit_an_estimate_is_read(
    value: float, sd: float | None, before: float, said: tuple[str, str]
) -> None:
    assert estimate({"value": value, "sd": sd, "before": before, "unit": "N/m"})[:2] == said


@pytest.mark.parametrize(
    ("value", "said"),
    [(0.31234, "0.312"), (12.345, "12.3"), (1234.5, "1234"), (1.5e7, "1.50e+07"), (0.0, "0"),
    (-2.0, "−2.00"),
     (2e-6, "2.00e−06"), (None, "-"), (float("nan"), "-")],
)  # fmt: skip
def test_numbers_have_three_digits(value: float | None, said: str) -> None:
    assert short(value) == said


def test_shares_and_forces() -> None:
    assert [percent(v) for v in (0.5, 0.034, -0.026, -1e-5, None)] == [
        "50 %",
        "3.4 %",
        "−2.6 %",
        "0 %",
        "-",
    ]
    assert newtons(0.25) == "0.250 N"


def test_an_effect_that_gains_nothing_is_said_so() -> None:
    said = [gain(v, 0.5) for v in (0.165, 0.0026, 0.0001, -0.3, None)]
    assert said == ["0.165 N", "0.00260 N", "no gain", "no gain", "-"]


def test_regions_are_named_with_their_units() -> None:
    velocity, duty = TABLES
    assert where(velocity.regions[1], single=False) == "velocity −20 to 0 mm/s"
    assert where(duty.regions[1], single=True) == "duty 0.100"
    assert [t for _, t in ticks(velocity.regions)] == ["−100", "−20", "0", "20", "100"]
    assert ticks(duty.regions) == ((0.0, "0"), (1.0, "0.10"), (2.0, "0.20"))
    direction = table("direction", "1", [-1.0, 1.0, 1.0], [0.3, 0.4], [0.4, 0.6])
    assert [t for _, t in ticks(direction.regions)] == ["compression", "extension"]
    assert where(direction.regions[1], single=True) == "direction: extension"


def test_the_worst_regions_carry_more_than_their_share() -> None:
    found = worst(TABLES)
    assert [(r.quantity, r.edges) for r, _ in found] == [("velocity", (0.0, 0.02))]
    even = table("time", "s", [0.0, 1.0, 2.0], [0.5, 0.5], [0.5, 0.5])
    assert worst([even]) == []
    hot = [
        table(q, "m", [0.0, 1.0, 2.0, 3.0, 4.0], [1.0] * 4, [0.33, 0.33, 0.33, 0.01])
        for q in "abcde"
    ]
    assert len(worst(hot)) == 6
    assert max([r.quantity for r, _ in worst(hot, 9)].count(q) for q in "abcde") == 2


def test_candidates_are_ranked_by_what_is_taken_and_then_by_size() -> None:
    v = view(effects=["end_stop"])
    assert [e["effect"] for e in ranked(v)] == [
        "end_stop",
        "coulomb_friction",
        "shear_thinning",
        "force_lag",
    ]
    assert largest(v) == 0.51
    assert largest(view(candidates=[entry("velocity_lag", 40.0) | {"basis": "kinematics"}])) == 0.0
    assert limit(v) == 0.022
    assert limit(compared()) is None


def test_a_size_that_is_not_stated_follows_from_the_errors() -> None:
    e = {k: x for k, x in entry("end_stop", 0.1).items() if k != "evidence"} | {
        "rmse_held_out": 0.36
    }
    assert effect_size(view(), e) == pytest.approx((0.6**2 - 0.36**2) ** 0.5)
    assert effect_size(view(), e | {"rmse_held_out": 0.61}) == pytest.approx(
        -((0.61**2 - 0.6**2) ** 0.5)
    )
    assert effect_size(replace(view(), result={}), e) is None


def test_no_sentence_of_a_view_holds_a_raw_number() -> None:
    assert not re.search(r"\d\.\d{5,}", verdict_sentence(view(noise_floor=0.204376043)))


def test_an_end_of_a_range_that_is_zero_but_for_rounding_is_zero() -> None:
    region = Region("velocity", "m/s", (-0.013, 1.8e-35), 0.3, 0.2, 1.0, (0.9, 1.1))
    assert where(region, single=False).endswith("13 to 0 mm/s")
