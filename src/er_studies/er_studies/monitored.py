"""`./er study monitor DATA --model MODEL`: the live monitor along measured runs of one damper.

The runs follow one another in orders drawn at random, and the monitor learns from the first minute of motion, as live.
The damper stays what it is: every alarm is in vain. Along the same runs the error of the model is then made larger from
the middle on.
"""

from __future__ import annotations

import math
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Annotated, NamedTuple

import numpy as np
import typer
from er_common.stamps import SECOND
from er_model_lab.monitor import compare
from er_model_lab.monitor.compare import Monitor, Row, State
from er_model_lab.monitor.sequential import RULES
from er_model_lab.monitor.watch import Finding
from er_model_lab.verbs.load import load, load_model
from er_models.errors import InputError
from er_models.model import Model
from er_records.record import Record

from er_studies.given_out import Json, Table, give
from er_studies.programs import program_of, run
from er_studies.progress import progress_of

HOLD = 0.05
"""Silence that is bridged [s]."""
PAUSE = 1.0
"""Between two runs [s]: the damper begins anew, as behind a silence."""
LEARNT = RULES.blocks * RULES.block
CHANNELS = (
    "sprung_acceleration", "unsprung_acceleration", "deflection", "deflection_velocity", "duty", "damper_force",
)  # fmt: skip


class Order(NamedTuple):
    """Runs one after the other.

    motion: judged behind the minute that was learnt from [s]; alarms: runs in which one began; found: motion until an
    error that grows by the rules' change is one [s], infinite where it is none.
    """

    motion: float
    alarms: tuple[str, ...]
    found: float


class _Seen(NamedTuple):
    """Motion judged at the end, and when the error began to grow [s]; alarms, each with the motion before it [s]."""

    motion: float
    grew: float
    alarms: tuple[tuple[float, str], ...]


def ordered(model: Model, records: Sequence[Record], seed: int) -> Order:
    """The monitor along records of one rate in an order drawn at random.

    Raises:
        InputError: No more motion can be judged than is learnt from.
    """
    drawn = [records[k] for k in np.random.default_rng(seed).permutation(len(records))]
    monitor = compare.monitor(model, drawn[0].dt, HOLD, RULES)
    quiet = _along(monitor, drawn, math.inf)
    if quiet.motion <= LEARNT:
        wanted = f"more than {LEARNT:g} s of motion, with its deflection and damper_force"
        raise InputError("data", "", wanted, f"{quiet.motion:g} s")
    grown = _along(monitor, drawn, 0.5 * sum(map(len, drawn)))
    found = next((at - grown.grew for at, _ in grown.alarms if at > grown.grew), math.inf)
    return Order(quiet.motion - LEARNT, tuple(name for _, name in quiet.alarms), found)


def _along(monitor: Monitor, records: Sequence[Record], grows: float) -> _Seen:
    """What the monitor says of records whose error grows from so many samples on."""
    state, grew, alarms = State(), math.inf, list[tuple[float, str]]()
    for k, (row, name) in enumerate(_rows(records)):
        before = state.watch
        after, answer = compare.step(monitor, state, row)
        if k >= grows:
            grew = min(grew, before.moved)
            more = row._replace(f=row.f + RULES.change * answer.error)
            after, _ = compare.step(monitor, state, more)
        state = after
        if state.watch.finding is Finding.FAILS is not before.finding:
            alarms.append((state.watch.moved, name))
    return _Seen(state.watch.moved, grew, tuple(alarms))


def _rows(records: Sequence[Record]) -> Iterator[tuple[Row, str]]:
    """The samples of all runs, with the name of theirs."""
    began = 0.0
    for record in records:
        columns = [_column(record, name) for name in CHANNELS]
        stamps = began + np.arange(len(record)) * record.dt
        ticks = np.rint(stamps * SECOND).astype(int).tolist()
        for stamp, *values in zip(ticks, *columns, strict=True):
            yield Row(stamp, *values), record.name
        began = float(stamps[-1]) + PAUSE


def _column(record: Record, name: str) -> list[float]:
    """A channel; where there is none a duty of zero, else nothing."""
    if record.has(name):
        known: list[float] = np.asarray(record.channels[name], float).tolist()
        return known
    missing: list[float] = np.full(len(record), 0.0 if name == "duty" else math.nan).tolist()
    return missing


def _told(seed: int, found: Order) -> list[str]:
    took = f"{found.found:.1f} s" if math.isfinite(found.found) else "never"
    where = ", ".join(found.alarms)
    return [str(seed), f"{found.motion:.0f} s", str(len(found.alarms)), where, took]


def monitor_command(
    data: Annotated[list[Path], typer.Argument(help="Measured runs of one damper.")],
    model: Annotated[Path, typer.Option("--model", help="Model file.")],
    orders: Annotated[int, typer.Option(min=1, help="Orders of the runs.")] = 4,
    seed: Annotated[int, typer.Option(min=0, help="Seed of the first order.")] = 1,
    json_file: Json = None,
) -> None:
    """The live monitor along measured runs: its alarms in vain, and how soon it finds an error that grows."""
    records, known = load(*data).records, load_model(model)
    rates = {round(1.0 / each.dt, 3) for each in records}
    if len(rates) > 1:
        raise InputError("data", "dt", "runs of one rate", f"{sorted(rates)} Hz")
    found = []
    with progress_of("orders") as told:
        for k in range(orders):
            found.append(_told(seed + k, ordered(known, records, seed + k)))
            if told:
                told(k + 1, orders)
    growth = f"growth by {RULES.change:.0%} is found after"
    give([Table(("order", "motion", "alarms", "in", growth), found)], json_file)


app = program_of(monitor_command)

if __name__ == "__main__":
    run(app)
