"""``./er control``: the fault-tolerant controller in closed loop without ROS: comparison, inner loop, figures."""

from __future__ import annotations

import sys
from dataclasses import replace
from pathlib import Path
from typing import Annotated

import typer
from er_bringup.up import configuration
from er_common.usage import OneLineGroup
from er_models.errors import ErError, UnknownName
from er_models.files import write_json
from er_models.places import writable

from er_studies.control import contest_command, inner, tradeoff, whole_car
from er_studies.control.closed_loop import known
from er_studies.control.estimated import estimated
from er_studies.control.run import WatchOf, compare, run, setup
from er_studies.control.scenarios import Scenario, load_scenarios
from er_studies.control.table import markdown
from er_studies.given_out import Json, Out, say
from er_studies.progress import progress_of

app = typer.Typer(
    cls=OneLineGroup,
    add_completion=False,
    pretty_exceptions_enable=False,
    no_args_is_help=True,
    help=__doc__,
)
WATCHES: dict[str, WatchOf] = {"estimated": estimated, "known": known}
"""Where controllers have the faults from."""
SHOWN = ("passive", "nominal", "fault_tolerant")
"""Controllers in the figures."""
Names = Annotated[list[str] | None, typer.Argument(help="Scenarios; all by default.")]
From = Annotated[
    str,
    typer.Option("--faults", help=f"Where controllers get the faults from: {', '.join(WATCHES)}."),
]
Seeds = Annotated[
    int | None, typer.Option(min=1, help="Number of random roads per scenario; all by default.")
]


app.command("tune")(contest_command.tune_command)
app.command("peers")(contest_command.peers_command)
app.command("robust")(contest_command.robust_command)
app.command("front")(contest_command.front_command)


@app.command("compare")
def compare_command(
    only: Names = None,
    faults: From = "estimated",
    fault: Annotated[str | None, typer.Option(help="One fault; all by default.")] = None,
    seeds: Seeds = None,
    out: Out = None,
) -> None:
    """All controllers on all faults and roads of the scenarios: tables of means and paired differences."""
    writable({"--out": out})
    config = configuration()
    scenarios = tuple(_with(s, fault) for s in _scenarios(only))
    with progress_of("roads") as tick:
        outcomes = compare(setup(config), scenarios, _watch(faults), seeds, tick=tick)
    say(markdown(scenarios, outcomes, faults), out)


@app.command("car")
def car_command(
    seeds: Annotated[int, typer.Option(min=1, help="Number of random roads.")] = 5,
    seconds: Annotated[float, typer.Option(min=1.0, help="Length of a random road [s].")] = 20.0,
    first: Annotated[int, typer.Option(min=0, help="Seed of the first road.")] = 0,
    out: Out = None,
    json_file: Json = None,
) -> None:
    """Controllers of the whole car: on random roads, in turns and while braking."""
    writable({"--out": out, "--json": json_file})
    with progress_of("rides") as tick:
        found = []
        for row in whole_car.rows(configuration(), seeds, seconds, first):
            found.append(row)
            if tick:
                tick(len(found), 10)
    say(whole_car.markdown(found), out)
    write_json(json_file, found)


@app.command("inner")
def inner_command(
    scenario: Annotated[str, typer.Argument(help="Name of the scenario.")] = "thesis_6_4_2",
    fault: Annotated[str, typer.Option(help="Fault of the scenario.")] = "leakage",
    seeds: Annotated[int, typer.Option(min=1, help="Number of random roads.")] = 3,
) -> None:
    """From force to duty: inverse static model and inner loop, on the car as believed and on others."""
    (chosen,) = _scenarios([scenario])
    _with(chosen, fault)
    say(inner.markdown(inner.rows(setup(configuration()), chosen, fault, seeds)))


