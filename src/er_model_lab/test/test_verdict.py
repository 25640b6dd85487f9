"""The verdict on every kind of evidence."""

from dataclasses import replace
from types import SimpleNamespace
from typing import get_args

import pytest
from er_model_lab.diagnosis import investigation
from er_model_lab.diagnosis.evidence import MUCH_LEFT, evidence
from er_model_lab.diagnosis.rule import Rule
from er_model_lab.diagnosis.verdict import (
    ENOUGH,
    NOTHING_NAMED,
    SETTLED,
    Earlier,
    Verdict,
    decide,
)
from lab_help import EVIDENCE, NAMED, NOTHING

SHORT = ("too short",)
WITHOUT_EFFECTS = [
    ({}, "adequate"),
    ({"within_errors": True}, "insufficient_data"),
    ({"unlike_sensors": True}, "insufficient_data"),
    ({"unlike_sensors": True, "remains": True}, "unknown_effect"),
    ({"remains": True}, "unknown_effect"),
    ({"remains": True, "within_errors": True}, "unknown_effect"),
    ({"blocking": SHORT}, "insufficient_data"),
    ({"blocking": SHORT, "remains": True}, "insufficient_data"),
    ({"explained": 1.0, "without_lines": 1.0, "tied": True}, "adequate"),
]
"""What else is known where no effect was taken, and the verdict."""
WITH_EFFECTS = [
    ({"without_lines": ENOUGH}, "missing_effect"),
    ({"remains": True, "within_errors": True}, "missing_effect"),
    ({"tied": True}, "ambiguous"),
    ({"blocking": SHORT}, "ambiguous"),
    ({"loose": ("end_stop",)}, "ambiguous"),
    ({"without_lines": ENOUGH - 0.01}, "partial"),
    ({"explained": 0.2, "without_lines": 0.2}, "partial"),
    ({"explained": 0.5, "without_lines": 0.1}, "partial"),
    ({"explained": 0.5, "without_lines": 0.5, "tied": True, "blocking": SHORT}, "partial"),
    ({"explained": 0.19, "without_lines": 0.19}, "unknown_effect"),
    ({"explained": 0.19, "without_lines": 0.19, "blocking": SHORT}, "unknown_effect"),
    ({"effects": 3, "too_many": True}, "partial"),
    ({"effects": 3, "too_many": True, "tied": True, "blocking": SHORT}, "partial"),
    ({"effects": 3, "too_many": True, "explained": 0.1, "without_lines": 0.1}, "partial"),
    ({"effects": 3}, "missing_effect"),
]
"""The same where effects were taken."""
BESIDE_A_LAG = [
    ("adequate", 0.0, "missing_effect"), ("insufficient_data", 1.0, "ambiguous"),
    ("unknown_effect", 0.19, "unknown_effect"), ("unknown_effect", 0.2, "partial"),
    ("partial", 1.0, "partial"), ("ambiguous", 1.0, "ambiguous"), ("missing_effect", 0.0, "missing_effect"),
]  # fmt: skip
"""The verdict without a lag of the velocity channel, the share explained with it, and the verdict."""
AFTER_OTHERS = [
    ("adequate", False, "missing_effect"), ("adequate", True, "ambiguous"),
    ("missing_effect", False, "missing_effect"), ("missing_effect", True, "ambiguous"),
    ("ambiguous", False, "ambiguous"), ("ambiguous", True, "ambiguous"), ("partial", False, "partial"),
    ("unknown_effect", True, "partial"), ("insufficient_data", False, "partial"),
]  # fmt: skip
"""The verdict of the last of several searches, whether any of them left a tie, and the verdict on all."""


@pytest.mark.parametrize(
    ("seen", "said"),
    [(replace(NOTHING, **more), said) for more, said in WITHOUT_EFFECTS]
    + [(replace(NAMED, **more), said) for more, said in WITH_EFFECTS],
)
def test_one_search_is_judged_by_what_it_found(seen, said):
    assert decide(seen) == said


def test_each_verdict_can_be_reached_and_what_it_leads_to_is_known():
    assert {name: decide(seen) for name, seen in EVIDENCE.items()} == {v: v for v in EVIDENCE}
    assert set(EVIDENCE) == set(get_args(Verdict))
    assert set(SETTLED) == {"adequate", "missing_effect", "ambiguous"}
    assert set(NOTHING_NAMED) == {"adequate", "unknown_effect", "insufficient_data"}


@pytest.mark.parametrize(("alone", "explained", "said"), BESIDE_A_LAG)
def test_a_lag_is_certain_and_makes_up_for_nothing_else(alone, explained, said):
    assert decide(replace(EVIDENCE[alone], with_lag=explained)) == said


@pytest.mark.parametrize(("last", "tied", "said"), AFTER_OTHERS)
def test_several_searches_are_no_surer_than_each(last, tied, said):
    seen = EVIDENCE[last]
    assert decide(replace(seen, earlier=Earlier(tied=tied, too_many=False))) == said
    assert decide(replace(seen, earlier=Earlier(tied=tied, too_many=True))) == "partial"


@pytest.mark.parametrize(
    ("alone", "said"),
    [("adequate", "missing_effect"), ("insufficient_data", "ambiguous"), ("unknown_effect", "partial")],
)  # fmt: skip
def test_a_lag_that_the_last_search_named_counts_before_the_earlier_ones(alone, said):
    earlier = Earlier(tied=False, too_many=False)
    assert decide(replace(EVIDENCE[alone], with_lag=0.5, earlier=earlier)) == said


