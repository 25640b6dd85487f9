"""The score program judges, counts and resumes as stated."""

import json
import subprocess
import sys

import pytest
from er_models.errors import InputError

from test.blind.catalogue import INSIDE
from test.blind_score import __main__ as program
from test.blind_score.answer import guarded
from test.blind_score.cases import Asked, Layout, layout, plan
from test.blind_score.judge import false_names, judged
from test.blind_score.pool import spread
from test.blind_score.rows import ROOT, SAYS, append, deciding, digest, read
from test.blind_score.summary import ordered, page, targets, wilson

pytestmark = pytest.mark.slow


def row(kind, hidden, names=(), alternatives=(), verdict="missing_effect", **more):
    return {
        "key": f"{kind}/{'+'.join(hidden)}/{more.get('seed', 1)}", "kind": kind, "hidden": list(hidden),
        "program": "rich", "seed": 1, "records": 1, "seconds": 50.0, "rise_together": 0.5, "time": 1.0,
        "verdict": verdict, "names": list(names), "alternatives": [list(g) for g in alternatives], **more,
    }  # fmt: skip


@pytest.mark.parametrize(
    ("names", "groups", "word"),
    [
        (["a"], [], "first"),
        (["a", "b"], [], "first"),
        (["b"], [["a", "b"]], "tied"),
        (["b"], [["a", "b", "c"]], "wrong"),
        (["b", "a"], [], "later"),
        (["b"], [], "wrong"),
        ([], [], "silent"),
    ],
)
def test_one_hidden_effect(names, groups, word):
    assert judged(row("singles", ["a"], names, groups)) == word


@pytest.mark.parametrize(
    ("names", "groups", "word"),
    [
        (["a", "b"], [], "both"),
        (["b", "a", "c"], [], "wrong"),
        (["a"], [], "one"),
        (["a", "c"], [["c", "b"]], "both"),
        (["a", "c"], [["c", "b", "d"]], "wrong"),
        (["a", "c"], [["a", "c"]], "wrong"),
        ([], [], "none"),
    ],
)
def test_two_hidden_effects(names, groups, word):
    assert judged(row("pairs", ["a", "b"], names, groups)) == word


def test_a_tie_excuses_only_the_name_it_holds():
    assert false_names(row("pairs", ["a", "b"], ["c", "d"], [["a", "c"]])) == ["d"]


def test_the_other_kinds():
    assert judged(row("complete", [], verdict="adequate")) == "right"
    assert judged(row("complete", [], ["a"], verdict="partial")) == "wrong"
    assert judged(row("outside", ["outside:x"], ["a"], verdict="partial")) == "right"
    assert judged(row("outside", ["outside:x"], verdict="unknown_effect")) == "right"
    assert judged(row("outside", ["outside:x"], ["a"])) == "wrong"
    assert judged(row("outside", ["outside:x"], verdict="adequate")) == "silent"
    assert judged(row("degenerate", ["a"], ["b"])) == "wrong"
    assert judged(row("degenerate", ["a"], ["a", "b"])) == "wrong"
    assert judged(row("degenerate", ["a"], ["a"])) == "named"
    assert judged(row("degenerate", ["a"], ["b"], verdict="ambiguous")) == "modest"
    assert judged({"kind": "singles", "failed": "no data"}) == "failed"


def test_wilson_intervals_of_the_textbook():
    """Values of Newcombe 1998, Statistics in Medicine 17, 857, table I, method 3."""
    assert wilson(81, 263) == pytest.approx((0.2553, 0.3662), abs=1e-4)
    assert wilson(0, 20) == pytest.approx((0.0, 0.1611), abs=1e-4)
    assert wilson(0, 0) == (0.0, 1.0)


def test_targets_count_refusals_against_the_lab():
    rows = [row("complete", [], verdict="adequate", seed=s) for s in range(199)]
    assert "| 0/199 | 0.0% |" in targets(rows)
    assert targets(rows).count("| yes |") == 1
    rows += [{**row("complete", []), "failed": "broken"}] * 3
    assert "| 3/202 | 1.5% |" in targets(rows)
    assert targets(rows).count("| no |") == 1


