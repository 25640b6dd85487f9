"""``./er study variants``: every theorem in every form with its gamma or the reason why it has none."""

from __future__ import annotations

import math
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from er_models.constants import SAMPLE_TIME as DT
from er_models.files import load_model, write_json
from er_models.model import Array
from er_models.places import writable
from er_models.program import Program, times
from er_observers.synthesis.spec import Spec
from rich.console import Console
from rich.progress import track
from rich.table import Table

from er_studies.given_out import Json
from er_studies.observers.variants import Reached, rate_bounds, reach, variants
from er_studies.programs import program_of, run

_ROAD = {"kind": "sine", "amplitude": 1e-3, "frequency": 3.0}
DUTIES: dict[str, dict[str, object]] = {
    "sine 0.1 Hz": {"kind": "sine", "frequency": 0.1, "mean": 0.5, "amplitude": 0.5},
    "sine 2 Hz": {"kind": "sine", "frequency": 2.0, "mean": 0.5, "amplitude": 0.5},
    "switched at 4.3 Hz": {"kind": "square", "frequency": 4.3, "high": 1.0},
}
"""Duty signals whose rates are looked at."""


def variants_command(
    model: Annotated[Path, typer.Option(help="Vehicle model file.")],
    json_file: Json = None,
) -> None:
    """Every theorem in every form: its gamma, or why it has none; bounds of the duty's rate."""
    writable({"--json": json_file}, read={"--model": (model,)})
    car, spec = load_model(model), Spec()
    console = Console()
    steps = track(
        variants(spec),
        "forms",
        transient=True,
        console=console,
        disable=not console.is_terminal,
    )
    reached = [reach(car, variant) for variant in steps]
    rates = list(rate_bounds(car, spec, {n: _duty(d) for n, d in DUTIES.items()}, DT))
    console.print(_forms(reached))
    console.print(_rates(rates))
    if json_file is not None:
        content = {
            "variants": [{k: _plain(v) for k, v in row._asdict().items()} for row in reached],
            "rates": [dict(zip(_RATE_KEYS, row, strict=True)) for row in rates],
        }
        write_json(json_file, content)


_RATE_KEYS = ("duty", "rate", "gamma", "share")


def _duty(settings: dict[str, object]) -> Array:
    """Samples of a duty over 15 s."""
    _, duty = Program(_ROAD, settings, 15.0, 0).signals(times(15.0, DT))
    return np.asarray(duty)


def _forms(reached: list[Reached]) -> Table:
    """The variants for people."""
    table = Table(title="gamma of every form, proved; LFT: the gate as an uncertain slope")
    for name, side in (
        ("form", "left"),
        ("gamma", "right"),
        ("LFT", "right"),
        ("why not", "left"),
    ):
        table.add_column(name, justify=side)  # type: ignore[arg-type]
    for r in reached:
        table.add_row(r.title, _number(r.gamma), _number(r.slopes), r.reason)
    return table


def _rates(rates: list[tuple[str, float, float, float]]) -> Table:
    """The bounds of the duty's rate for people."""
    table = Table(title="gridding: bound of the duty's rate")
    for name in ("duty", "rate [1/s]", "gamma", "P_1 / P"):
        table.add_column(name, justify="left" if name == "duty" else "right")
    for duty, rate, gamma, share in rates:
        table.add_row(duty, f"{rate:.4g}", _number(gamma), f"{share:.3f}")
    return table


def _number(value: float) -> str:
    """Four digits, or a dash for none."""
    return "-" if math.isnan(value) else f"{value:.4f}"


def _plain(value: str | float) -> str | float | None:
    """NaN has no place in JSON."""
    return None if isinstance(value, float) and math.isnan(value) else value


app = program_of(variants_command)

if __name__ == "__main__":
    run(app)
