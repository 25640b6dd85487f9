"""The benchmark of what runs beside the loop: late predictions, ratios turn by turn, and what counts as missed."""

from __future__ import annotations

import os
import subprocess
import sys
from time import monotonic, sleep

import numpy as np
import pytest

pytest.importorskip("rclpy")

from er_studies.bench.ros_beside import (
    BUSY,
    LIVE,
    NOTHING,
    PAGE,
    PHASES,
    Phase,
    family,
    ratio,
    tables,
)
from er_studies.bench.ros_monitor import MONITOR, missed


def phase(scale: float = 1.0, late: int = 0) -> Phase:
    """Three turns on a machine that gets slower; in each a hundred answers."""
    turns = [k * scale * np.linspace(1.0, 2.0, 100) for k in (0.5, 1.0, 2.0)]
    answers = [np.r_[np.full(100 - late, 1.0), np.full(late, 5.1)] for _ in turns]
    parts = {name: 6.0 for name in ("plant", MONITOR.name, LIVE)}
    return Phase(turns, answers, 300, [6.0, 6.0, 6.0], parts)


def test_a_prediction_that_came_late_or_never_is_late() -> None:
    assert phase().late == 0.0
    assert phase(late=2).late == pytest.approx(0.02)
    lost = phase(late=2)
    lost.due += 100
    assert lost.late == pytest.approx(106 / 400)
    assert phase().late_loop == pytest.approx(0.0)
    assert phase(2.5).late_loop == pytest.approx(0.33), "longer than 5 ms in the last turn"


def test_the_loop_is_compared_turn_by_turn_since_a_machine_gets_slower() -> None:
    assert ratio(phase(1.5), phase()) == pytest.approx(1.5)
    loops, processes = tables({name: phase(1.0 + k) for k, name in enumerate(PHASES)})
    assert [row[4] for row in loops.rows] == ["1.00", "2.00", "3.00", "4.00", "5.00"]
    assert loops.rows[-1][:2] == [PAGE, "7.50"]
    assert loops.rows[-1][-2:] == ["0.00%", "66.33%"]
    assert loops.rows[0][-2:] == ["", ""]
    assert ["plant", "6.0", "1.00"] in processes.rows


def test_late_predictions_and_a_dear_page_are_missed() -> None:
    phases = {name: phase() for name in PHASES}
    assert not missed({})
    assert not missed(phases)
    assert not missed({**phases, NOTHING: phase(late=9), PAGE: phase(late=9)})
    assert missed({**phases, MONITOR.name: phase(late=1)})
    assert missed({**phases, PAGE: phase(1.4)})
    assert not missed({**phases, PAGE: phase(1.4), BUSY: phase(1.4)})
    phases[PAGE].parts[LIVE] = 15.1
    assert missed(phases)


def test_the_processor_time_of_a_process_is_that_of_what_it_started_too() -> None:
    starts = "import subprocess, sys; subprocess.run([sys.executable, '-c', 'input()'])"
    with subprocess.Popen([sys.executable, "-c", starts], stdin=subprocess.PIPE) as child:
        until = monotonic() + 20.0
        while len(found := family(child.pid)) < 2 and monotonic() < until:
            sleep(0.02)
        assert (found[0], len(found)) == (child.pid, 2)
        assert {*found} <= {*family(os.getpid())}
        child.communicate(b"\n")
