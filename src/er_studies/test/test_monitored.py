"""`./er study monitor`: the live monitor along measured runs."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from er_models.errors import InputError
from er_models.files import load_model
from er_models.shipped import file_of
from er_records.record import Record
from er_records.write import write_csv
from er_studies.bench.page import record

from er_studies import monitored

MODEL = load_model(file_of("inove_guo", "dampers"))


def runs(*factors: float) -> list[Record]:
    """Runs of 40 s, the force of each times a factor."""
    made, whole = [], record(MODEL, 40.0 * len(factors))
    for k, factor in enumerate(factors):
        part = whole.slice(k * len(whole) // len(factors), (k + 1) * len(whole) // len(factors))
        channels = {**part.channels, "damper_force": factor * part.channels["damper_force"]}
        made.append(replace(part, name=f"run {k}", channels=channels))
    return made


def test_a_damper_that_stays_is_no_alarm_and_an_error_that_grows_is_found() -> None:
    found = monitored.ordered(MODEL, runs(1.0, 1.0, 1.0, 1.0), seed=1)
    assert found.alarms == ()
    assert 60.0 < found.motion < 100.0
    assert 0.0 < found.found < 10.0


def test_the_run_in_which_a_damper_is_another_is_named() -> None:
    last = np.random.default_rng(1).permutation(4)[-1]
    factors = [0.5 if k == last else 1.0 for k in range(4)]
    assert monitored.ordered(MODEL, runs(*factors), seed=1).alarms == (f"run {last}",)


def test_runs_of_several_rates_are_refused(tmp_path: Path) -> None:
    first, second = runs(1.0, 1.0)
    write_csv(first, tmp_path / "a.csv")
    write_csv(_slow(second), tmp_path / "b.csv")
    with pytest.raises(InputError, match="runs of one rate"):
        monitored.monitor_command([tmp_path], file_of("inove_guo", "dampers"), 1, 1, None)


def test_too_little_motion_to_judge_and_a_force_that_is_missing_are_refused() -> None:
    with pytest.raises(InputError, match="more than 60 s of motion"):
        monitored.ordered(MODEL, runs(1.0), seed=1)
    silent = [
        replace(r, channels={k: y for k, y in r.channels.items() if k != "damper_force"})
        for r in runs(1.0, 1.0, 1.0)
    ]
    with pytest.raises(InputError, match="damper_force"):
        monitored.ordered(MODEL, silent, seed=1)


def _slow(given: Record) -> Record:
    """Every second sample."""
    channels = {name: y[::2] for name, y in given.channels.items()}
    return replace(given, t=given.t[::2], channels=channels)
