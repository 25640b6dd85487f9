"""Command line of the LPV controller's synthesis: ``./er synth lpv_ftc --model MODEL --out GAINS``."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import asdict, replace
from pathlib import Path
from typing import Annotated, Any

import typer
from er_common.usage import OneLineCommand
from er_models.errors import ErError
from er_models.files import load_model
from er_models.places import writable
from rich.console import Console
from rich.table import Table

from er_ftc_controller.gains import save_gains
from er_ftc_controller.synthesis.certificate import Certificate
from er_ftc_controller.synthesis.lmi import Wish, passive_gamma
from er_ftc_controller.synthesis.make import synthesise, synthesise_feedback
from er_ftc_controller.synthesis.solution import Solution
from er_ftc_controller.synthesis.state_lqr import REGIMES
from er_ftc_controller.synthesis.state_proof import LEAST, Feedback
from er_ftc_controller.synthesis.study import HERTZ, Peaks, gains, passive_gains, peaks, trade_off
from er_ftc_controller.synthesis.weights import radius_for, weights_for

app = typer.Typer(add_completion=False, pretty_exceptions_enable=False)


@app.command(cls=OneLineCommand)
def lpv_ftc(
    model: Annotated[Path, typer.Option(help="Vehicle model file.")],
    out: Annotated[Path, typer.Option(help="Gain file to write.")],
    rho: Annotated[
        tuple[float, float] | None, typer.Option(help="Range of the scheduling parameter rho.")
    ] = None,
    force: Annotated[
        float | None, typer.Option(help="Scale of the damper force: counted as 1 [N].")
    ] = None,
    body: Annotated[
        tuple[float, float] | None,
        typer.Option(
            help="Weight of comfort: corner [Hz] and gain; else 2.33 times the body's frequency, 1."
        ),
    ] = None,
    wheel: Annotated[
        tuple[float, float] | None,
        typer.Option(
            help="Weight of road holding: the same; else 1.165 times the body's frequency, 6."
        ),
    ] = None,
    radius: Annotated[
        float | None,
        typer.Option(
            help="Largest magnitude of every pole [1/s]; else 1.126 times that without control."
        ),
    ] = None,
    held_back: Annotated[
        float,
        typer.Option(
            help="Gamma allowed at the greatest rho, as a multiple of the passive damper's."
        ),
    ] = Wish.held_back,
    pictures: Annotated[
        Path | None, typer.Option(help="Folder for Bode diagrams and the trade-off curve.")
    ] = None,
) -> None:
    """Compute the LPV fault-tolerant controller, prove it, write it."""
    writable({"--out": out}, pictures, {"--model": (model,)})
    car = load_model(model)
    given = {"rho": rho, "force": force, "body": body, "wheel": wheel}
    weights = replace(weights_for(car), **{k: v for k, v in given.items() if v is not None})  # type: ignore[arg-type]
    wish = Wish(radius_for(car) if radius is None else radius, held_back)
    with _progress() as tick:
        tick("vertices")
        plant, solution, certificate = synthesise(car, weights, wish)
        tick("state feedback")
        feedback = synthesise_feedback(car)
        curve = trade_off(car, weights, wish.radius, tick) if pictures else []
    ends = [(f"rho = {k.rho:g}", gains(plant, k)) for k in solution.vertices]
    passive = passive_gains(car)
    notes: dict[str, Any] = {"wish": asdict(wish), "certificate": _plain(certificate)}
    save_gains(out, car, plant, solution, notes, feedback)
    found = [("passive", peaks(passive)), *((name, peaks(g)) for name, g in ends)]
    Console().print(_table(passive_gamma(plant), solution, certificate, found))
    Console().print(_state_table(feedback))
    if pictures is not None:
        from er_ftc_controller.report.bode import bode_picture, trade_off_picture

        bode_picture(pictures / "bode.svg", HERTZ, passive, ends)
        trade_off_picture(pictures / "trade_off.svg", curve)
        for high, allowed, share in curve:
            line = f"rho to {high:g}, {allowed:g} x passive there: gamma {share:.3f} x passive"
            Console().print(line)
    Console().print(f"wrote {out}", soft_wrap=True)


def _plain(c: Certificate) -> dict[str, Any]:
    """A certificate as plain data of five digits."""

    def short(value: Any) -> Any:
        if isinstance(value, tuple):
            return [short(v) for v in value]
        return float(f"{value:.5g}")

    return {key: short(value) for key, value in asdict(c).items()}


def _table(passive: float, s: Solution, c: Certificate, found: list[tuple[str, Peaks]]) -> Table:
    """What was made and proved, for people."""
    table = Table(title="LPV controller", show_lines=False)
    for name in ("", *(name for name, _ in found)):
        table.add_column(name, justify="right" if name else "left")
    of = [p for _, p in found]
    rows = [
        ("gamma proved", f"{passive:.4f}", *(f"{k.gamma:.4f}" for k in s.vertices)),
        ("largest gain, swept", "", *(f"{v:.4f}" for v in c.peaks)),
        ("margin, exact to a factor of 2", "", *(f"{v:.1e}" for v in c.margins)),
        ("peak z_s / z_r, 1 to 10 Hz", *(f"{p.body:.3f}" for p in of)),
        ("peak z_us / z_r, 1 to 5 Hz", *(f"{p.wheel:.3f}" for p in of)),
        ("peak z_us / z_r, anywhere", *(f"{p.wheel_anywhere:.3f}" for p in of)),
        ("slowest pole [1/s]", "", *(f"{v:.2f}" for v in c.slowest)),
        ("spectral radius at 200 Hz", "", *(f"{v:.4f}" for v in c.radii)),
    ]
    for row in rows:
        table.add_row(*row)
    table.caption = f"sampled at 200 Hz, any held rho: {c.mixed:.4f}; stable however rho jumps"
    return table


def _state_table(feedback: Feedback) -> Table:
    """Gains of the regimes and the gain from the road that is proved with each, for people."""
    table = Table(title="State feedback")
    for name in ("", "z_def [N/m]", "z_s' [N s/m]", "z_t [N/m]", "z_us' [N s/m]", "F_er", "gamma"):
        table.add_column(name, justify="right" if name else "left")
    rows = zip(("none", *REGIMES), ((0.0,) * 5, *feedback.law.gains), feedback.proof.gammas)
    for name, gain, gamma in rows:
        table.add_row(name, *(f"{k:.4g}" for k in gain), f"{gamma:.3f}")
    table.caption = (
        f"proved for every mixture, f2 and f3 from {LEAST:g} to 1, however fast they change"
    )
    return table


@contextmanager
def _progress() -> Iterator[Any]:
    """What is being done, on a terminal only."""
    if not sys.stderr.isatty():
        yield lambda _: None
        return
    with Console(stderr=True).status("") as shown:
        yield shown.update


def main(arguments: list[str] | None = None) -> None:
    """Run the command line; an error of the user is one line."""
    try:
        app(arguments, prog_name="er synth lpv_ftc")
    except ErError as error:
        print(f"er synth: {error}", file=sys.stderr)  # noqa: T201
        sys.exit(error.exit_status)


if __name__ == "__main__":
    main()
