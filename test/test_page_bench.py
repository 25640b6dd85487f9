"""What `./er bench page` sees in a browser."""

from __future__ import annotations

from pathlib import Path

import pytest
from er_models.files import load_model
from er_models.shipped import file_of
from er_studies.bench import browser, page
from er_studies.bench.lab.data import record

from test.sample import write_sample


@pytest.mark.slow
@pytest.mark.skipif(not browser.found(), reason="no browser, or nothing that drives it")
def test_every_wait_of_a_user_is_taken(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.delenv("PYTEST_CURRENT_TEST")  # else the page serves a test
    data = write_sample(tmp_path / "run.csv", seed=1, seconds=9.0)
    took = browser.waits(data, file_of("inove_guo", "dampers"))
    assert list(took) == list(browser.TARGETS)
    assert 0.0 < took["command to address"] < took["command to curves"] < browser.LONGEST
    assert 0.0 < took["key on a slider to curves, p95"] < took["command to curves"]
    assert 0.0 < took["processor time of the browser for a key"] < 1.0
    drawn = took["processor time of the browser for the curves"]
    assert took["processor time of the browser for a key"] < drawn < took["command to curves"]
    assert 0.0 < took["click to the first ranked effect"] < browser.LONGEST


def test_without_a_browser_it_says_what_is_missing(monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.setattr(browser, "BROWSER", None)
    with pytest.raises(browser.InputError, match=r"chromium, .*playwright, found none"):
        browser.waits(Path("data.csv"), Path("model.yaml"))


def test_each_figure_of_the_live_page_has_its_time_and_how_often_it_is_drawn() -> None:
    model = load_model(file_of("inove_guo", "dampers"))
    rows = page.live_figures(model, record(model, 10.0), times=1)
    assert [(says, often) for says, _, often in rows] == [
        ("error", "1"), ("force", "2"), ("residual map", "0.5"), ("loops", "1"), ("spectrum", "0.5"),
        ("what the drive shows", "0.5"),
    ]  # fmt: skip
    assert all(float(time.removesuffix(" ms")) > 0.0 for _, time, _ in rows)


def test_a_wait_is_told_in_times_of_the_yardstick_beside_its_target() -> None:
    told = page.seen({"command to address": 1.5, "command to curves": 4.0}, 0.5)
    assert told.rows == [
        ["command to address", "1.5 s", "3", "3"],
        ["command to curves", "4 s", "8", "6"],
        ["the yardstick", "0.5 s", "1", ""],
    ]
