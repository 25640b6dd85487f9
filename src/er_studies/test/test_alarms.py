"""`./er study alarms`: what it counts, and its exit status."""

from __future__ import annotations

import json
import sys
from pathlib import Path

import pytest
from er_model_lab.monitor.simulated import Drive

from er_studies import alarms


def told(monkeypatch: pytest.MonkeyPatch, file: Path) -> int:
    monkeypatch.setattr(sys, "argv", ["alarms", "--hours", "1", "--json", str(file)])
    with pytest.raises(SystemExit) as end:
        alarms.main()
    return int(str(end.value.code))


def test_false_alarms_are_counted_and_more_than_promised_is_a_failure(
    monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    monkeypatch.setattr(alarms, "RUNS", 16)
    monkeypatch.setattr(alarms, "DRIVES", {"white": Drive()})
    file = tmp_path / "alarms.json"
    assert told(monkeypatch, file) == 0
    found = json.loads(file.read_text())
    assert (found["hours"], found["between"]) == (1.0, 24.0)
    white = found["kinds"]["white"]
    assert white["alarms"] == 0
    assert 1.0 < white["median"] <= white["late"] < 4.0
    monkeypatch.setattr(alarms, "alarms", lambda *_: 2)
    assert told(monkeypatch, file) == 1
