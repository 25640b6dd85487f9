"""``./er study figures``: the frequency responses of chapters 3 to 5 for our observers, and their peaks."""

from __future__ import annotations

import csv
import io
from pathlib import Path
from typing import Annotated

import typer
from er_models.errors import InputError
from er_models.files import load_model, write_whole
from er_observers.gains import Gains, load_gains
from er_observers.synthesis.make import THEOREMS
from rich.console import Console
from rich.table import Table

from er_studies.observers.frequency.figures import FIGURES, Peak, peaks, responses
from er_studies.observers.frequency.responses import HERTZ, outputs
from er_studies.programs import program_of, run

FORMATS = ("svg", "png")


def figures_command(
    out: Annotated[Path, typer.Option(help="Folder for pictures and numbers.")],
    config: Annotated[Path, typer.Option(help="Folder with vehicles and gains.")] = Path("config"),
    kind: Annotated[str, typer.Option("--format", help=f"One of {', '.join(FORMATS)}.")] = "svg",
) -> None:
    """Figures 3.1-3.2, 4.1-4.8 and 5.1-5.4 for our observers: pictures, responses, peaks."""
    from er_studies.observers.frequency.report.draw import draw

    if kind not in FORMATS:
        raise InputError("arguments", "format", f"one of {', '.join(FORMATS)}", kind)
    gains = _gains(config)
    out.mkdir(parents=True, exist_ok=True)
    found: list[Peak] = []
    for figure in FIGURES:
        rows = responses(figure, gains)
        names = outputs(gains[figure.observers[0]].claim)
        draw(out / f"figure_{figure.number.replace('.', '_')}.{kind}", figure, rows, names)
        head = [f"{r.observer} duty {r.duty:g} {e}" for r in rows for e in (*names, "sigma")]
        columns = [c for r in rows for c in (*r.gains.T, r.sigma)]
        lines = zip(HERTZ, *columns, strict=True)
        _write(out / f"figure_{figure.number.replace('.', '_')}.csv", ["hertz", *head], lines)
        found += peaks(figure, gains)
    _write(out / "peaks.csv", list(Peak._fields), found)
    Console().print(_table(found))
    Console().print(f"wrote {len(FIGURES)} figures, their responses and peaks.csv to {out}")


def _gains(config: Path) -> dict[str, Gains]:
    """The committed gains of every observer."""
    model = load_model(config / "vehicles" / "inove_quarter_car.yaml")
    return {name: load_gains(config / "gains" / f"{name}.yaml", model, name) for name in THEOREMS}


def _write(path: Path, head: list[str], rows: object) -> None:
    """A CSV file, whole or not at all."""
    text = io.StringIO()
    writer = csv.writer(text, lineterminator="\n")
    writer.writerow(head)
    for row in rows:  # type: ignore[attr-defined]
        writer.writerow([f"{v:.6g}" if isinstance(v, float) else v for v in row])
    write_whole(path, text.getvalue())


def _table(found: list[Peak]) -> Table:
    """Worst duty of each figure and observer, for the force and for all states."""
    worst: dict[tuple[str, str, str], Peak] = {}
    for p in found:
        key = (p.figure, p.observer, p.error)
        if p.error not in ("force", "all states"):
            continue
        if key not in worst or p.gain > worst[key].gain:
            worst[key] = p
    table = Table(title="largest gain over frequency and duty")
    for name in ("figure", "observer", "error", "gain [SI]", "at [Hz]", "duty"):
        table.add_column(name, justify="left" if name in ("observer", "error") else "right")
    for p in worst.values():
        table.add_row(
            p.figure, p.observer, p.error, f"{p.gain:.3g}", f"{p.hertz:.3g}", f"{p.duty:g}"
        )
    return table


app = program_of(figures_command)

if __name__ == "__main__":
    run(app)
