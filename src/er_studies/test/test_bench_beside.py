"""The benchmark of what runs beside the loop: late predictions, ratios turn by turn, and what counts as missed."""

from __future__ import annotations

import os
import subprocess
import sys
from time import monotonic, sleep

import numpy as np
import pytest

pytest.importorskip("rclpy")

from er_studies.bench.ros_beside import LIVE, NOTHING, PAGE, PHASES, Phase, family, markdown, ratio
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
    lines = markdown({name: phase(1.0 + k) for k, name in enumerate(PHASES)})
    assert f"| {PAGE} | 6.00 | " in "\n".join(lines)
    assert [line.split("|")[5].strip() for line in lines[2:6]] == ["1.00", "2.00", "3.00", "4.00"]
    assert lines[-1] == (
        f"- {PAGE}: of 300 samples the prediction was later than the tick for 0.00%, "
        "the controller's answer for 58.33%"
    )


def test_late_predictions_and_a_dear_page_are_missed() -> None:
    phases = {name: phase() for name in PHASES}
    assert not missed({})
    assert not missed(phases)
    assert not missed({**phases, NOTHING: phase(late=9), PAGE: phase(late=9)})
    assert missed({**phases, MONITOR.name: phase(late=1)})
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
