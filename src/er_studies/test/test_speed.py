"""Speed, memory and the benchmarks: bounds that only a lost order of magnitude can break, in processor time so that a
busy machine does not; and references that compute the same, else a ratio of times says nothing."""

from __future__ import annotations

import json
import time
import tracemalloc
from collections.abc import Callable
from pathlib import Path
from xml.etree import ElementTree

import numpy as np
import pytest
from er_models.constants import SAMPLE_TIME as DT
from er_models.model import Array, Model
from er_models.prediction import Motion, predict
from er_models.simulation import simulate
from er_studies.bench.models.__main__ import main
from er_studies.bench.models.c_reference import c_predict, c_simulate, compiler
from er_studies.bench.models.cases import TINY, car, damper, drive, road
from er_studies.bench.models.measure import PARTS
from er_studies.bench.models.scipy_reference import (
    TIGHT,
    as_exact,
    scipy_force,
    scipy_ride,
    splined,
)
from er_studies.bench.models.timing import Line, best, table
from numba.core.runtime import _nrt_python as native
from numba.core.runtime import rtsys

HANDED_OVER = 13
"""Arrays among the arguments of `predict_rows`; numba counts a reference to each like an array."""
OF_STATES = 3
"""Arrays that the kernel makes: its workspace, the states where records end, and those where the next begins."""
NEEDS_C = pytest.mark.skipif(compiler() is None, reason="no C compiler (gcc or cc)")


def span(y: Array) -> float:
    """Range of a signal: what errors are measured against, as in (3.79)."""
    return float(np.ptp(y))


def used(*runs: Callable[[], object], times: int = 5) -> list[float]:
    """Processor time of the fastest of so many runs of each [s], in turn: a machine is not as fast all the time."""
    for run in runs:
        run()
    best = [np.inf] * len(runs)
    for _ in range(times):
        for k, run in enumerate(runs):
            start = time.process_time()
            run()
            best[k] = min(best[k], time.process_time() - start)
    return best


def test_a_minute_is_predicted_in_under_20_ms() -> None:
    inputs = drive(60.0)
    assert used(lambda: predict(damper(), inputs))[0] < 0.02


def test_a_minute_in_the_car_takes_under_a_quarter_of_a_second() -> None:
    height, duty = road(60.0), drive(60.0).u
    assert used(lambda: simulate(car(), DT, height, duty))[0] < 0.25


def test_cost_is_linear_in_the_samples() -> None:
    short, long = drive(30.0), drive(120.0)
    four, one = used(lambda: predict(damper(), long), lambda: predict(damper(), short), times=15)
    assert 2.5 < four / one < 6.0


def allocations(model: Model, inputs: Motion) -> tuple[int, int]:
    """Arrays that the kernel makes in a prediction, and the most bytes that Python takes."""
    predict(model, inputs)
    before = rtsys.get_allocation_stats().mi_alloc
    tracemalloc.start()
    predict(model, inputs)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    return int(rtsys.get_allocation_stats().mi_alloc - before), peak


@pytest.mark.parametrize("name", ["", "mount_compliance", "self_heating"])
def test_memory_is_that_of_the_result(name: str) -> None:
    """A record thirty times longer takes its own row of forces more, and no array beside it."""
    native.memsys_enable_stats()
    model = damper(name) if name else damper()
    records = [drive(seconds) for seconds in (2.0, 60.0)]
    (few, small), (many, large) = (allocations(model, inputs) for inputs in records)
    assert (few, many) == (HANDED_OVER + OF_STATES,) * 2, (
        "no array is made but those of the states"
    )
    assert large - small <= 8 * (records[1].n - records[0].n) + 2000


def test_prediction_is_that_of_scipy() -> None:
    part = drive(2.0)
    exact = scipy_force(damper(), part, TIGHT)
    assert np.abs(predict(damper(), part) - exact).max() < 1e-3 * span(exact)
    assert np.abs(scipy_force(damper(), part, TIGHT, splined) - exact).max() < 1e-7 * span(exact)


def test_the_ride_is_that_of_scipy() -> None:
    height, duty = road(1.0), drive(1.0).u
    exact = scipy_ride(car(), DT, height, duty, TIGHT)
    error = simulate(car(), DT, height, duty)["damper_force"] - exact
    assert np.abs(error).max() < 1e-3 * span(exact)


def test_the_loosest_tolerance_that_is_exact_enough_is_taken() -> None:
    assert as_exact(lambda rtol: np.array([rtol]), np.zeros(1), 2e-4) == pytest.approx(1e-4)


@NEEDS_C
def test_prediction_is_that_of_c() -> None:
    """The duty jumps and the start is in motion; a few rounding errors and no more."""
    inputs = drive(20.0)
    force = c_predict(damper(), inputs)
    assert np.abs(predict(damper(), inputs) - force).max() < 1e-9 * span(force)


@NEEDS_C
def test_the_ride_is_that_of_c() -> None:
    height, duty = road(20.0), drive(20.0).u
    run, outputs = simulate(car(), DT, height, duty), c_simulate(car(), DT, height, duty)
    names = "sprung_acceleration unsprung_acceleration damper_force deflection deflection_velocity"
    for name, column in zip(names.split(), outputs.T, strict=True):
        assert np.abs(run[name][1:] - column).max() < 1e-9 * span(column), name


def test_runs_take_turns() -> None:
    order: list[str] = []
    ticks = iter(range(1000))
    found = best(
        {"a": lambda: order.append("a"), "b": lambda: order.append("b")},
        0.0,
        lambda: next(ticks) ** 2,
    )
    assert order == ["a", "b"] * 3
    assert found == {"a": 1.0, "b": 5.0}


def test_a_line_says_time_and_ratio() -> None:
    row = table([Line("what", 2.5e-3, 0.5, "that", "why")]).splitlines()[-1]
    assert row == "| what | 2.5 ms | 0.5 times that | why |"


def test_every_part_of_the_benchmark_runs(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """On short records; the start of a fresh process is left out, which compiles the kernel anew."""
    parts = [name for name in PARTS if name != "starting"]
    main(
        [
            *parts,
            "--tiny",
            "--json",
            str(tmp_path / "all.json"),
            "--plot",
            str(tmp_path / "cost.svg"),
        ]
    )
    found = json.loads((tmp_path / "all.json").read_text())
    assert {*found.pop("machine")[0]} == {"machine", "reference loop in C", "in Python"}
    assert set(found) == set(parts)
    assert "SciPy, motion by cubics" in capsys.readouterr().out
    assert all(line["seconds"] > 0.0 for lines in found.values() for line in lines)
    assert found["length"][-1]["n"] == drive(8.0 * TINY.record).n
    drawn = ElementTree.parse(tmp_path / "cost.svg").getroot()
    assert len(drawn.findall(".//{http://www.w3.org/2000/svg}polyline")) == 4


def test_an_unknown_part_is_refused(capsys: pytest.CaptureFixture[str]) -> None:
    with pytest.raises(SystemExit) as stop:
        main(["everything"])
    assert stop.value.code == 2
    assert "expected some of prediction" in capsys.readouterr().err
