"""The measurements, each a list of lines."""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import tracemalloc
from collections.abc import Callable
from functools import partial
from pathlib import Path
from time import perf_counter, process_time

import numpy as np
from er_models.catalogue import CATALOGUE
from er_models.constants import SAMPLE_TIME as DT
from er_models.model import Array, Model
from er_models.parallel import cores
from er_models.prediction import Motion, predict, predict_many
from er_models.simulation import initial_state, prepare, simulate, step

from er_studies.bench.models.c_reference import c_predict, c_simulate, compiler
from er_studies.bench.models.cases import Size, car, damper, drive, road
from er_studies.bench.models.scipy_reference import (
    TIGHT,
    as_exact,
    scipy_force,
    scipy_ride,
    splined,
)
from er_studies.bench.models.timing import Line, best

NO_C = "no C compiler (gcc or cc) on this machine"
_START = "from er_studies.bench.models import measure; measure.first_prediction()"
BATCH = 16
"""Vectors of a batch."""


def _compared(
    what: str,
    kernel: Callable[[], Array],
    in_c: Callable[[], object],
    by_scipy: dict[str, Callable[[float], Array]],
    size: Size,
) -> list[Line]:
    """A run beside the same in C and by SciPy, at the loosest tolerance (the argument) that errs no more."""
    first = next(iter(by_scipy.values()))
    exact = first(TIGHT)
    error = float(np.abs(kernel() - exact).max())
    rtol = as_exact(first, exact, error)
    quick = best({"kernel": kernel, **({"C": in_c} if compiler() else {})}, size.patience)
    mine = quick["kernel"]
    off = f"error {100 * error / float(np.ptp(exact)):.2g} % of the range"
    lines = [Line(what, mine, remark=f"{off}; {NO_C}")]
    if compiler():
        lines = [
            Line(what, mine, mine / quick["C"], "that in C", off),
            Line("the same loop in C, -O3", quick["C"]),
        ]
    slow = best({name: partial(run, rtol) for name, run in by_scipy.items()}, 2.0 * size.patience)
    return lines + [
        Line(f"{name}, rtol {rtol:.0e}", seconds, seconds / mine, "that of the kernel")
        for name, seconds in slow.items()
    ]


def prediction(size: Size) -> list[Line]:
    """Prediction along a motion."""
    model, inputs = damper(), drive(size.record)
    return _compared(
        f"predict, dynamic Guo, {size.record:g} s at 200 Hz", lambda: predict(model, inputs),
        lambda: c_predict(model, inputs),
        {
            "SciPy, motion by cubics in plain Python": lambda rtol: scipy_force(model, inputs, rtol),
            "SciPy, motion by its CubicHermiteSpline": lambda rtol: scipy_force(model, inputs, rtol, splined),
        }, size,
    )  # fmt: skip


def ride(size: Size) -> list[Line]:
    """Simulation of the quarter car, and one sample of it for a node."""
    model, height, duty = car(), road(size.record), drive(size.record).u
    lines = _compared(
        f"simulate the car, chirp, {size.record:g} s at 200 Hz",
        lambda: simulate(model, DT, height, duty)["damper_force"],
        lambda: c_simulate(model, DT, height, duty),
        {"SciPy": lambda rtol: scipy_ride(model, DT, height, duty, rtol)}, size,
    )  # fmt: skip
    plant = prepare(model, DT)
    state = initial_state(plant)
    one = best({"step": lambda: step(plant, state, (0.001, 0.2))}, size.patience)["step"]
    return [
        *lines,
        Line("step of the plant node", one, remark=f"{100 * one / DT:.2g} % of a sample"),
    ]


def batch(size: Size) -> list[Line]:
    """Many vectors of parameters at once, over the cores and one after another.

    The records are short, so that on a busy machine some run finds all cores free. Where the processor time is the
    same for both ways, nothing but other work keeps the cores from their full gain.
    """
    seconds, lines = size.record / 6.0, []
    for title, model in (("dynamic Guo", damper()), ("with mount", damper("mount_compliance"))):
        inputs = drive(seconds)
        vectors = np.repeat(model.compiled().p[None], BATCH, axis=0)
        runs: dict[str, Callable[[], object]] = {
            "one": partial(_one_by_one, model, vectors, inputs),
            "all": partial(predict_many, model, vectors, inputs),
        }
        found, work = best(runs, 3.0 * size.patience, perf_counter), best(runs, size.patience)
        gain = f"{found['one'] / found['all']:.2f} times faster"
        lines += [
            Line(f"{title}: {BATCH} vectors of {seconds:g} s one after another", found["one"]),
            Line(f"predict_many over {cores()} cores", found["all"], found["all"] / found["one"], "that", gain),
            Line("processor time of it", work["all"], work["all"] / work["one"], "that of one after another"),
        ]  # fmt: skip
    return lines


