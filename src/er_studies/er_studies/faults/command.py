"""`./er study fault_trials`: the acceptance of the fault estimator, and its rivals."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from er_models.constants import SAMPLE_TIME as DT
from er_models.files import load_model
from er_models.model import Model
from er_observers.faults.ready import ready
from er_observers.faults.rules import Estimator
from er_observers.faults.sample import Kind
from rich.console import Console
from rich.progress import track

from er_studies.faults.acceptance import (
    EXCITED,
    LIMITS,
    NAMED,
    Outcome,
    Quiet,
    faultless,
    faulty,
    healthy_trials,
    hidden_trials,
    kinds,
)
from er_studies.faults.rivals import factors
from er_studies.faults.synthesis.lost_force import design, solve
from er_studies.faults.trials import Trial, drive, faults
from er_studies.given_out import Json, Table, give, seconds
from er_studies.programs import program_of, run

_HEAD = (
    "fault", "within limit", "once excited", "best, told", "not told", "named rightly", "at best", "named wrongly",
    "kind open", "median s to name", "early", "unexplained",
)  # fmt: skip
RIVALS = ("ours", "horizon", "forgetting", "adaptive", "descriptor")


def fault_trials_command(
    model: Annotated[Path, typer.Option(help="Vehicle model file.")] = Path(
        "config/vehicles/inove_quarter_car.yaml"
    ),
    number: Annotated[int, typer.Option(min=1, help="Drives of each kind of fault.")] = 50,
    seed: Annotated[int, typer.Option(min=0, help="Seed of all drives.")] = 1,
    spread: Annotated[
        float,
        typer.Option(min=0.0, max=0.2, help="Share by which parameters of faulty cars are off."),
    ] = 0.0,
    rivals: Annotated[bool, typer.Option(help="Compare with other estimators instead.")] = False,
    json_file: Json = None,
) -> None:
    """Try the fault estimator on random closed-loop drives: faults, none, and effects that are no faults."""
    car = load_model(model)
    p = ready(car)
    if rivals:
        give([_rival_table(p, car, seed, number)], json_file)
        return
    made = (
        _fault_table(p, car, seed, number, spread),
        _quiet_table(p, car, seed, number),
        _hidden_table(p, car, seed, max(1, number // 10)),
    )
    give(made, json_file)


def _shown(jobs: list[Any]) -> Iterator[Any]:
    """The jobs, with progress on a terminal."""
    console = Console(stderr=True)
    yield from track(jobs, console=console, disable=not console.is_terminal)


def _fault_table(p: Estimator, car: Model, seed: int, number: int, spread: float) -> Table:
    rows = []
    for name in kinds():
        drives = _shown(list(faults(name, seed, number, spread)))
        rows.append([name, *_row(name, [faulty(p, trial, car) for trial in drives])])
    return Table(
        _HEAD, rows, f"{number} drives each, seed {seed}, parameters within {100.0 * spread:g} %"
    )


def _row(name: str, found: Sequence[Outcome]) -> list[str]:
    """Counts of one kind of fault, and what the best estimator could be expected to reach."""
    right = NAMED.get(name, Kind.COMBINED)
    good = [all(abs(e) <= LIMITS[f][0] for f, e in o.errors.items()) for o in found]
    excited = [g for g, o in zip(good, found, strict=True) if o.could[1] >= EXCITED]
    told, not_told, nameable = (
        f"{100.0 * np.mean(each):.0f} %" for each in zip(*(o.could for o in found), strict=True)
    )
    return [
        f"{sum(good)}/{len(found)}", f"{sum(excited)}/{len(excited)}", told, not_told,
        f"{sum(o.kind is right for o in found)}/{len(found)}", nameable,
        str(sum(o.wrong for o in found)), str(sum(o.kind is Kind.SOME for o in found)),
        seconds([o.named for o in found]), str(sum(o.early for o in found)),
        str(sum(o.unexplained for o in found)),
    ]  # fmt: skip


def _quiet_table(p: Estimator, car: Model, seed: int, number: int) -> Table:
    """Drives without a fault: with other parameters, and where nothing shows one."""
    found = [faultless(p, trial, car) for trial in _shown(list(healthy_trials(seed, 2 * number)))]
    alarms, doubts = sum(bool(q.named) for q in found), sum(q.unexplained for q in found)
    said = f"{alarms} of {len(found)} with a fault, {doubts} unexplained"
    rows = [("healthy, parameters within 5 %", said)]
    for name, trial in (
        ("standstill", Trial(seed, still=True, duration=4.0)),
        ("duty zero", Trial(seed * 1000 + 4, duty=0.0, duration=4.0, road="iso8608")),
    ):
        lost = faultless(p, trial, car).unexcited
        silent = [f for f, gone in zip(LIMITS, lost, strict=True) if gone]
        rows.append((name, f"not excited: {', '.join(silent) or 'none'}"))
    return Table(("no fault", "said"), rows)


def _hidden_table(p: Estimator, car: Model, seed: int, number: int) -> Table:
    """Effects that are no faults: how many are called one, and how many in silence."""
    found: dict[str, list[Quiet]] = {}
    for name, trial in _shown(list(hidden_trials(car, seed, number))):
        found.setdefault(name, []).append(faultless(p, trial, car, name))
    rows = []
    for name, each in found.items():
        said = sorted({k.lower() for q in each for k in q.silent})
        doubts, named, silent = (
            sum(bool(x) for x in column)
            for column in zip(*((q.unexplained, q.named, q.silent) for q in each), strict=True)
        )
        if doubts or named:
            words = f"{silent} ({', '.join(said)})" if silent else "0"
            rows.append([name, str(doubts), str(named), words])
    title = f"{number} drives of each of {len(found)} hidden effects, of which those below were noticed"
    return Table(("effect", "unexplained", "fault named", "in silence"), rows, title)


def _rival_table(p: Estimator, car: Model, seed: int, number: int) -> Table:
    """Median and 90th percentile of the error of the faulty factor, and of the others, 2 s and 5 s after the fault."""
    problem = design(car, p.noise[:3], car.rig.get("duty_max", car.scales.duty))
    K = solve(problem).K
    lines = []
    for name in LIMITS:
        records = [(t, drive(t, car)) for t in faults(name, seed, number)]
        for rival in RIVALS:
            rows = [_errors(t, factors(p, d.samples, rival, K), name) for t, d in _shown(records)]
            lines.append([name, rival, *(_spread(column) for column in zip(*rows, strict=True))])
    head = ("fault", "estimator", "after 2 s", "after 5 s", "others, 5 s")
    return Table(head, lines, f"{number} drives each, seed {seed}: median / 90 % error")


def _errors(trial: Trial, found: Any, name: str) -> tuple[float, float, float]:
    at = [min(round((trial.fault_time + s) / DT), len(found) - 1) for s in (2.0, 5.0)]
    own = int(name[1]) - 1
    errors = [abs(float(found[k][own]) - trial.left[name]) for k in at]
    rest = max(abs(float(found[at[1]][i]) - 1.0) for i in range(3) if i != own)
    return errors[0], errors[1], rest


def _spread(values: Sequence[float]) -> str:
    return f"{np.median(values):.3f} / {np.quantile(values, 0.9):.3f}"


app = program_of(fault_trials_command)

if __name__ == "__main__":
    run(app)