def test_the_falling_error_is_judged_by_median_and_worst():
    def with_ratio(value, names, beyond=False):
        fresh = {"model": value, "truth": 1.0, "noise": 0.8, "beyond": beyond}
        return row("singles", ["a"], names, fresh=fresh)

    good = [with_ratio(1.02, ["a"]), with_ratio(1.04, ["a"]), with_ratio(2.0, ["b"])]
    text = targets(good)
    assert "| 3 | 1.040 |" in text
    assert "| 2 | 1.040 |" in text
    missed = targets([*good, with_ratio(1.31, ["a"])]).splitlines()
    assert "| no |" in missed[-2]
    assert "| no |" in missed[-1]
    further = targets([*good, with_ratio(1.31, ["a"], beyond=True)]).splitlines()
    assert "| 3 | 1.310 |" in further[-2]
    assert "| no |" in further[-2]
    assert "| 2 | 1.040 |" in further[-1]
    assert "| yes |" in further[-1]


def test_the_page_lists_every_miss_and_nothing_else():
    rows = [row("singles", ["a"], ["a"]), row("singles", ["a"], ["b"], seed=2)]
    text = page(ordered(rows), "heading")
    assert "singles/a/2" in text
    assert "singles/a/1" not in text


def test_the_full_plan_is_as_large_as_the_targets_ask():
    asked = plan(["singles", "pairs", "complete", "outside", "degenerate"], range(1, 11))
    count = {k: sum(a.kind == k for a in asked) for k in {a.kind for a in asked}}
    assert count["singles"] == len(INSIDE) * 10
    assert count["pairs"] == 100
    assert count["complete"] == 200
    assert len({a.hidden for a in asked if a.kind == "outside"}) >= 6
    assert {a.program for a in asked if a.kind == "degenerate"} == {"constant_duty", "one_sine"}
    assert len({a.key for a in asked}) == len(asked)
    assert all(a.hidden == ("dead_time",) for a in plan(["singles"], [1], ["dead_time"]))


def test_layouts_are_one_to_three_records_of_40_to_90_s():
    sizes = [layout(seed) for seed in range(200)]
    assert {s.records for s in sizes} == {1, 2, 3}
    assert 40.0 <= min(s.seconds for s in sizes) < 45.0
    assert 85.0 < max(s.seconds for s in sizes) <= 90.0


def test_results_survive_an_interrupted_line(tmp_path):
    path = tmp_path / "deep" / "results.jsonl"
    append(path, {"key": "one"})
    with path.open("a") as file:
        file.write('{"key": "tw')
    assert [r["key"] for r in read(path)] == ["one"]
    append(path, {"key": "two"})
    assert [r["key"] for r in read(path)] == ["one", "two"]
    path.write_text('nonsense\n{"key": "two"}\n')
    with pytest.raises(InputError, match="line 1"):
        list(read(path))


def test_the_digest_follows_statements_not_words(tmp_path):
    folder = tmp_path / "src" / "er_models" / "er_models"
    folder.mkdir(parents=True)
    (folder / "fit.py").write_text('"""Words."""\nx = 1\n')
    first = digest(tmp_path)
    (folder / "fit.py").write_text('"""Other words."""\nx = 1  # why\n')
    (folder / "cli.py").write_text("y = 1\n")
    assert digest(tmp_path) == first
    (folder / "fit.py").write_text('"""Words."""\nx = 2\n')
    assert digest(tmp_path) != first
    assert len(digest()) == 16


