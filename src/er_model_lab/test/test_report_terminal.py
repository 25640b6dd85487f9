"""The terminal summary: one screen, plain where it is not a terminal."""

from __future__ import annotations

import io
import re
import shlex
from dataclasses import replace
from pathlib import Path

import pytest
from er_model_lab.output.terminal.summary import summary
from er_model_lab.output.text.verdict_text import (
    TITLES,
    title_of,
    verdict_sentence,
    verdict_title,
)
from er_model_lab.view import View
from report_views import (
    HISTORY,
    IDENTIFIED,
    MODELS,
    PLANNED,
    PREFLIGHT,
    TABLES,
    card,
    compared,
    empty,
    entry,
    table,
    view,
)
from rich.console import Console
from rich.text import Text


def printed(
    v: View, width: int = 100, *, terminal: bool = False, report: Path | None = None
) -> str:
    """What a console of this width shows."""
    out = io.StringIO()
    console = Console(
        file=out,
        width=width,
        force_terminal=terminal,
        color_system="standard" if terminal else None,
    )
    console.print(summary(v, report))
    return out.getvalue()


def crowded() -> View:
    """More of everything than fits."""
    names = [f"effect_with_a_very_long_name_{k}" for k in range(30)]
    steps = [{"added": None, "rmse_held_out": 0.9}]
    steps += [{"added": n, "rmse_held_out": 0.8 - 0.05 * k} for k, n in enumerate(names[:9])]
    v = view(
        candidates=[entry(n, 0.4 - 0.01 * k) for k, n in enumerate(names)], effects=names[:3],
        steps=steps,
        alternatives=[names[3:9], names[9:15]], verdict="ambiguous", reasons=names,
    )  # fmt: skip
    hot = [
        table(f"quantity {q}", "m", [0.0, 1.0, 2.0, 3.0, 4.0], [1.0] * 4, [0.4, 0.4, 0.1, 0.1])
        for q in "abcde"
    ]
    cards = tuple(card(n, 0.3, v.records[0]) for n in names)
    return replace(
        v, model="m" * 90, notes=tuple(names), regions=TABLES + tuple(hot), candidates=cards
    )


@pytest.mark.parametrize("width", [80, 100, 160])
@pytest.mark.parametrize("terminal", [True, False])
def test_an_ordinary_summary_fits_one_screen_and_the_fullest_cuts_nothing_that_decides(
    width: int, terminal: bool
) -> None:
    for v, most in ((view(), 45), (crowded(), 80)):
        text = printed(v, width, terminal=terminal, report=Path("out/report/index.html"))
        lines = Text.from_ansi(text).plain.rstrip("\n").split("\n")
        assert len(lines) <= most
        assert max(len(line) for line in lines) <= min(width, 100)
        whole = "".join("".join(lines).split())
        assert "".join((verdict_title(v) + verdict_sentence(v)).split()) in whole
        bars = text.partition("the error falls")[2].partition("noise floor")[0]
        steps = [title_of(v, str(s["added"])).split()[-1] for s in v.result["steps"][1:]]
        assert all(re.search(rf"\b{re.escape(s)}\b", bars) for s in steps), (
            "every step has its bar"
        )
        assert not re.search(r"\w\.\.\.", whole)


@pytest.mark.parametrize("v", [view(), compared(), empty(), crowded()])
def test_a_file_gets_plain_ascii_without_colour(v: View) -> None:
    text = printed(v)
    assert text.isascii()
    assert "\x1b" not in text


def test_a_terminal_gets_colour_and_bars() -> None:
    text = printed(view(), terminal=True)
    assert "\x1b[" in text
    assert "\N{FULL BLOCK}" in text


def test_the_summary_holds_what_was_found() -> None:
    text = printed(view(), report=Path("out/index.html"))
    for words in (
        "Missing effect found: Coulomb friction", "unexplained 0.6 N, noise 0.2 N, model 0.566 N",
        "explainable 89 %",
        "Coulomb friction", "present", "explained better by Coulomb friction", "not excited",
        "not needed", "0.9360 +- 0.0088 N", "8960 +- 880 kN/m", "0 to 10.0 MN/m", "at its bound",
        "chance alone reaches a size of 0.0220 N",
        "noise floor", "velocity 0 to 20 mm/s", "55 %", "note: velocity derived",
        "report: out/index.html",
    ):  # fmt: skip
        assert words in text, words


def test_what_chance_reaches_beside_what_was_found_is_said_where_it_is_less() -> None:
    found = view()
    first, *others = found.result["candidates"]
    candidates = [first | {"threshold": 0.0055}, *others]
    later = replace(found, result=dict(found.result) | {"candidates": candidates})
    assert "a size of 0.0220 N at first, 0.00550 N beside what was found" in printed(later)
    assert "at first" not in printed(found)


def test_the_bars_of_the_falling_error_are_in_proportion() -> None:
    bars = printed(view()).partition("the error falls")[2].partition("\n\n")[0]
    rows = [line for line in bars.splitlines() if "#" in line]
    assert [row.split("  ")[0].strip() for row in rows] == [
        "model, refitted",
        "+ Coulomb friction",
        "noise floor",
    ]
    first, second, floor = (row.count("#") for row in rows)
    assert second == floor
    assert first / second == pytest.approx(3.0, rel=0.05)


