"""Commands without data of their own: plan, and the catalogue of effects."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING, Annotated

import typer
from er_models.errors import ErError

from er_model_lab.cli.options import (
    Anyway,
    EffectsFrom,
    Json,
    Level,
    ModelFile,
    Report,
    Seed,
    seed_option,
)
from er_model_lab.cli.places import writable
from er_model_lab.cli.running import (
    console,
    damper_only,
    fail,
    known_level,
    loaded,
    progress,
    read_by,
    run,
    write_json,
)

if TYPE_CHECKING:
    from er_model_lab.results.result import Result


def plan_command(
    model: ModelFile,
    between: Annotated[
        tuple[str, str] | None, typer.Option(help="Two effects to tell apart.")
    ] = None,
    reveal: Annotated[
        str | None, typer.Option(help="One effect to tell from its absence.")
    ] = None,
    data: Annotated[
        list[Path] | None,
        typer.Option(
            "--data",
            metavar="PATH",
            help="What is already measured; effects as fitted to it. Repeatable.",
        ),
    ] = None,
    out: Annotated[Path | None, typer.Option("--out", help="Program file to write.")] = None,
    vehicle: Annotated[
        Path | None, typer.Option(help="Vehicle file, where the model is a damper alone.")
    ] = None,
    stroke: Annotated[
        float | None, typer.Option(help="Largest |deflection| [m]; else the model's rig.")
    ] = None,
    velocity: Annotated[
        float | None,
        typer.Option(help="Largest |deflection velocity| [m/s]; else the model's rig."),
    ] = None,
    duty_max: Annotated[
        float | None, typer.Option(help="Largest duty; else the model's rig.")
    ] = None,
    duration: Annotated[
        float | None, typer.Option(help="Length of the program [s]; else 30.")
    ] = None,
    json_file: Json = None,
    report: Report = None,
    effects_from: EffectsFrom = None,
    level: Level = "damper",
    seed: Seed = 0,
    anyway: Anyway = False,
) -> None:
    """The road and duty that would tell two effects apart best, within the rig's limits."""

    def work() -> Result:
        damper_only(level, "plan")
        from er_model_lab.verbs.load import load_model
        from er_model_lab.verbs.plan import plan

        with progress("planning") as told:
            return plan(
                load_model(model, effects_from or ()), between=between or (), reveal=reveal, data=loaded(data),
                vehicle=load_model(vehicle, effects_from or ()) if vehicle else None,
                stroke=stroke, velocity=velocity, duty_max=duty_max, duration=duration,
                name=out.stem if out else "next",
                seed=seed, anyway=anyway, progress=told,
            )  # fmt: skip

    read = read_by(None, [model], effects_from)
    read |= {"--data": data or (), "--vehicle": [vehicle] if vehicle else ()}
    run(work, json_file, report, read=read, out=out)


def effects_command(
    effect: Annotated[str | None, typer.Argument(help="Show the card of this effect.")] = None,
    json_file: Json = None,
    report: Report = None,
    effects_from: EffectsFrom = None,
    level: Annotated[
        str, typer.Option(help="damper: without the effects of the car; vehicle: all.")
    ] = "vehicle",
    seed: Annotated[int, seed_option("As of the other commands; nothing here is random.")] = 0,
) -> None:
    """The catalogue of effects, or the card of one."""
    from er_models.own import effects

    from er_model_lab.cli.effects import card, shown, table

    try:
        known_level(level)
        writable({"--json": json_file}, report, read_by(None, (), effects_from))
        catalogue = effects(effects_from or ())
        wanted = shown(catalogue, level)
        result, text = card(effect, catalogue) if effect else table(wanted)
        result |= {"seed": seed}
        write_json(json_file, result)
        console().print(text, soft_wrap=bool(effect))
        if report:
            from er_model_lab.output.report.effects import write_cards

            cards = [catalogue[effect]] if effect else wanted
            page = write_cards(cards, catalogue, result, report)
            typer.echo(f"report: {page}")
    except ErError as error:
        fail(error)