def test_what_explains_little_helps_where_that_is_asked_for():
    weak = replace(NAMED, explained=0.15, without_lines=0.15)
    assert (decide(weak), decide(weak, Rule(helps=0.1))) == ("unknown_effect", "partial")
    lag = replace(EVIDENCE["unknown_effect"], with_lag=0.15)
    assert (decide(lag), decide(lag, Rule(helps=0.1))) == ("unknown_effect", "partial")


def seen(name="", mse=1.0, effects=()):
    return SimpleNamespace(name=name, mse=mse, seen=mse, effects=effects)


@pytest.mark.parametrize(
    ("first", "alone", "both", "told"),
    [(4.0, 4.2, 1.0, True), (4.0, 4.2, 3.9, True), (8.0, 8.2, 1.0, False), (4.0, 8.2, 3.0, False)],
)
def test_two_that_explain_the_same_alone_are_sure_only_where_both_add_much(
    first, alone, both, told, monkeypatch
):
    """Mean squares left of 20: by the first, by the second alone, and by both."""
    base, a, b = seen(mse=20.0), seen("a", first, ("a",)), seen("b", alone, ("b",))
    near = ["a", "b"] if alone < 1.1 * first else ["a"]
    monkeypatch.setattr(investigation, "close", lambda step: near)
    rounds = [
        SimpleNamespace(base=base, candidates=[a, b], taken=a),
        SimpleNamespace(base=a, candidates=[], taken=seen("b", both, ("a", "b"))),
    ]
    best = rounds[1].taken
    assert investigation.halves(best, rounds, ()) == ((("a", "b"),) if told else ())
    assert investigation.halves(best, rounds, (("a", "b", "c"),)) == ()
    assert investigation.halves(a, rounds, ()) == ()


@pytest.mark.parametrize(("effects", "left", "said"), [
    (1, 1.1 * MUCH_LEFT, False), (2, 0.9 * MUCH_LEFT, False), (2, 1.1 * MUCH_LEFT, True)
])  # fmt: skip
def test_several_effects_that_leave_much_may_stand_for_one(effects, left, said):
    floor = SimpleNamespace(
        floor=1.0, line=(0, 0, 0.0), measured=None, parts={}, of_sensors=1.0, explained=0.0
    )
    best = seen(mse=left**2, effects=("a", "b")[:effects])
    cover = SimpleNamespace(blocking=(), unlike="")
    found = evidence(best, None, floor, 0.0, 1.0, (), cover, (), Rule())
    assert found.too_many == said


@pytest.mark.parametrize(("left", "again"), [(1.9, False), (9.0, True)])
def test_what_pruning_loses_is_looked_for_once_more(left, again, monkeypatch):
    """Mean square left of 1 by three effects and of so much by two: half as much error again is looked into."""
    grown = [seen("c", 1.0, ("a", "b", "c")), seen("d", 0.9, ("b", "c", "d"))]
    kept, begun = seen("c", left, ("b", "c")), []

    def grow(best, *_):
        begun.append(best.effects)
        return grown[len(begun) - 1], "floor", None

    monkeypatch.setattr(investigation, "_grow", grow)
    monkeypatch.setattr(investigation, "prune", lambda *_: kept)
    monkeypatch.setattr(investigation, "swapped", lambda best, *_: (best, ()))
    monkeypatch.setattr(investigation, "plain", lambda best, *_: (best, ()))
    for name in ("_alternatives", "halves", "clock_ties"):
        monkeypatch.setattr(investigation, name, lambda *_: ())
    rounds = [SimpleNamespace(threshold=1.0, taken=None)]
    first = seen("a", 4.0, ("a",))
    best, *_ = investigation._searched(first, rounds, "floor", None, 0, Rule())
    assert begun == [("a",), ("b", "c")][: 1 + again]
    assert best.effects == (("b", "c", "d") if again else ("b", "c"))


@pytest.mark.parametrize(("goes_on", "passes", "noise", "exchanged"), [
    (False, True, 0.5, True), (True, False, 0.5, True), (True, True, 0.9, True), (True, True, 0.5, False)
])  # fmt: skip
def test_nothing_is_exchanged_while_a_further_effect_passes_that_another_search_takes(
    goes_on, passes, noise, exchanged, monkeypatch
):
    """MTS: a friction by direction stood in for the viscosity that was still missing, and barred the way to it."""
    both, other = seen("b", 1.0, ("a", "b")), seen("c", 0.9, ("c", "b"))
    further = SimpleNamespace(taken=other if passes else None)
    floor = SimpleNamespace(floor=noise)
    monkeypatch.setattr(investigation, "_grow", lambda *_: (both, floor, further))
    monkeypatch.setattr(investigation, "prune", lambda *_: both)
    monkeypatch.setattr(investigation, "swapped", lambda *_: (other, ()))
    monkeypatch.setattr(investigation, "plain", lambda best, *_: (best, ()))
    for name in ("_alternatives", "halves", "clock_ties"):
        monkeypatch.setattr(investigation, name, lambda *_: ())
    rounds = [SimpleNamespace(threshold=1.0, taken=None)]
    best, *_ = investigation._searched(both, rounds, floor, None, 0, Rule(goes_on=goes_on))
    assert best is (other if exchanged else both)
