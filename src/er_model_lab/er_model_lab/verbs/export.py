"""Take a model, or what it makes of data, to other programs."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
from er_models.errors import InputError
from er_models.export.c_code import write_c
from er_models.export.fmu import here, write_fmu
from er_models.export.force_table import force_table, without_sensors
from er_models.model import Array, Model
from er_models.prediction import predict
from er_records.dataset import Dataset
from er_records.load import fingerprint
from er_records.write_table import Columns, write_table, writer_of

from er_model_lab.blas import on_one_thread
from er_model_lab.level.damper import DamperLevel, opened
from er_model_lab.level.study import Opened
from er_model_lab.preflight.check import admitted

UNITS = {
    "t": "s", "deflection": "m", "deflection_velocity": "m/s", "deflection_acceleration": "m/s2", "duty": "1",
    "temperature": "K", "damper_force": "N",
}  # fmt: skip
"""What a series holds beside forces of the model, and their units."""


@dataclass(frozen=True)
class ExportResult:
    """What was written.

    files: in the order in which they were written; content: what they hold, as plain data; notes: what to know of it.
    """

    model: str
    files: tuple[Path, ...]
    content: dict[str, Any]
    notes: tuple[str, ...] = ()

    @property
    def complete(self) -> bool:
        """Whether the data were complete."""
        return bool(self.content.get("complete", True))

    def to_dict(self) -> dict[str, Any]:
        """Everything as plain data, as `--json` writes it."""
        return {
            "command": "export", "model": self.model, "files": [str(f) for f in self.files], **self.content,
            "notes": list(self.notes),
        }  # fmt: skip


@on_one_thread
def export(
    model: Model, data: Dataset | None = None, *, series: str | Path | None = None, lut: str | Path | None = None,
    c: str | Path | None = None, fmu: str | Path | None = None, fmi: int = 3, sensors: bool = True,
    anyway: bool = False,
) -> ExportResult:  # fmt: skip
    """Write a model for other programs, and what it makes of data.

    series: .csv, .parquet, .mat or .mf4, one file a record: time, inputs, measured and predicted force, residual, and
    the share of each effect, which is by how much the force differs when that effect alone is switched off; lut: .csv,
    force over velocity and duty (`er_models.export.force_table`); c: folder for C code; fmu: .fmu, a unit for
    co-simulation (`er_models.export.fmu`) by version 2 or 3 of FMI; sensors: whether both hold what the sensors do to
    motion and force; anyway: data that fail the preflight are used all the same.

    Raises:
        InputError: nothing to write, a suffix that there is no writer for, data that fail the preflight.
        MissingChannel: a series of data without force or motion.
        ErError: an effect that has no form in C.
    """
    work: list[Callable[[], ExportResult]] = []
    if series is not None:
        if data is None:
            raise InputError("data", "", "measurements for a series", "none")
        known, out = data, Path(series)
        writer_of(out)
        work.append(lambda: _series(known, model, out, anyway=anyway))
    if lut is not None:
        table = Path(lut)
        if table.suffix.lower() != ".csv":
            raise InputError(table, "suffix", ".csv", f"'{table.suffix}'")
        work.append(lambda: _table(model, table))
    carried = model if sensors else without_sensors(model)
    if c is not None:
        folder = Path(c)
        work.append(lambda: ExportResult(model.name, write_c(carried, folder), {"c": str(folder)}))
    if fmu is not None:
        unit = Path(fmu)
        work.append(lambda: _unit(carried, unit, fmi))
    if not work:
        raise InputError("export", "", "something to write: series, lut, c or fmu", "nothing")
    return _together(model.name, [each() for each in work])


def _together(name: str, parts: list[ExportResult]) -> ExportResult:
    """All that was written as one result."""
    content = {key: value for part in parts for key, value in part.content.items()}
    files = tuple(path for part in parts for path in part.files)
    return ExportResult(name, files, content, tuple(note for part in parts for note in part.notes))


def _table(model: Model, out: Path) -> ExportResult:
    """Write force over velocity and duty."""
    table = force_table(model)
    columns = {"velocity": (table.velocity, "m/s")}
    columns |= {
        f"force at duty {u:.4g}": (table.force[:, i], "N") for i, u in enumerate(table.duty)
    }
    write_table(columns, out)
    content = {
        "file": str(out), "velocity": table.velocity.tolist(), "duty": table.duty.tolist(),
        "force": table.force.tolist(), "amplitude": table.amplitude,
    }  # fmt: skip
    return ExportResult(model.name, (out,), {"lut": content})


def _unit(model: Model, out: Path, fmi: int) -> ExportResult:
    """Write a unit for co-simulation."""
    runs = write_fmu(model, out, fmi)
    content = {"file": str(out), "fmi": fmi, "library": here() if runs else None}
    note = "without a C compiler (cc, gcc or clang) the FMU holds sources only: compile them before it runs"
    return ExportResult(model.name, (out,), {"fmu": content}, () if runs else (note,))


def _series(data: Dataset, model: Model, out: Path, *, anyway: bool) -> ExportResult:
    """Write one file a record."""
    _, records = admitted(data.records, model, model.catalogue, anyway=anyway)
    whole = opened(DamperLevel().usable(data.with_records(records)), model)
    names = whole.problem.names
    files = [out if len(names) == 1 else _beside(out, name) for name in names]
    read = {Path(r.file).resolve() for r in data.originals if r.file}
    for path in files:
        if path.resolve() in read:
            raise InputError(path, "series", "another place than the data", "a file that is read")
    told = []
    for path, name, columns in zip(files, names, _tables(whole), strict=True):
        write_table(columns, path)
        told.append(
            {"record": name, "file": str(path), "rows": columns["t"][0].size, **_sizes(columns)}
        )
    content = {
        "series": told,
        "data": fingerprint(data.originals),
        "complete": whole.problem.complete,
    }
    return ExportResult(model.name, tuple(files), content, whole.problem.notes)


def _beside(out: Path, record: str) -> Path:
    """The file of one of several records."""
    safe = "".join(c if c.isalnum() or c in "-_." else "_" for c in record)
    return out.with_name(f"{out.stem}_{safe}{out.suffix}")


def _tables(found: Opened) -> Iterator[Columns]:
    """Columns of each record."""
    problem, model = found.problem, found.searched
    m, predicted = problem.motion, problem.force - found.given
    forces = {
        "damper_force": problem.force, "force_predicted": predicted, "force_residual": found.given,
        **shares(model, found),
    }  # fmt: skip
    inputs = {
        "deflection": m.x,
        "deflection_velocity": m.v,
        "deflection_acceleration": m.a,
        "duty": m.u,
    }
    inputs |= {"temperature": m.theta} if np.any(m.theta) else {}
    for record, (i, j) in zip(found.data.records, pairwise(m.starts.tolist()), strict=True):
        t = record.t if len(record) == j - i else record.t[0] + np.arange(j - i) * m.dt
        columns = {"t": t} | {name: y[i:j] for name, y in (inputs | forces).items()}
        yield {name: (y, UNITS.get(name, "N")) for name, y in columns.items()}


def shares(model: Model, found: Opened) -> dict[str, Array]:
    """By how much the force (n,) [N] along the motion differs when each effect of the damper is switched off.

    Both predictions begin in equilibrium with the first sample. Effects that act through one another share what they
    make together, so that the shares need not add up to the force.
    """
    motion = found.problem.motion
    whole = predict(model, motion)
    acting = [name for name in model.effects if model.catalogue[name].stage != "vehicle"]
    return {
        f"force_{name}": whole - predict(model.without_effect(name), motion) for name in acting
    }


def _sizes(columns: Columns) -> dict[str, Any]:
    """Root mean square of the residual, and of each share [N]."""
    y = {name: float(np.sqrt(np.mean(samples**2))) for name, (samples, _) in columns.items()}
    effects = {n.removeprefix("force_"): v for n, v in y.items() if n.startswith("force_")}
    return {
        "rmse": effects.pop("residual"),
        "shares": {k: v for k, v in effects.items() if k != "predicted"},
    }
