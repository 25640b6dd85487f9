"""The score of rough cases judges and counts as stated, and takes a whole case through the lab."""

import pytest
from er_models.errors import InputError

from test.rough import rig as rigs
from test.rough.plan import Asked
from test.rough_score import __main__ as program
from test.rough_score.judge import certain_wrong, false_names, judged
from test.rough_score.run import options, score
from test.rough_score.summary import page, ratio, targets

pytestmark = pytest.mark.slow

KNOWN = ["a", "b", "c", "d"]


def row(right, names=(), alternatives=(), verdict="missing_effect", **more):
    return {
        "key": "k", "kind": "single", "truths": ["x"] * len(right), "right": [list(r) for r in right], "beside": [],
        "known": KNOWN, "names": list(names), "alternatives": [list(g) for g in alternatives], "verdict": verdict,
        "drives": [["noise", "steps", "rest"]], "wrong": [{"bent": False, "wild": "", "share": 0.0}], "shown": [1.0],
        "device": "er", "sensors": "full", "rate": 200.0, "time": 1.0, "measured_terms": False, **more,
    }  # fmt: skip


A, UNKNOWN = ("a", "z"), ("new",)
"""A hidden effect with two right names, of which the catalogue knows one; and one outside of it."""


@pytest.mark.parametrize(
    ("given", "word", "wrong"),
    [
        (row([A], ["a"]), "right", False),
        (row([A], ["b"], [["b", "a"]], "ambiguous"), "tied", False),
        (row([A], ["b"], [["b", "a", "c"]], "ambiguous"), "wrong", False),
        (row([A], ["b"], [["b", "a", "c"]]), "wrong", True),
        (row([A], ["a", "b"]), "extra", True),
        (row([A], ["a", "b"], verdict="partial"), "extra", False),
        (row([A], ["a", "b"], beside=["b"]), "right", False),
        (row([A], ["b"]), "wrong", True),
        (row([A], verdict="unknown_effect"), "modest", False),
        (row([A], verdict="adequate"), "silent", False),
        (row([A], ["measured_1"], verdict="partial"), "modest", False),
        (row([A, ("b",)], ["b", "a"]), "right", False),
        (row([A, ("b",)], ["b"], verdict="partial"), "part", False),
        (row([A, ("b",)], ["b", "c"], [["c", "a"]]), "tied", False),
        (row([A, ("b",)], ["b", "c"]), "wrong", True),
        (row([UNKNOWN], verdict="unknown_effect"), "right", False),
        (row([UNKNOWN], ["a"], verdict="partial"), "right", False),
        (row([UNKNOWN], ["a"]), "wrong", True),
        (row([UNKNOWN], verdict="insufficient_data"), "modest", False),
        (row([UNKNOWN], verdict="adequate"), "silent", False),
        (row([UNKNOWN], ["new"], known=["new"]), "right", False),
        (row([A, UNKNOWN], ["a"], verdict="partial"), "right", False),
        (row([A, UNKNOWN], verdict="partial"), "part", False),
        (row([()], ["a"], verdict="partial"), "right", False),  # a truth that no name is right for
        (row([], verdict="adequate"), "right", False),
        (row([], verdict="insufficient_data"), "right", False),
        (row([], verdict="unknown_effect"), "doubted", False),
        (row([], ["a"], verdict="partial"), "wrong", True),
        (row([], ["measured_1"], verdict="adequate"), "right", False),
        (
            row([A], ["b"], [["b", "c"]], "ambiguous", drives=[["tone", "level", "rest"]]),
            "right",
            False,
        ),
        (row([A], ["b"], drives=[["cycles", "level", "rest"]]), "wrong", True),
        (row([A], failed="broken"), "failed", False),
    ],
)
def test_what_an_answer_is_worth(given, word, wrong):
    assert judged(given) == word
    assert certain_wrong(given) == wrong


def test_a_tie_excuses_only_the_name_it_holds():
    assert false_names(row([A], ["c", "d"], [["a", "c"]])) == ["d"]