@app.command("tradeoff")
def tradeoff_command(
    scenario: Annotated[str, typer.Argument(help="Name of the scenario.")] = "thesis_6_4_2",
    seeds: Annotated[int, typer.Option(min=1, help="Number of random roads.")] = 5,
    first: Annotated[
        int | None, typer.Option(min=0, help="Seed of the first road; the scenario's by default.")
    ] = None,
) -> None:
    """Deflection against comfort over horizon, dead zone and mu, healthy and with faults."""
    (chosen,) = _scenarios([scenario])
    if first is not None:
        chosen = replace(chosen, program=replace(chosen.program, seed=first))
    faults = ("healthy", "electrical", "leakage")
    with progress_of("roads") as tick:
        found = tradeoff.points(setup(configuration()), chosen, faults, seeds, tick=tick)
    say(tradeoff.markdown(found))


@app.command("endurance")
def endurance_command(
    minutes: Annotated[float, typer.Option(min=0.1, help="Length of the ride [min].")] = 10.0,
    seed: Annotated[int, typer.Option(min=0, help="Seed of road and sensor noise.")] = 1,
    latency: Annotated[
        int,
        typer.Option(
            min=0, max=4, help="Samples between a measurement and the duty that answers it."
        ),
    ] = 0,
    faults: From = "estimated",
) -> None:
    """A long ride with all three faults coming and going; exit status 1 where the loop is not stable."""
    from er_studies.control.endurance import Ride, ride

    r = Ride(60.0 * minutes, seed=seed, latency=latency)
    with progress_of("seconds driven") as tick:
        found = ride(setup(configuration()), _watch(faults), r, tick)
    say(f"{minutes:g} min, seed {seed}: {'stable' if found.stable else 'NOT STABLE'}")
    say(f"peak deflection over the passive car's: {found.peak:.3f}, rms: {found.rms:.3f}")
    say(
        f"changes of mode: {found.changes}; fault-tolerant {100 * found.adapted:.1f} % of the time"
    )
    say(f"safe {100 * found.safe:.2f} % of the time")
    say(
        "rms error of the factors in use f1, f2, f3: " + ", ".join(f"{e:.3f}" for e in found.error)
    )
    if not found.stable:
        raise typer.Exit(1)


@app.command("figures")
def figures_command(
    folder: Annotated[Path, typer.Argument(help="Folder for the pictures.")],
    faults: From = "estimated",
    fault: Annotated[str, typer.Option(help="Fault of the scenarios.")] = "leakage",
) -> None:
    """Figures 6.18 to 6.23 for ours: road, deflection, force and duty on the first road of each scenario."""
    from er_studies.control.report.runs import runs_picture

    of, watch = setup(configuration()), _watch(faults)
    for s in _scenarios(None):
        _with(s, fault)
        records = {name: run(of, s, fault, of.law(name, s), watch, 0) for name in SHOWN}
        begin, end = s.window
        path = folder / f"{s.name}.png"
        runs_picture(
            path,
            f"{s.title}: {fault}, faults {faults}",
            records,
            begin - 1.0,
            min(end, begin + 3.0),
        )
        say(f"wrote {path}")


def _scenarios(only: list[str] | None) -> tuple[Scenario, ...]:
    """Scenarios of these names, all for none."""
    return load_scenarios(configuration() / "scenarios" / "control", only or ())


def _with(scenario: Scenario, fault: str | None) -> Scenario:
    """The scenario with one of its faults, or all for None."""
    if fault is None:
        return scenario
    if fault not in scenario.faults:
        raise UnknownName("fault", fault, tuple(scenario.faults))
    return replace(scenario, faults={fault: scenario.faults[fault]})


def _watch(name: str) -> WatchOf:
    """A source of fault estimates."""
    if name not in WATCHES:
        raise UnknownName("source of faults", name, tuple(WATCHES))
    return WATCHES[name]


def main() -> None:
    """Run the command line; an error of the user is one line."""
    try:
        app(prog_name="er control")
    except ErError as error:
        sys.stderr.write(f"er control: {error}\n")
        sys.exit(error.exit_status)


if __name__ == "__main__":
    main()