def _one_by_one(model: Model, vectors: Array, inputs: Motion) -> None:
    """The same predictions in this thread."""
    for p in vectors:
        predict_many(model, p[None], inputs)


def length(size: Size) -> list[Line]:
    """Cost over the number of samples: records of 1/4 to 8 times the size."""
    model = damper()
    times = [size.record * f for f in (0.25, 0.5, 1.0, 2.0, 4.0, 8.0)]
    records = {t: drive(t) for t in times}
    found = best(
        {f"{t:g}": partial(predict, model, records[t]) for t in times}, 2.0 * size.patience
    )
    base = f"{size.record:g}"
    return [
        Line(f"predict, {t:g} s", found[f"{t:g}"], found[f"{t:g}"] / found[base], f"{base} s",
             f"{1e9 * found[f'{t:g}'] / records[t].n:.3g} ns a sample", records[t].n)
        for t in times
    ]  # fmt: skip


def number(size: Size) -> list[Line]:
    """Cost over the number of effects without states: from the plain damper on, two more at a time."""
    inputs = drive(size.record)
    simple = [e.name for e in CATALOGUE.candidates() if e.stage == "force" and not e.has_state]
    models = [damper(*simple[:k]) for k in range(0, len(simple) + 1, 2)]
    found = best(
        {str(i): partial(predict, m, inputs) for i, m in enumerate(models)}, 2.0 * size.patience
    )
    return [
        Line(f"predict with {len(m.effects) - 3} effects more", found[str(i)], found[str(i)] / found["0"],
             "none", n=len(m.effects) - 3)
        for i, m in enumerate(models)
    ]  # fmt: skip


def effects(size: Size) -> list[Line]:
    """What each effect adds to a prediction, dearest first."""
    inputs, alone = drive(size.record), damper()
    lines = []
    for effect in CATALOGUE.candidates():
        model = damper(effect.name)
        runs = {
            "with": partial(predict, model, inputs),
            "without": partial(predict, alone, inputs),
        }
        found = best(runs, 0.1 * size.patience)
        ratio = found["with"] / found["without"]
        lines.append(Line(f"with {effect.name}", found["with"], ratio, "without"))
    lines.sort(key=lambda line: -(line.ratio or 0.0))
    return lines


def memory(size: Size) -> list[Line]:
    """Most memory that a prediction takes beyond what it is given, for longer and longer records."""
    lines, model = [], damper()
    predict(model, drive(1.0))
    for times in (1.0, 10.0, 100.0):
        inputs = drive(times * size.record)
        start = process_time()
        traced, grown = _peak(partial(predict, model, inputs))
        each = f"{traced / inputs.n:.3g} bytes a sample, 8 of them the result"
        known = f"; resident set {1e-6 * grown:.3g} MB more" if grown is not None else ""
        lines.append(
            Line(f"predict, {times * size.record / 60.0:g} min", process_time() - start,
                 remark=each + known, n=inputs.n)
        )  # fmt: skip
    return lines


def _peak(run: Callable[[], object]) -> tuple[int, int | None]:
    """Bytes that Python allocates at most during a run, and by which the resident set grows (Linux)."""
    tracemalloc.start()
    before = _resident("VmRSS")
    run()
    traced, after = tracemalloc.get_traced_memory()[1], _resident("VmHWM")
    tracemalloc.stop()
    return traced, None if before is None or after is None else max(after - before, 0)


def _resident(name: str) -> int | None:
    """A figure of this process's memory [bytes]; the high-water mark counts from the last look at VmRSS on."""
    try:
        if name == "VmRSS":
            Path("/proc/self/clear_refs").write_text("5", encoding="ascii")
        text = Path("/proc/self/status").read_text(encoding="ascii")
    except OSError:
        return None
    return next((1024 * int(x.split()[1]) for x in text.splitlines() if x.startswith(name)), None)


def first_prediction() -> None:
    """What a fresh process pays before its second prediction."""
    predict(damper(), drive(1.0))


def starting(_size: Size) -> list[Line]:
    """A fresh process with an empty and with a filled cache."""
    times = []
    with tempfile.TemporaryDirectory() as folder:
        environment = {**os.environ, "ER_CACHE_DIR": folder}
        for code in (_START, _START, "import er_studies.bench.models.measure"):
            start = perf_counter()
            subprocess.run([sys.executable, "-c", code], env=environment, check=True)
            times.append(perf_counter() - start)
    later = f"{times[1] - times[2]:.2f} s more than the import"
    return [
        Line("first process: import, compile, predict", times[0], times[0] / times[1], "later"),
        Line("later process: import, load, predict", times[1], remark=later),
    ]


PARTS: dict[str, Callable[[Size], list[Line]]] = {
    "prediction": prediction, "ride": ride, "batch": batch, "length": length, "number": number,
    "memory": memory, "effects": effects, "starting": starting,
}  # fmt: skip
