"""Whether verdicts hang on what says nothing: what differs is told, changes are what they say, a short case holds."""

import numpy as np
import pytest
from er_records.dataset import Dataset
from er_records.record import Record

from test import rough_stability as program
from test.rough import rig as rigs
from test.rough.plan import Asked
from test.rough_stability import CHANGES, asked_again, differences, page

pytestmark = pytest.mark.slow


def answer(names=("a",), verdict="missing_effect", value=1.0, sd=0.1, ties=()):
    values = {n: {"F": [value, sd]} for n in names}
    return {
        "verdict": verdict, "names": list(names), "alternatives": [list(g) for g in ties], "values": values,
    }  # fmt: skip


@pytest.mark.parametrize(
    ("other", "found"),
    [
        (answer(value=1.09), []),
        (answer(value=1.11), ["a.F 1.1 sd"]),
        (answer(["b"]), ["a", "b"]),
        (answer(["b"], ties=[["a", "b"]]), []),
        (answer(verdict="partial"), ["missing_effect, then partial"]),
        ({"failed": "late"}, ["failed: late"]),
    ],
)
def test_what_differs_is_told(other, found):
    assert differences(answer(), other) == found


def test_the_page_counts_every_change_and_lists_what_differs():
    answers = {"as it is": answer(), "seed": answer(), "cut": answer(["b"])}
    text = page([{"key": "k", "answers": answers}, {"key": "no", "unmade": "never"}], "heading")
    assert "| cut | 0/1 |" in text
    assert "| seed | 1/1 |" in text
    assert "| k | cut | a; b |" in text


def test_each_change_is_what_it_says():
    t = 0.01 * np.arange(50)
    records = [
        Record(n, t, {"deflection": t + 1.0, "duty": 0.0 * t + 1.0}) for n in ("one", "two")
    ]
    changed = {name: change(Dataset.of(records)).learn for name, change in CHANGES.items()}
    assert [r.name for r in changed["order"]] == ["two", "one"]
    assert [len(r) for r in changed["cut"]] == [40, 40]
    share = changed["1 + 1e-10"][0].channels["deflection"] / (t + 1.0) - 1.0
    assert np.allclose(share, 1e-10, rtol=1e-3)
    assert np.array_equal(changed["1 + 1e-10"][0].channels["duty"], 0.0 * t + 1.0)


def test_a_short_case_is_the_same_whatever_says_nothing(monkeypatch):
    short = {"SHORTEST": 6.0, "LONGEST": 6.0, "SAMPLES": 600.0, "RATES": (200.0,), "OFTEN": (1.0,)}
    for name, value in short.items():
        monkeypatch.setattr(rigs, name, value)
    row = asked_again(Asked("single", "passive", ("coulomb",), 2, 0), changes=("1 + 1e-10",))
    first, again = row["answers"]["as it is"], row["answers"]["1 + 1e-10"]
    assert "coulomb_friction" in first["names"]
    assert differences(first, again) == []
    with pytest.raises(SystemExit):
        program.main(["--changes", "colour"])