def test_the_digest_covers_what_a_search_runs():
    """All that `improve` loads of models and lab, but for what only says; folders that moved were left out once."""
    command = (
        "import er_model_lab.verbs.improve, sys\n"
        "print(*(m.__file__ for m in sys.modules.values() if hasattr(m, '__file__')), sep='\\n')"
    )
    done = subprocess.run(
        [sys.executable, "-c", command], capture_output=True, text=True, check=True
    )
    packages = ("/er_models/er_models/", "/er_model_lab/er_model_lab/")
    own = {
        p.rpartition(name)[2] for p in done.stdout.splitlines() for name in packages if name in p
    }
    counted = {str(p).rpartition(name)[2] for p in deciding() for name in packages}
    assert len(own) > 100
    assert [p for p in own - counted if SAYS.isdisjoint(p.removesuffix(".py").split("/"))] == []
    assert ROOT / "src/er_model_lab/er_model_lab/fitting/fit.py" in deciding()
    assert ROOT / "src/er_models/er_models/catalogue/force/cavitation.py" in deciding()


def test_a_crash_is_an_answer():
    def refuses():
        raise InputError("DATA", "", "data", "none")

    assert guarded(refuses) == {"failed": "DATA: expected data, found none"}
    assert guarded(lambda: {"bad": 1 // 0})["failed"].startswith("ZeroDivisionError")


def fake(asked: Asked, size: Layout | None = None) -> dict:
    size = size or layout(asked.seed)
    names = list(asked.hidden)
    return {
        **row(asked.kind, asked.hidden, names), "key": asked.key, "seed": asked.seed,
        "records": size.records, "seconds": size.seconds,
    }  # fmt: skip


def test_processes_share_the_work():
    asked = plan(["singles"], [1], ["dead_time", "preload"])
    assert sorted(r["key"] for r in spread(fake, asked, 2)) == sorted(a.key for a in asked)


def test_a_second_run_makes_only_what_is_missing(tmp_path, monkeypatch, capsys):
    made = []

    def counted(asked, size=None):
        made.append(asked.key)
        return fake(asked, size)

    monkeypatch.setattr(program, "score", counted)
    out, table = tmp_path / "r.jsonl", tmp_path / "t.md"
    words = [
        "--kinds",
        "singles",
        "--effects",
        "dead_time",
        "--workers",
        "1",
        "--results",
        str(out),
    ]
    assert program.main([*words, "--seeds", "1-2", "--table", str(table)]) == 0
    assert program.main([*words, "--seeds", "1-3"]) == 0
    assert made == [f"singles/dead_time/rich/{s}" for s in (1, 2, 3)]
    assert "| 3/3 | 100.0% |" in capsys.readouterr().out
    assert "Seeds 1-2, 2 cases" in table.read_text()
    lines = [{**json.loads(line), "code": "other"} for line in out.read_text().splitlines()]
    out.write_text("".join(json.dumps(line) + "\n" for line in lines))
    assert program.main([*words, "--seeds", "3"]) == 0
    assert made[3:] == ["singles/dead_time/rich/3"]


@pytest.mark.parametrize(
    ("words", "found"),
    [
        (["--seeds", "x"], "--seeds: expected numbers like 3 or 1-10, found x"),
        (["--effects", "colomb"], "found colomb"),
        (["--records", "2"], "--records and --seconds together"),
    ],
)
def test_bad_words_are_answered_in_one_line(words, found, capsys):
    assert program.main(words) == 2
    error = capsys.readouterr().err
    assert found in error
    assert error.count("\n") == 1


def test_one_case_through_the_whole_program(tmp_path, capsys):
    out = tmp_path / "r.jsonl"
    words = "--kinds singles --effects dead_time --seeds 3 --records 3 --seconds 15 --workers 1"
    assert program.main([*words.split(), "--results", str(out)]) == 0
    (known,) = read(out)
    assert judged(known) == "first"
    assert known["fresh"]["noise"] < known["fresh"]["truth"] < known["fresh"]["model"] * 1.1
    assert known["fresh"]["model"] < 1.1 * known["fresh"]["truth"]
    assert "| 1/1 | 100.0% |" in capsys.readouterr().out
