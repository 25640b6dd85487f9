"""The table of false alarms counts decisions, and the picture is drawn from the same rows."""

import json

import pytest

from test.blind_score import alarms
from test.blind_score.alarms import RATES, lines, page, plot

pytestmark = pytest.mark.slow


def rows_of(many, hits):
    return [
        {
            "over": [i < h for h in hits],
            "named": [i < h // 2 for h in hits],
            "largest": 0.01 * i,
            "by_rule": i == 0,
            "seed": i,
        }
        for i in range(many)
    ]


def test_every_rate_has_its_counts():
    found = lines(rows_of(20, (2, 4, 6)))
    assert [c[0] for c in found] == [f"{r:.0%}" for r in RATES]
    assert [c[1] for c in found] == ["2/20", "4/20", "6/20"]
    assert [c[3] for c in found] == ["1/20", "2/20", "3/20"]
    text = page(rows_of(20, (2, 4, 6)), "head")
    assert "1 of 20" in text
    assert "0.19 of the noise" in text


def test_the_picture_is_the_same_for_the_same_rows(tmp_path):
    first, second = tmp_path / "a.svg", tmp_path / "b.svg"
    plot(rows_of(20, (2, 4, 6)), first)
    plot(rows_of(20, (2, 4, 6)), second)
    assert first.read_bytes() == second.read_bytes()
    assert "rate of false alarms asked for" in first.read_text()


def test_a_complete_model_is_decided_at_every_rate(tmp_path, capsys):
    """As `docs/results/blind.md` has it, the command with a shorter record, its row and its table."""
    noted = tmp_path / "rows.jsonl"
    words = ["--seeds", "1", "--workers", "1", "--seconds", "12", "--results", str(noted)]
    status = alarms.main(words)
    assert status == 0
    assert "By the default rule" in capsys.readouterr().out
    (row,) = (json.loads(line) for line in noted.read_text().splitlines())
    assert len(row["over"]) == len(row["named"]) == len(RATES)
    assert row["over"] == sorted(row["over"])
    assert not any(n and not o for n, o in zip(row["named"], row["over"], strict=True))
    assert 0.0 <= row["p"] <= 1.0
