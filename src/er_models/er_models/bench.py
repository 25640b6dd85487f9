"""Speed of prediction and simulation, each with its reference in the same run: ``python -m er_models.bench``.

The reference is SciPy's `solve_ivp` on the same equations: the hooks of the effects as plain Python, at the tolerance
at which its error is that of the prediction.
"""

from __future__ import annotations

import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass
from itertools import pairwise
from typing import Any

import numpy as np
from scipy.integrate import solve_ivp

from er_models.catalogue import CATALOGUE
from er_models.model import Array, Model
from er_models.predict import Motion, motion, predict, predict_many
from er_models.scales import Scales
from er_models.simulate import initial_state, prepare, simulate, step

SCALES = Scales(force=20.0, deflection=0.010, velocity=0.15, duty=0.3)
DT = 0.005
SECONDS = 60.0
_REFERENCE_SECONDS = 4.0
_START = "from er_models import bench; bench.first_prediction()"


@dataclass(frozen=True)
class Line:
    """One measurement: what, time [s], and a remark with the ratio to a reference."""

    what: str
    seconds: float
    remark: str = ""


def damper(*names: str) -> Model:
    """A Guo damper with response time, and more effects, at their starts."""
    model = Model("bench", {}, SCALES)
    for name in ("passive", "guo_yield", "response", *names):
        model = model.with_effect(name)
    return model


