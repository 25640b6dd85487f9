"""What the page takes: from a slider to new curves, beside a running graph, and whether anything leaks.

    er bench page

Times are those of the thread that answers the browser. A slider: the model's prediction, the error, every figure, and
their JSON, 60 s and 10 min at 200 Hz. Live: each second 200 rows are heard and the figures are drawn as often as the
page draws them. A leak: 200 steps, half of them taken back, and ten memories of rows heard after one another. Where
there are Chromium or Chrome and playwright, what a user waits for in a browser. Exit status 1 where a target is missed.
"""

from __future__ import annotations

import gc
import json
import sys
import tempfile
import time
import tracemalloc
from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from er_model_lab.live.coverage import coverage
from er_model_lab.live.heard import Heard
from er_model_lab.live.join import COLUMNS, Row
from er_model_lab.page import live_plots, plots
from er_model_lab.session.desk import Desk
from er_model_lab.session.sight import look
from er_model_lab.session.steps import divided
from er_models.files import load_model
from er_models.model import Model
from er_models.one_line import OneLine
from er_models.shipped import file_of
from er_records.record import Record
from er_records.write import write_csv

from er_studies.bench import browser
from er_studies.bench.lab.data import record
from er_studies.bench.machine import machine
from er_studies.given_out import Table, markdown, say

FIGURES = (plots.force, plots.residual_map, plots.force_loops, plots.residual_spectrum)
LIVE = (
    (live_plots.error, 1.0), (live_plots.force, 2.0), (live_plots.residual_map, 0.5), (live_plots.loops, 1.0),
    (live_plots.spectrum, 0.5),
)  # fmt: skip
"""Figures of the live page, and how often a second each is drawn."""
TARGETS = {60.0: 100.0, 600.0: 400.0}
"""Slider to curves, p95 [ms], by length of the data [s]."""
COVERED = 0.5
"""How often a second the live page looks at what the drive shows."""
SHARE, LEAK = 15.0, 0.02
"""Most of a core beside a graph [%]; most that 200 steps may leave of what a session holds anyway."""
STEPS = 200


@dataclass(frozen=True)
class Found:
    """A figure, its target, and what it is of."""

    says: str
    value: float
    target: float
    unit: str


def desk_of(model: Model, data: Record, folder: Path) -> Desk:
    """A desk with the data opened."""
    desk = Desk(folder)
    desk.records = (data,)
    desk.session = desk.session.then(desk.now.started(model, model.name))
    desk.sight = look(divided(desk.records, ()), model)
    desk.take(desk.now)
    return desk


def drawn(*figures: plots.Json) -> int:
    """Bytes of figures as they go to a browser; Python's own JSON is slower than the page's."""
    return sum(len(json.dumps(f, default=np.ndarray.tolist)) for f in figures)


