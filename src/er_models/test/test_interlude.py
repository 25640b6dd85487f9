"""A run in the middle of a drive: whose road and duty act when, and what a rig does not take."""

from dataclasses import replace

import numpy as np
import pytest
from er_models.errors import InputError
from er_models.files import load_model
from er_models.interlude import GO_OVER, Interlude, begun, check_run, ended, rules
from er_models.program import Program

DT = 0.005
DRIVE = Program(
    {"kind": "sine", "amplitude": 0.005, "frequency": 1.3},
    {"kind": "steps", "low": 0.0, "high": 0.1},
    duration=0.0,
    seed=3,
)
RUN = Program(
    {"kind": "sine", "amplitude": 0.004, "frequency": 2.0},
    {"kind": "constant", "level": 0.2},
    duration=5.0,
    seed=0,
    name="run",
)
BEGIN, FIRST, LAST = 10.0, 10.0 + GO_OVER, 10.0 + GO_OVER + RUN.duration
T = DT * np.arange(4000.0)


def driven() -> Interlude:
    return begun(DRIVE, RUN, BEGIN)


def test_road_and_duty_are_the_runs_for_as_long_as_it_takes_and_the_drives_before_and_after() -> (
    None
):
    drive = driven()
    own = (T >= FIRST) & (T < LAST)
    around = (T <= BEGIN) | (T >= LAST + GO_OVER)
    run = RUN.heights(np.maximum(T - FIRST, 0.0))
    assert np.allclose(drive.heights(T)[own], run[own], rtol=0.0, atol=1e-15)
    assert np.array_equal(drive.heights(T)[around], DRIVE.heights(T)[around])
    assert np.all(drive.duties(T)[own] == 0.2)
    assert np.array_equal(drive.duties(T)[~own], DRIVE.duties(T)[~own])
    assert [rules(drive, t) for t in T[::100]] == own[::100].tolist()
    assert not rules(DRIVE, FIRST)
    assert drive.duration == 0.0


def test_the_road_goes_over_without_a_step() -> None:
    apart = np.abs(np.diff(driven().heights(T)))
    each = [np.abs(np.diff(p.heights(T))).max() for p in (DRIVE, RUN)]
    assert apart.max() < sum(each) + 1.6 * DT / GO_OVER * 0.01


def test_a_run_that_is_ended_goes_back_at_once_and_another_begins_when_the_road_is_back() -> None:
    drive = driven()
    with pytest.raises(
        InputError, match=r"no run under way: empty ends it, found one for .* 5.0 s"
    ):
        begun(drive, RUN, 12.0)
    short = ended(drive, 12.0)
    assert (short.duties(T) == 0.2).sum() == 200
    assert np.abs(np.diff(short.heights(T))).max() < 1.0e-3
    again = begun(short, RUN, 13.0)
    assert (again.drive, again.begin) == (DRIVE, 13.0)
    assert ended(DRIVE, 3.0) is DRIVE


def test_a_drive_is_not_over_before_the_run_is() -> None:
    assert begun(replace(DRIVE, duration=12.0), RUN, BEGIN).duration == 17.0
    assert begun(replace(DRIVE, duration=60.0), RUN, BEGIN).duration == 60.0


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({}, ""),
        ({"duration": 0.0}, "duration: expected a run that ends"),
        ({"road": {**RUN.road, "amplitude": 0.06}}, "stroke: expected at most 0.012 m of defl"),
        ({"road": {**RUN.road, "frequency": 8.0}}, "velocity_max: expected at most 0.15 m/s"),
        ({"duty": {"kind": "constant", "level": 0.5}}, "duty_max: expected at most 0.3 of duty"),
    ],
)
def test_a_run_beyond_the_rig_is_refused(change: dict[str, object], words: str) -> None:
    model, run = load_model("inove_quarter_car"), replace(RUN, **change)  # type: ignore[arg-type]
    if not words:
        check_run(run, model, DT, "run.yaml")
        return
    with pytest.raises(InputError, match=words):
        check_run(run, model, DT, "run.yaml")