def drive(seconds: float = SECONDS) -> Motion:
    """Two sines within the envelope and a duty in steps, at 200 Hz."""
    t = np.arange(round(seconds / DT) + 1) * DT
    duty = np.repeat(SCALES.duty * np.random.default_rng(0).random(t.size // 100 + 1), 100)[
        : t.size
    ]
    parts = ((0.007, 2.0, 0.3), (0.001, 7.0, 0.0))

    def derivative(order: int) -> Array:
        total = np.zeros(t.size)
        for amplitude, f, phase in parts:
            omega = 2.0 * np.pi * f
            total += amplitude * omega**order * np.sin(omega * t + phase + 0.5 * np.pi * order)
        return total

    return motion(DT, derivative(0), derivative(1), duty, derivative(2))


def fastest(run: Callable[[], object], seconds: float = 1.0) -> float:
    """Shortest of the times that fit into `seconds` [s]; two at least."""
    run()
    best, end = np.inf, time.perf_counter() + seconds
    for count in range(10_000):
        start = time.perf_counter()
        run()
        best = min(best, time.perf_counter() - start)
        if count and time.perf_counter() > end:
            break
    return float(best)


def first_prediction() -> None:
    """What a fresh process pays before its second prediction."""
    predict(damper(), drive(1.0))


def scipy_force(model: Model, inputs: Motion, rtol: float) -> Array:
    """Force of the dynamic Guo damper by `solve_ivp`, one interval of constant duty after another."""
    p, y, tau = (model.effects[n] for n in ("passive", "guo_yield", "response"))
    target: Any = CATALOGUE["guo_yield"].hooks["target"]
    relax: Any = CATALOGUE["response"].hooks["relax"]
    x_of, v_of = (_cubic(inputs.t, a, b) for a, b in ((inputs.x, inputs.v), (inputs.v, inputs.a)))

    def slope(t: float, w: Array, u: float) -> list[float]:
        asked = target(**y, x=x_of(t), v=v_of(t), u=u)
        rate, asked = relax(tau_y=tau["tau"], tau_scale=1.0, y=asked)
        return [asked - rate * w[0]]

    w = [float(target(**y, x=inputs.x[0], v=inputs.v[0], u=inputs.u[0]))]
    f_y = np.empty(inputs.n)
    edges = sorted({0, inputs.n - 1, *(int(k) + 1 for k in np.flatnonzero(np.diff(inputs.u)))})
    for i, j in pairwise(edges):
        grid = inputs.t[i : j + 1]
        args = (float(inputs.u[i]),)
        solution = solve_ivp(
            slope, (grid[0], grid[-1]), w, "LSODA", t_eval=grid, args=args, rtol=rtol, atol=rtol
        )
        f_y[i : j + 1], w = solution.y[0], [float(solution.y[0, -1])]
    return np.asarray(p["k0"] * inputs.x + p["c0"] * inputs.v + f_y)


def _cubic(t: Array, y: Array, d: Array) -> Callable[[float], float]:
    """Cubic between samples, from values and slopes."""
    from scipy.interpolate import CubicHermiteSpline

    spline = CubicHermiteSpline(t, y, d)
    return lambda s: float(spline(s))


def prediction() -> list[Line]:
    """Prediction against SciPy, over cores, and over length."""
    model, inputs = damper(), drive()
    alone = fastest(lambda: predict(model, inputs))
    part = drive(_REFERENCE_SECONDS)
    exact = scipy_force(model, part, 1e-9)
    error = float(np.abs(predict(model, part) - exact).max() / np.ptp(exact))
    rtol = next(r for r in 10.0 ** -np.arange(2.0, 9.0) if _error(model, part, r, exact) <= error)
    start = time.perf_counter()
    scipy_force(model, part, rtol)
    reference = (time.perf_counter() - start) * SECONDS / _REFERENCE_SECONDS
    vectors = np.repeat(model.compiled().p[None], 2 * (os.cpu_count() or 1), axis=0)
    many = fastest(lambda: predict_many(model, vectors, inputs)) / vectors.shape[0]
    double = drive(2.0 * SECONDS)
    longer = fastest(lambda: predict(model, double))
    return [
        Line(
            "predict, dynamic Guo, 60 s at 200 Hz",
            alone,
            f"error {100 * error:.3f} % of the range",
        ),
        Line(
            f"the same by SciPy, rtol {rtol:.0e}",
            reference,
            f"{reference / alone:.0f} times longer",
        ),
        Line(
            "predict_many, per vector",
            many,
            f"{alone / many:.2f} times faster on {os.cpu_count()} cores",
        ),
        Line("predict, 120 s", longer, f"{longer / alone:.2f} times 60 s"),
    ]


def _error(model: Model, part: Motion, rtol: float, exact: Array) -> float:
    """Largest error of SciPy at a tolerance, as a share of the range."""
    return float(np.abs(scipy_force(model, part, rtol) - exact).max() / np.ptp(exact))


def effects() -> list[Line]:
    """What each effect adds to a prediction, dearest first."""
    inputs = drive()
    alone = fastest(lambda: predict(damper(), inputs), 0.5)
    lines = []
    for effect in CATALOGUE.candidates():
        model = damper(effect.name)
        seconds = fastest(lambda model=model: predict(model, inputs), 0.1)  # type: ignore[misc]
        lines.append(Line(f"with {effect.name}", seconds, f"{seconds / alone:.2f} times without"))
    lines.sort(key=lambda line: -line.seconds)
    every = damper(*(e.name for e in CATALOGUE.candidates()))
    seconds = fastest(lambda: predict(every, inputs), 0.5)
    return [
        Line("with all effects at once", seconds, f"{seconds / alone:.1f} times without"),
        *lines,
    ]


def vehicle() -> list[Line]:
    """The quarter car: a record, and one sample for a node."""
    values = {"m_s": 2.27, "m_us": 0.25, "k_s": 1396.0, "k_t": 12270.0}
    model = damper().with_effect("quarter_car", values)
    t = np.arange(round(SECONDS / DT) + 1) * DT
    road = 0.004 * np.sin(2.0 * np.pi * 10.0 / (2.0 * SECONDS) * t**2)
    whole = fastest(lambda: simulate(model, DT, road, drive().u))
    plant = prepare(model, DT)
    state = initial_state(plant)
    one = fastest(lambda: step(plant, state, (0.001, 0.2)), 0.3)
    return [
        Line(
            "simulate the car, chirp, 60 s at 200 Hz",
            whole,
            f"{SECONDS / whole:.0f} times real time",
        ),
        Line("step of the plant node", one, f"{100 * one / DT:.1f} % of a sample"),
    ]


def starting() -> list[Line]:
    """A fresh process with an empty and with a filled cache."""
    with tempfile.TemporaryDirectory() as folder:
        environment = {**os.environ, "ER_CACHE_DIR": folder}
        times = []
        for code in (_START, _START, "import er_models.predict"):
            start = time.perf_counter()
            subprocess.run([sys.executable, "-c", code], env=environment, check=True)
            times.append(time.perf_counter() - start)
    return [
        Line("first process: import, compile, predict", times[0]),
        Line(
            "later process: import, load, predict",
            times[1],
            f"{times[1] - times[2]:.2f} s more than the import",
        ),
    ]


def table(lines: list[Line]) -> str:
    """Lines as a Markdown table."""
    rows = ["| what | time | remark |", "|---|---|---|"]
    return (
        "\n".join([*rows, *(f"| {x.what} | {_time(x.seconds)} | {x.remark} |" for x in lines)])
        + "\n"
    )


def _time(seconds: float) -> str:
    """A time with its unit."""
    units = (("s", 1.0), ("ms", 1e-3), ("us", 1e-6))
    unit, size = next((u for u in units if seconds >= u[1]), units[-1])
    return f"{seconds / size:.3g} {unit}"


def main() -> None:
    """Print all tables."""
    parts = {
        "Prediction": prediction,
        "Quarter car": vehicle,
        "Starting": starting,
        "Cost of effects": effects,
    }
    for title, measure in parts.items():
        sys.stdout.write(f"## {title}\n\n{table(measure())}\n")
        sys.stdout.flush()


if __name__ == "__main__":
    main()