def test_a_comparison_shows_where_it_fails_and_no_candidates() -> None:
    text = printed(compared())
    assert "where it fails" in text
    assert "velocity 0 to 20 mm/s" in text
    assert "effect" not in text.split("where it fails")[1]


def test_what_cannot_be_told_apart_is_said_with_the_experiment() -> None:
    text = printed(
        view(verdict="ambiguous", alternatives=[["coulomb_friction", "shear_thinning"]])
    )
    assert (
        "cannot be told apart: Coulomb friction or Shear thinning; record: experiment for"
        in " ".join(text.split())
    )


@pytest.mark.parametrize("verdict", list(TITLES))
def test_every_verdict_stands_in_the_first_line(verdict: str) -> None:
    assert TITLES[verdict] in printed(view(verdict=verdict)).splitlines()[0]


def test_models_stand_side_by_side_and_one_model_tells_its_history() -> None:
    base = compared()
    both = printed(replace(base, result={**base.result, "models": MODELS}))
    rows = [" ".join(line.split()) for line in both.splitlines()]
    assert "new 0.200 N 3.0 % -0.400 N (-0.420 to -0.380) fitted here" in rows
    made = printed(replace(base, result={**base.result, "history": HISTORY}))
    assert "history: + Coulomb friction 0.500 N -> 0.200 N" in made


def test_what_no_record_can_show_is_said() -> None:
    line = "cannot be known from these channels: force_gain"
    assert line in printed(view())
    assert "cannot be known" not in printed(view(unknowable=[]))


def test_brackets_in_names_are_no_markup() -> None:
    v = replace(
        view(candidates=[entry("my [bold] effect", 0.1)]),
        model="rig [bold] 3",
        notes=("file [red]a[/red].csv",),
    )
    text = printed(v)
    assert "my [bold] effect" in text
    assert "rig [bold] 3" in text
    assert "[red]a[/red].csv" in text


def test_identified_parameters_are_told_with_what_the_data_say_of_them() -> None:
    reasons = ["guo_yield.c1 is weakly visible"]
    v = view(
        verdict="identified_in_part", candidates=None, steps=None, reasons=reasons, **IDENTIFIED
    )
    text = printed(replace(v, candidates=(), command="identify"))
    assert "490 +- 11 s/m" in text
    assert "weakly visible" in text
    for words in ("not determined", "at its bound", "20.0 at 0.1", "- guo_yield.c1"):
        assert words in text, words
    assert len(text.splitlines()) <= 40


def test_a_plan_is_told_with_what_each_program_separates_and_where_it_was_written() -> None:
    v = view(verdict="told_apart", candidates=None, steps=None, **PLANNED)
    text = printed(replace(v, candidates=(), command="plan"))
    rows = [" ".join(line.split()) for line in text.splitlines()]
    assert "program 1 3.3 2.0 11.6 0.149 0.30 10 of 10" in rows
    assert "program 2 3.3 1.0 11.6 0.149 0.30" in rows
    assert "identification 0.10 0.020 4.00 0.149 0.27 2 of 10" in rows
    for words in ("repeats every 8 s", "program: next.yaml", "fitted to the data: F_c 0.23 N"):
        assert words in text, words
    assert len(text.splitlines()) <= 40


def test_what_to_plan_next_can_be_pasted() -> None:
    command = "./er lab plan --model m.yaml --data d.csv --between a b --out next.yaml"
    lines = printed(view(next=[command])).splitlines()
    assert f"next: {command}" in lines
    long = "./er lab plan --model m.yaml --data 'my rig/a run.csv' --data b.csv --between a b --out next.yaml"
    for width in (40, 100):
        pasted = printed(view(next=[long]), width).partition("next: ")[2]
        assert max(map(len, pasted.splitlines())) <= width
        command_read = pasted[: pasted.index("next.yaml") + len("next.yaml")]
        assert shlex.split(command_read.replace("\\\n", " ")) == shlex.split(long)


def test_what_made_data_incomplete_is_said_where_it_is_called_incomplete() -> None:
    notes = tuple(f"hole {k}" for k in range(8))
    told = {c: printed(replace(view(complete=c), notes=notes)) for c in (True, False)}
    assert [told[c].count("note: hole") for c in (True, False)] == [3, 6]
    assert "2 more notes in --json and --report" in told[False]


@pytest.mark.parametrize("command", ["check", "diagnose"])
def test_what_is_wrong_with_the_data_is_told_to_the_last_word(command: str) -> None:
    words = " ".join(f"word{k}" for k in range(60))
    found = {**PREFLIGHT["findings"][0], "found": f"{words} found", "remedy": f"{words} remedy"}
    verdict = "usable" if command == "check" else "adequate"
    v = view(preflight={**PREFLIGHT, "findings": [found]}, verdict=verdict)
    text = " ".join(printed(replace(v, command=command), 80).split())
    assert f"{words} found" in text
    assert (f"{words} remedy" in text) == (command == "check")
