"""Command line of the synthesis.

``python -m er_observers.synth OBSERVER --model MODEL --out GAINS`` computes, proves and writes gains,
``all`` those of every observer; ``python -m er_observers.synth evaluate --model MODEL --gains GAINS``
shows what they are worth.
"""

from __future__ import annotations

import sys
import time
from pathlib import Path
from typing import Annotated, ClassVar

import typer
from er_common.usage import OneLineGroup
from er_models.errors import ErError
from er_models.files import load_model
from er_models.model import Model
from er_models.places import writable
from rich.console import Console

from er_observers.forms import COORDINATES
from er_observers.gains import observer_of, save_gains
from er_observers.running.evaluate import SCENARIOS, evaluate
from er_observers.running.ready import ready
from er_observers.synth_tables import certificate_table, score_table
from er_observers.synthesis.certify import plain
from er_observers.synthesis.make import (
    OUTPUTS,
    STRUCTURES,
    THEOREMS,
    Wish,
    least_gamma,
    synthesise,
    trade_off,
)
from er_observers.synthesis.spec import SECTORS, SLOPE, Spec


class _Synth(OneLineGroup):
    """The commands of the synthesis."""

    moved: ClassVar = {
        "compare": "./er study observers",
        "variants": "./er study variants",
        "figures": "./er study figures",
        "fault_trials": "./er study fault_trials",
    }


app = typer.Typer(
    cls=_Synth, add_completion=False, no_args_is_help=True, pretty_exceptions_enable=False
)
ModelFile = Annotated[Path, typer.Option(help="Vehicle model file.")]


@app.callback()
def synth() -> None:
    """Compute observer gains offline, prove them, write them to a gain file, try them."""


def _command(observer: str) -> None:
    """Add the command that makes the gains of one observer."""

    def command(
        model: ModelFile,
        out: Annotated[Path, typer.Option(help="Gain file to write.")],
        radius: Annotated[
            float, typer.Option(help="Largest magnitude of every pole [1/s].")
        ] = Spec.radius,
        decay: Annotated[float, typer.Option(help="Least decay rate of every pole [1/s].")] = 0.0,
        damping: Annotated[float, typer.Option(help="Least damping ratio of every pole.")] = 0.0,
        noise: Annotated[
            tuple[float, float],
            typer.Option(
                help="Noise weights of both accelerations: the error counted as 1 [m/s2]."
            ),
        ] = (Spec.noise[0], Spec.noise[1]),
        force: Annotated[
            float, typer.Option(help="Scale of the force error: counted as 1 [N].")
        ] = 5.0,
        deflection: Annotated[
            float | None,
            typer.Option(
                help="Use a deflection sensor; its noise weight: the error counted as 1 [m]."
            ),
        ] = None,
        output: Annotated[
            str, typer.Option(help=f"Performance output: {', '.join(OUTPUTS)}.")
        ] = "force",
        coordinates: Annotated[
            str, typer.Option(help=f"Velocities among the states: {', '.join(COORDINATES)}.")
        ] = "relative",
        sector: Annotated[
            str, typer.Option(help=f"Bound on the slope of the gate: {', '.join(SECTORS)}.")
        ] = SLOPE.name,
        structure: Annotated[
            str, typer.Option(help=f"Structure of the unified observer: {', '.join(STRUCTURES)}.")
        ] = "full",
        duty: Annotated[
            tuple[float, float], typer.Option(help="Range of the duty that the gains are for.")
        ] = Spec.rho,
    ) -> None:
        writable({"--out": out}, read={"--model": (model,)})
        if sector not in SECTORS:
            raise ErError(f"sector: expected one of {', '.join(SECTORS)}, found '{sector}'")
        spec = Spec(SECTORS[sector], duty, noise, radius=radius, decay=decay, damping=damping)
        wish = Wish(spec, output, coordinates, force, deflection, structure)
        write_gains(observer, load_model(model), wish, out)

    app.command(observer, help=f"Gains of {THEOREMS[observer].THEOREM}.")(command)


for _name in THEOREMS:
    _command(_name)


@app.command("all")
def all_command(
    model: ModelFile,
    out: Annotated[Path, typer.Option(help="Folder for the gain files.")],
) -> None:
    """Gains of every observer with its default wish."""
    files = {observer: out / f"{observer}.yaml" for observer in THEOREMS}
    writable(
        {f"--out, {observer}": file for observer, file in files.items()},
        read={"--model": (model,)},
    )
    car = load_model(model)
    for observer, file in files.items():
        write_gains(observer, car, Wish(), file)


def write_gains(observer: str, car: Model, wish: Wish, out: Path) -> None:
    """Solve, prove, write and show; raises as `synthesise`."""
    begun = time.perf_counter()
    claim, certificate = synthesise(observer, car, wish)
    curve = trade_off(observer, car, wish)
    radii, gammas = zip(*curve, strict=True)
    kept = {"radius": list(radii), "gamma": [plain(gamma) for gamma in gammas]}
    loadable = wish.coordinates == "relative"
    if loadable:
        save_gains(out, observer, car, claim, certificate, kept)
    title = f"{THEOREMS[observer].THEOREM}, {time.perf_counter() - begun:.1f} s"
    Console().print(certificate_table(title, claim, certificate))
    pairs = ", ".join(f"{r:g}: {g:.4g}" for r, g in curve)
    Console().print(f"gamma over the bound of the poles [1/s]: {pairs}")
    least = least_gamma(observer, car, wish)
    if least is not None:
        Console().print(f"gamma of any gains of this theorem: above {least:.4f}, in fractions")
    told = f"wrote {out}" if loadable else "not written: the loop needs relative coordinates"
    Console().print(told, soft_wrap=True)


@app.command("evaluate")
def evaluate_command(
    model: ModelFile,
    gains: Annotated[Path, typer.Option(help="Gain file of that model.")],
    plant: Annotated[
        Path | None, typer.Option(help="Vehicle model to simulate, if it is another one.")
    ] = None,
) -> None:
    """Errors of the observer on simulated drives with sensor noise and a wrong start."""
    car = load_model(model)
    loaded, driven = ready(gains, car, observer_of(gains)), load_model(plant) if plant else car
    Console().print(score_table([evaluate(driven, loaded, scenario) for scenario in SCENARIOS]))


def main() -> None:
    """Run the command line; an error of the user is one line."""
    try:
        app(prog_name="er synth")
    except ErError as error:
        print(f"er synth: {error}", file=sys.stderr)  # noqa: T201
        sys.exit(error.exit_status)


if __name__ == "__main__":
    main()