def slider(desk: Desk, times: int) -> float:
    """A parameter is dragged: p95 until everything is drawn [ms]."""
    low, high = desk.now.known.bounds("passive", "c0")
    took = np.empty(times)
    for k in range(times):
        began = time.thread_time()
        desk.take(desk.now.set("passive", "c0", low + (high - low) * (0.1 + 0.3 * k / times)))
        desk.errors()
        drawn(*(make(desk, plots.LIGHT) for make in FIGURES))
        took[k] = 1e3 * (time.thread_time() - began)
    return float(np.percentile(took[times // 10 :], 95.0))


def heard_from(data: Record) -> list[Row]:
    """Rows as a graph would say them."""
    names = COLUMNS[:6]
    each = [data.channels[name] for name in names]
    left = 0.2 * np.sin(np.arange(len(data)))
    more = [left, np.full(len(data), 0.2), np.full(len(data), 0.1), np.zeros(len(data))]
    return [tuple(map(float, row)) for row in np.column_stack([data.t, *each, *more])]


def live_acts(heard: Heard, model: Model) -> list[tuple[str, Callable[[], object], float]]:
    """What the live page does with what was heard: its name, the act, and how often a second."""

    def draw(make: Callable[[Heard, plots.Theme], plots.Json]) -> Callable[[], int]:
        return lambda: drawn(make(heard, plots.LIGHT))

    figures = [(make.__name__.replace("_", " "), draw(make), often) for make, often in LIVE]
    return [*figures, ("what the drive shows", lambda: coverage(heard.channels(), model), COVERED)]


def live(model: Model, data: Record) -> float:
    """Share of a core that a full memory, words and figures take [%]."""
    heard, rows = Heard(), heard_from(data)
    heard.add(rows)
    since, seconds, acts = rows[-1][0] + 0.005, 10, live_acts(heard, model)
    began = time.thread_time()
    for k in range(seconds):
        for part in np.array_split(np.arange(200), 4):
            said = json.dumps([(since + k + 0.005 * int(i), *rows[int(i)][1:]) for i in part])
            heard.add([tuple(row) for row in json.loads(said)])
        for _, act, often in acts:
            for _ in range(round(often * (k + 1)) - round(often * k)):
                act()
    return 100.0 * (time.thread_time() - began) / seconds


def grown(act: Callable[[], None]) -> tuple[float, float]:
    """Memory that is held before, and that an act leaves behind the second time [MB]."""
    act()
    gc.collect()
    before = tracemalloc.get_traced_memory()[0]
    act()
    gc.collect()
    return 1e-6 * before, 1e-6 * (tracemalloc.get_traced_memory()[0] - before)


def steps(desk: Desk) -> None:
    """Effects are switched off and on, values are set, every other step is taken back; everything is drawn."""
    for k in range(STEPS):
        if k % 4 == 0:
            desk.take(desk.now.set("passive", "c0", 50.0 + 0.1 * (k % 50)))
        elif k % 4 == 1:
            desk.take(desk.now.switched("response", on="response" not in desk.now.known.effects))
        else:
            desk.undo()
        drawn(*(make(desk, plots.LIGHT) for make in FIGURES))


def measured(model: Model) -> list[Found]:
    """Every figure."""
    found = []
    with tempfile.TemporaryDirectory() as folder:
        for seconds, target in TARGETS.items():
            desk = desk_of(model, record(model, seconds), Path(folder))
            p95 = slider(desk, 60 if seconds < 100.0 else 20)
            found.append(Found(f"slider to curves, {seconds:g} s of data, p95", p95, target, "ms"))
        minutes = record(model, 300.0)
        found.append(
            Found("beside a graph, words and figures", live(model, minutes), SHARE, "% of a core")
        )
        desk = desk_of(model, record(model, 20.0), Path(folder))
        tracemalloc.start()
        desk = desk_of(model, record(model, 20.0), Path(folder))
        held, left = grown(lambda: steps(desk))
        found.append(
            Found(f"{STEPS} steps, of {held:.1f} MB held", left, max(LEAK * held, 0.2), "MB")
        )
        heard, rows = Heard(1.0), heard_from(record(model, 60.0))

        def hear() -> None:
            for _ in range(10):
                heard.add(rows)

        held, left = grown(hear)
        found.append(Found("ten memories heard", left, max(LEAK * held, 0.2), "MB"))
        tracemalloc.stop()
    return found


def live_figures(model: Model, data: Record, times: int = 20) -> list[list[str]]:
    """What each figure of the live page takes, and how often it is drawn: rows of a table."""
    heard = Heard()
    heard.add(heard_from(data))
    rows = []
    for says, act, often in live_acts(heard, model):
        act()
        began = time.thread_time()
        for _ in range(times):
            act()
        each = 1e3 * (time.thread_time() - began) / times
        rows.append([says, f"{each:.3g} ms", f"{often:g}"])
    return rows


def waited(model: Path) -> tuple[dict[str, float], float] | None:
    """What a user waits for in a browser [s], and a yardstick taken before and behind [s]; None without one."""
    if not browser.found():
        return None
    with tempfile.TemporaryDirectory() as folder:
        data = Path(folder) / "data.csv"
        write_csv(record(load_model(model), 60.0), data)
        before = browser.yardstick()
        took = browser.waits(data, model)
        return took, 0.5 * (before + browser.yardstick())


def seen(took: dict[str, float], unit: float) -> Table:
    """Waits of a user [s], and in times of the yardstick, unit [s]."""
    rows = [
        [says, f"{s:.3g} s", f"{s / unit:.2g}", f"{browser.TARGETS[says]:g}"]
        for says, s in took.items()
    ]
    rows.append(["the yardstick", f"{unit:.2g} s", "1", ""])
    return Table(["seen in a browser", "time", "of the yardstick", "target"], rows)


def main() -> None:
    """Entry point of the command."""
    OneLine(prog="er bench page", description=(__doc__ or "").split("\n")[0]).parse_args()
    file = file_of("inove_guo", "dampers")
    model = load_model(file)
    found = measured(model)
    rows = [[f.says, f"{f.value:.3g} {f.unit}", f"{f.target:.3g} {f.unit}"] for f in found]
    figures = live_figures(model, record(model, 300.0))
    tables = [
        Table(["work of the page", "found", "target"], rows),
        Table(["a figure of the live page", "time", "drawn a second"], figures),
        machine(),
    ]
    missed = any(f.value > f.target for f in found)
    if waits := waited(file):
        tables.append(seen(*waits))
        took, unit = waits
        missed |= any(s / unit > browser.TARGETS[says] for says, s in took.items())
    say("\n".join(map(markdown, tables)))
    sys.exit(1 if missed else 0)


if __name__ == "__main__":
    main()