def lines(rows):
    return [line.split(" | ") for line in targets(rows).splitlines()[2:]]


def fresh(model, truth=1.0, filtered=1.0):
    return {"model": model, "truth": truth, "noise": 0.9, "filtered": filtered, "beyond": False}


def test_targets_are_counted_and_met_or_missed():
    good, bad = row([A], ["a"], fresh=fresh(1.04)), row([A], ["b"], fresh=fresh(1.3))
    nothing = row([], verdict="adequate", fresh=fresh(1.0))
    found = lines([*[good] * 18, bad, nothing])
    assert [f[1] for f in found] == ["19/20", "1/20", "0/1", "20", "20", "20"]
    assert [f[-1] for f in found] == ["yes |", "no |", "yes |", "yes |", "yes |", "yes |"]
    worse = lines([*[good] * 5, *[bad] * 4, row([], ["a"], fresh=fresh(1.3))])
    assert [f[1] for f in worse] == ["5/10", "5/10", "1/1", "10", "10", "10"]
    assert [f[-1] for f in worse] == ["no |"] * 6
    learnt = lines([row([A], ["a"], fresh=fresh(1.2), measured_terms=True)])
    assert "with measured terms" in learnt[-1][0]
    assert learnt[-1][-1] == "no |"  # 1.15
    poor = row([A], drives=[["tone", "level", "rest"]], verdict="ambiguous", fresh=fresh(9.0))
    assert len(lines([poor])) == 3  # no data to hold it against


def test_the_reference_is_the_lab_s_own_motion_unless_that_is_spoilt():
    assert ratio(row([A], fresh=fresh(1.3, 1.2, 1.0))) == pytest.approx(1.3 / 1.2)
    assert ratio(row([A], fresh=fresh(3.0, 60.0, 1.2))) == pytest.approx(2.0)


def test_the_page_lists_what_was_missed_and_nothing_else():
    text = page(
        [row([A], ["a"], key="good"), row([A], ["b"], key="bad"), {"unmade": "never"}], "heading"
    )
    assert "bad" in text
    assert "good" not in text.split("## Every case")[1]
    assert "Not made: never" in text


def test_measured_terms_are_asked_for_only_where_there_are_any(monkeypatch):
    assert options(False) == {}

    def without(data, model):
        pass

    def with_terms(data, model, measured_terms=False):
        pass

    monkeypatch.setattr("test.rough_score.run.improve", without)
    with pytest.raises(InputError, match="measured terms"):
        options(True)
    assert program.main(["--measured-terms"]) == 2
    monkeypatch.setattr("test.rough_score.run.improve", with_terms)
    assert options(True) == {"measured_terms": True}


def test_a_whole_case_goes_through_the_lab_and_its_results_are_kept(monkeypatch, tmp_path, capsys):
    for name, value in (
        ("SHORTEST", 6.0),
        ("LONGEST", 6.0),
        ("SAMPLES", 600.0),
        ("RATES", (200.0,)),
        ("OFTEN", (1.0,)),
    ):
        monkeypatch.setattr(rigs, name, value)
    asked = Asked("single", "passive", ("coulomb",), 2, 0)
    monkeypatch.setattr(program, "plan", lambda *_: [asked])
    out = tmp_path / "r.jsonl"
    words = ["--workers", "1", "--results", str(out), "--table", str(tmp_path / "t.md")]
    assert program.main(words) == 0
    first, kept = capsys.readouterr().out, out.read_text()
    assert (tmp_path / "t.md").read_text() == first
    assert "| coulomb | 1 | 1 | right 1 |" in first
    assert program.main(words) == 0  # nothing is made again
    assert out.read_text() == kept
    assert capsys.readouterr().out == first


def test_what_cannot_be_made_or_takes_too_long_is_told(monkeypatch):
    from test.rough.case import RoughError

    def refuses(asked, folder):
        raise RoughError("no")

    monkeypatch.setattr("test.rough_score.run.make_case", refuses)
    assert score(Asked("single", "passive", ("coulomb",), 2, 0))["unmade"] == "no"
