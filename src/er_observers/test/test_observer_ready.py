"""An observer that is ready has nothing left to compile, also for what is not the usual sample."""

from __future__ import annotations

import subprocess
import sys
from pathlib import Path

PROGRAM = """
import gc, sys
from numba.core.dispatcher import Dispatcher
from er_models.files import load_model
from er_observers.running.ready import ready
from er_observers.running.runtime import Sample, lose, start, step

gains = ready(sys.argv[1], load_model(sys.argv[2]), "nlpv_polytopic")
nan = float("nan")
dispatchers = [each for each in gc.get_objects() if isinstance(each, Dispatcher)]
before = sum(len(each.overloads) for each in dispatchers)
for seconds in (0.01, 3.0):
    state = start(gains, Sample(0.0, 0.1, -0.2, 0.1))
    for k in range(1, round(seconds / 0.005)):
        state, _ = step(gains, state, Sample(0.005 * k, 0.1, -0.2, 0.1 * (k % 2)))
    for k in range(1, 20):
        state, _ = step(gains, state, Sample(seconds + 0.005 * k, nan, 0.0, nan))
    state, _ = step(gains, state, Sample(seconds + 0.1, 0.1, -0.2, 0.1))
    state = lose(gains, state, seconds + 0.105)
    state, _ = step(gains, state, Sample(seconds + 0.11, 0.1, -0.2, 0.1))
print(sum(len(each.overloads) for each in dispatchers) - before)
"""


def test_no_sample_waits_for_a_compiler(gain_file: Path, car_file: Path) -> None:
    """In a process of its own: here others have compiled what they needed."""
    command = [sys.executable, "-c", PROGRAM, str(gain_file), str(car_file)]
    done = subprocess.run(command, capture_output=True, text=True, check=True)
    assert done.stdout.strip() == "0"
