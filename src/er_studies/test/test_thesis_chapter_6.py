"""Chapter 6 made again: mimics, domain, page and command."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest
from er_studies.thesis.chapter_6 import SEQUENCES, Chapter6, chapter_6
from er_studies.thesis.command import app
from typer.testing import CliRunner

ROOT = Path(__file__).resolve().parents[3]


@pytest.fixture(scope="module")
def found() -> Chapter6:
    """Everything of chapter 6."""
    return chapter_6(ROOT / "config")


def test_mimic_and_fault_agree_where_a_duty_exists(found: Chapter6) -> None:
    assert [c.name for c in found.cases] == list(SEQUENCES)
    for case in found.cases:
        assert case.worst < 0.01, case.name
        assert case.exists > 0.5, case.name
        assert np.all((case.copied != case.faulty)[~case.mimic.exists])
        assert np.std(case.faulty - found.healthy) > 0.02 * np.std(found.healthy)


def test_leaking_forces_are_the_healthy_ones_shrunk(found: Chapter6) -> None:
    for healthy, leaking in (found.ideal, found.real):
        assert np.allclose(leaking.high, 0.6 * healthy.high)
        assert np.allclose(leaking.low, 0.6 * healthy.low)
    healthy, _ = found.real
    assert np.all(found.healthy <= healthy.high + 1e-9)
    assert np.all(found.healthy >= healthy.low - 1e-9)


def test_command_writes_page_and_data(tmp_path: Path) -> None:
    """As `./er study thesis chapter6` does."""
    out = tmp_path / "found.json"
    asked = ["chapter6", "--config", str(ROOT / "config"), "--json", str(out)]
    done = CliRunner().invoke(app, [*asked, "--report", str(tmp_path / "page")])
    assert done.exit_code == 0, done.output
    assert "electrical" in done.output
    data = json.loads(out.read_text())
    assert set(data["mimics"]) == set(SEQUENCES)
    assert any((tmp_path / "page").iterdir())
