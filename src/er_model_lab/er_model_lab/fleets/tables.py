"""The tables of a fleet as Parquet: one row a unit, one a recording; units of every column in the schema.

A field's metadata hold `unit`, its SI unit (1: a number, empty: no number), and `meaning`.
"""

from __future__ import annotations

from collections.abc import Iterable, Mapping
from itertools import islice
from pathlib import Path
from typing import Any

import pyarrow as pa
import pyarrow.parquet as pq
from er_models.errors import InputError
from er_models.model import Model
from er_records.write import finished_only

GROUP = 20_000
"""Rows that are held and written together."""
VALUE = pa.list_(
    pa.struct(
        [
            ("name", pa.string()),
            ("value", pa.float64()),
            ("sd", pa.float64()),
            ("unit", pa.string()),
        ]
    )
)
NAMES = pa.list_(pa.string())
CHANGES = pa.list_(
    pa.struct([
        ("quantity", pa.string()), ("axis", pa.string()), ("form", pa.string()), ("at", pa.float64()),
        ("low", pa.float64()), ("high", pa.float64()), ("change", pa.float64()), ("sd", pa.float64()),
        ("p", pa.float64()),
    ])
)  # fmt: skip
Column = tuple[str, pa.DataType, str, str]
"""Name, type, SI unit, meaning."""

UNITS: tuple[Column, ...] = (
    ("unit", pa.string(), "", "the unit"),
    ("verdict", pa.string(), "", "as of diagnose; refitted: no search was asked for; failed: see error"),
    ("effects", NAMES, "", "what should be added to the model, most important first"),
    ("alternatives", pa.list_(NAMES), "", "groups that the data cannot tell apart"),
    ("rmse", pa.float64(), "N", "error of the refitted model on data held out"),
    ("rmse_after", pa.float64(), "N", "the same with the effects"),
    ("nrmse", pa.float64(), "1", "rmse over the range of the force"),
    ("rmse_as_given", pa.float64(), "N", "error of the model as given"),
    ("noise_floor", pa.float64(), "N", "what no model could explain"),
    ("explainable", pa.float64(), "1", "share of the squared error that some model could explain"),
    ("recordings", pa.int64(), "1", "recordings that are used"),
    ("left_out", pa.int64(), "1", "recordings that are not: see the other table"),
    ("diagnosed_with", pa.int64(), "1", "recordings that the diagnosis took"),
    ("seconds", pa.float64(), "s", "length of the used recordings"),
    ("first_time", pa.float64(), "s", "of the first recording"), ("last_time", pa.float64(), "s", "of the last one"),
    ("first_mileage", pa.float64(), "m", "of the first recording"),
    ("last_mileage", pa.float64(), "m", "of the last one"),
    ("p", pa.float64(), "1", "probability that a unit differs as much by chance"),
    ("differs", pa.bool_(), "", "whether it differs, at a false discovery rate of 5 %"),
    ("differs_in", NAMES, "", "in what, the least probable first"),
    ("changes", CHANGES, "", "what changes along mileage [m] or time [s], or falls into two groups"),
    ("next", NAMES, "", "what to record next"),
    ("values", VALUE, "", "every parameter of the best model"),
    ("notes", NAMES, "", "what to know of the data"), ("error", pa.string(), "", "why there is no diagnosis"),
)  # fmt: skip
RECORDINGS: tuple[Column, ...] = (
    ("unit", pa.string(), "", "the unit"), ("path", pa.string(), "", "where it lies"),
    ("record", pa.string(), "", "which record of it"),
    ("status", pa.string(), "", "used, not_usable, unreadable, copy or failed"),
    ("error", pa.string(), "", "why it is not used"),
    ("time", pa.float64(), "s", "when it was made"), ("mileage", pa.float64(), "m", "of the unit then"),
    ("seconds", pa.float64(), "s", "length"), ("samples", pa.int64(), "1", "number"),
    ("rate", pa.float64(), "Hz", "of sampling"),
    ("complete", pa.bool_(), "", "whether nothing was lost"),
    ("rmse", pa.float64(), "N", "error of the model as given"),
    ("nrmse", pa.float64(), "1", "over the range of the force"),
    ("rmse_refitted", pa.float64(), "N", "error of the model refitted to this recording alone"),
    ("deflection", pa.float64(), "m", "reach"), ("velocity", pa.float64(), "m/s", "reach"),
    ("duty", pa.float64(), "1", "reach"),
    ("damper", pa.int64(), "1", "1 or 2 where the unit's recordings show two dampers"),
    ("digest", pa.string(), "", "SHA-256 of the samples"), ("notes", NAMES, "", "what was repaired or derived"),
)  # fmt: skip


def parameters_of(model: Model) -> dict[str, str]:
    """Parameters of the model as `effect.name`, with their SI units."""
    return {f"{e}.{q.name}": q.unit for e in model.effects for q in model.catalogue[e].parameters}


def unit_columns(model: Model) -> tuple[Column, ...]:
    """Columns of the units: beside the fixed ones each parameter of the model, its own and partially pooled."""
    said = (
        ("", "of its own data"),
        ("_sd", "deviation"),
        ("_pooled", "with what the fleet lends"),
        ("_pooled_sd", "deviation"),
    )
    return UNITS + tuple(
        (name + end, pa.float64(), unit, what) for name, unit in parameters_of(model).items() for end, what in said
    )  # fmt: skip


def recording_columns(model: Model, more: Iterable[str]) -> tuple[Column, ...]:
    """Columns of the recordings; more: those of the user's table that nothing here has a name for."""
    values = tuple(
        (name + end, pa.float64(), unit, what)
        for name, unit in parameters_of(model).items()
        for end, what in (("", "refitted to this recording alone"), ("_sd", "deviation"))
    )
    taken = {name for name, *_ in (*RECORDINGS, *values)}
    return (
        RECORDINGS
        + values
        + tuple((m, pa.string(), "", "of the table") for m in more if m not in taken)
    )


def write(
    columns: tuple[Column, ...],
    rows: Iterable[Mapping[str, Any]],
    path: Path,
    about: Mapping[str, str],
) -> None:
    """Write rows as Parquet, whole or not at all; about: metadata of the table.

    Raises:
        InputError: The place cannot be written.
    """
    fields = [
        pa.field(n, kind, metadata={"unit": unit, "meaning": what})
        for n, kind, unit, what in columns
    ]
    schema = pa.schema(fields, metadata={f"er_fleet.{k}": v for k, v in about.items()})
    names, left = [name for name, *_ in columns], iter(rows)
    try:
        with (
            finished_only(path) as part,
            pq.ParquetWriter(part, schema, compression="zstd") as writer,
        ):
            while together := list(islice(left, GROUP)):
                held = [{name: row.get(name) for name in names} for row in together]
                writer.write_table(pa.Table.from_pylist(held, schema))
    except OSError as error:
        raise InputError(
            path, "--out", "a place that can be written", error.strerror or str(error)
        ) from None
