"""Command line of the synthesis.

``python -m er_observers.synth nlpv_polytopic --model MODEL --out GAINS`` computes, proves and
writes gains; ``python -m er_observers.synth evaluate --model MODEL --gains GAINS`` shows what they
are worth.
"""

from __future__ import annotations

import sys
import time
from importlib.metadata import version
from pathlib import Path
from typing import Annotated

import typer
from er_models.errors import ErError
from er_models.files import load_model
from er_models.linear import relative_form
from er_models.model import Model
from rich.console import Console

from er_observers.compare.command import register as register_compare
from er_observers.gains import save_gains
from er_observers.observers.evaluate import SCENARIOS, evaluate
from er_observers.observers.nlpv_polytopic import NAME, load_gains
from er_observers.synth_tables import certificate_table, figures, score_table
from er_observers.synthesis import nlpv_polytopic
from er_observers.synthesis.certify import Certificate, certify
from er_observers.synthesis.proof import Claim
from er_observers.synthesis.scaling import scaling_of
from er_observers.synthesis.spec import Spec, force_output

app = typer.Typer(add_completion=False, no_args_is_help=True, pretty_exceptions_enable=False)
register_compare(app)
ModelFile = Annotated[Path, typer.Option(help="Vehicle model file.")]


@app.callback()
def synth() -> None:
    """Compute observer gains offline, prove them, write them to a gain file, try them."""


@app.command(NAME)
def nlpv_polytopic_command(
    model: ModelFile,
    out: Annotated[Path, typer.Option(help="Gain file to write.")],
    radius: Annotated[float, typer.Option(help="Bound of every pole [1/s].")] = Spec.radius,
    noise: Annotated[
        tuple[float, float], typer.Option(help="Accelerations that count as one [m/s2].")
    ] = (Spec.noise[0], Spec.noise[1]),
    force: Annotated[float, typer.Option(help="Force error that counts as one [N].")] = 5.0,
) -> None:
    """NLPV polytopic observer, Theorem 4.3.1, relative coordinates, slope-restricted gate."""
    begun = time.perf_counter()
    car = load_model(model)
    claim, certificate = synthesise(car, Spec(radius=radius, noise=noise), force)
    solver = {"name": "Clarabel", "version": version("clarabel"), "cvxpy": version("cvxpy")}
    notes = {"certificate": figures(certificate), "solver": solver}
    save_gains(out, NAME, car, claim, notes)
    title = f"{nlpv_polytopic.THEOREM}, {time.perf_counter() - begun:.1f} s"
    Console().print(certificate_table(title, claim, certificate))
    Console().print(f"wrote {out}", soft_wrap=True)


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
    loaded, driven = load_gains(gains, car), load_model(plant) if plant else car
    Console().print(score_table([evaluate(driven, loaded, scenario) for scenario in SCENARIOS]))


def synthesise(model: Model, spec: Spec, force: float = 5.0) -> tuple[Claim, Certificate]:
    """Solve, prove and certify, with a force error of `force` [N] as one.

    Raises `SynthesisFailed`, or what `relative_form` raises.
    """
    form = relative_form(model)
    scaling, output = scaling_of(model, form), force_output(form, force)
    solution = nlpv_polytopic.solve(form, output, spec, scaling)
    claim = Claim(form, output, spec, scaling, solution)
    return claim, certify(claim, nlpv_polytopic.THEOREM)


def main() -> None:
    """Run the command line; an error of the user is one line."""
    try:
        app()
    except ErError as error:
        print(f"er synth: {error}", file=sys.stderr)  # noqa: T201
        sys.exit(error.exit_status)


if __name__ == "__main__":
    main()
