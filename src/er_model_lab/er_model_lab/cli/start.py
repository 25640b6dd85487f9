"""Commands that begin a model: new, models."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

import typer
from er_models.errors import ErError, InputError

from er_model_lab.cli.options import Anyway, Json
from er_model_lab.cli.places import writable
from er_model_lab.cli.running import console, fail, write_json


def new_command(
    name: Annotated[str, typer.Argument(help="Name of the new model.")],
    data: Annotated[
        list[Path],
        typer.Option("--from", metavar="DATA", help="Measurements it is scaled to. Repeatable."),
    ],
    out: Annotated[Path, typer.Option("--out", help="New model file.")],
    kind: Annotated[
        str, typer.Option("--kind", help="er, mr, passive or friction; `lab models` says more.")
    ],
    replaced: Annotated[
        bool, typer.Option("--replace", help="Write over a file that is there already.")
    ] = False,
    json_file: Json = None,
    anyway: Anyway = False,
) -> None:
    """A start model scaled to data, with its rig limits taken from them; a duty is not needed."""
    try:
        from er_models.files import save_model

        from er_model_lab.output.text.units import short
        from er_model_lab.verbs.load import load
        from er_model_lab.verbs.new import new

        writable({"--out": out, "--json": json_file}, None, {"DATA": data})
        if out.exists() and not replaced:
            raise InputError(out, "", "no file yet, or --replace", "one that is there already")
        loaded = load(*data)
        model = new(loaded, kind, name=name, anyway=anyway)
        save_model(model, out)
        s = model.scales
        result: dict[str, Any] = {
            "command": "new", "model": name, "kind": kind, "effects": list(model.effects), "rig": dict(model.rig),
            "envelope": {"force": s.force, "deflection": s.deflection, "velocity": s.velocity, "duty": s.duty},
            "values": {e: dict(v) for e, v in model.effects.items()}, "out": str(out),
            "notes": list(dict.fromkeys(n for r in loaded.records for n in r.notes)),
        }  # fmt: skip
        write_json(json_file, result)
    except ErError as error:
        fail(error)
    typer.echo(
        f"{name}: {', '.join(model.effects)}, for {short(s.force)} N, {1e3 * s.deflection:.3g} mm, {s.velocity:.3g} m/s"
    )
    typer.echo(f"rig: {', '.join(f'{k} {v:.4g}' for k, v in model.rig.items())}")
    typer.echo(f"new model: {out}")


def models_command(json_file: Json = None) -> None:
    """Kinds of start models, and the models that are shipped: `--model NAME` takes one."""
    from rich.table import Table

    from er_model_lab.output.text.units import short
    from er_model_lab.verbs.new import KINDS, models

    try:
        writable({"--json": json_file}, None, {})
        found = models()
        write_json(json_file, {
            "command": "models",
            "kinds": {k: {"effects": list(v.effects), "title": v.title} for k, v in KINDS.items()},
            "models": [
                {"name": m.name, "kind": m.kind, "force": m.model.scales.force, "deflection": m.model.scales.deflection,
                 "effects": list(m.model.effects), "source": m.model.source} for m in found
            ],
        })  # fmt: skip
    except ErError as error:
        fail(error)
    kinds = Table(
        "kind", "begins with", "is", box=None, title="lab new --kind", title_justify="left"
    )
    for kind, each in KINDS.items():
        kinds.add_row(kind, ", ".join(each.effects), each.title)
    table = Table(
        "model", "kind", "N", "mm", "source", box=None, title="shipped", title_justify="left"
    )
    for m in found:
        s = m.model.scales
        table.add_row(
            m.name,
            m.kind,
            short(s.force),
            f"{1e3 * s.deflection:.3g}",
            m.model.source.split(";")[0],
        )
    console().print(kinds, "", table)
