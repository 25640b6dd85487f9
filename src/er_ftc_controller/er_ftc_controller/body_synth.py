"""Command line of the body controller's synthesis: ``./er synth body_lqr --car CAR --weights WEIGHTS --out GAIN``."""

from __future__ import annotations

import sys
from pathlib import Path
from typing import Annotated

import typer
from er_common.usage import OneLineCommand
from er_models.car.files import load_car
from er_models.errors import ErError
from er_models.places import writable
from rich.console import Console

from er_ftc_controller.body_gains import load_weights, save_body_gain, slowest
from er_ftc_controller.synthesis.body_lqr import body_gain

app = typer.Typer(add_completion=False, pretty_exceptions_enable=False)


@app.command(cls=OneLineCommand)
def body_lqr(
    car: Annotated[Path, typer.Option(help="Car file.")],
    weights: Annotated[Path, typer.Option(help="File of weights: sizes that count as one.")],
    out: Annotated[Path, typer.Option(help="Gain file to write.")],
) -> None:
    """Compute the gain of the body controller for a whole car, check it, write it."""
    writable({"--out": out}, None, {"--car": (car,), "--weights": (weights,)})
    whole, chosen = load_car(car), load_weights(weights)
    gain = body_gain(whole, chosen)
    save_body_gain(out, whole, chosen, gain)
    Console().print(f"slowest pole of the loop without limits: {slowest(whole, gain):.3g} 1/s")
    Console().print(f"wrote {out}", soft_wrap=True)


def main(arguments: list[str] | None = None) -> None:
    """Run the command line; an error of the user is one line."""
    try:
        app(arguments, prog_name="er synth body_lqr")
    except ErError as error:
        print(f"er synth: {error}", file=sys.stderr)  # noqa: T201
        sys.exit(error.exit_status)


if __name__ == "__main__":
    main()
