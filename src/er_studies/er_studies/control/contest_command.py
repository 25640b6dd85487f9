"""``./er control tune``, ``peers`` and ``front``: ours beside the controllers that a practitioner would pick."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import lru_cache
from pathlib import Path
from typing import Annotated

import typer
import yaml
from er_bringup.up import configuration
from er_ftc_controller.control import Ftc
from er_ftc_controller.gains import load_gains
from er_ftc_controller.settings import controller_of
from er_models.constants import SAMPLE_TIME as DT
from er_models.files import write_json, write_whole
from er_models.model import Array
from er_models.places import writable
from er_models.yaml_file import read_yaml

from er_studies.control import contest, robust
from er_studies.control.contest import FAULTS, SCORED, TONES, Line, Rider
from er_studies.control.form_ride import Ridden
from er_studies.control.peers import PEERS
from er_studies.control.run import Setup, setup
from er_studies.given_out import Json, Out, say
from er_studies.progress import progress_of

ONLY = ("both", "iso", "bumps")
OURS = "fault_tolerant"
Seeds = Annotated[int, typer.Option(min=1, help="Number of random roads of a kind.")]


def tune_command(
    out: Annotated[Path, typer.Option(help="File of knobs to write.")],
    only: Annotated[str, typer.Option(help=f"Roads that count: {', '.join(ONLY)}.")] = "both",
    budget: Annotated[int, typer.Option(min=1, help="Draws for every peer.")] = contest.BUDGET,
) -> None:
    """Tune every peer by the same number of draws, on other roads than those that are scored."""
    writable({"--out": out})
    model, found = setup(configuration()).model, {}
    with progress_of("peers") as tick:
        for name in PEERS:
            knobs = contest.tuned(model, name, only, budget)
            found[name] = {k: float(f"{v:.4g}") for k, v in knobs.items()}
            if tick is not None:
                tick(len(found), len(PEERS))
    write_whole(out, yaml.safe_dump(found, sort_keys=False))


def peers_command(
    seeds: Seeds = 20,
    knobs: Annotated[Path | None, typer.Option(help="Knobs, as `tune` writes them; else the shipped ones.")] = None,
    told: Annotated[bool, typer.Option(help="Tell ours the faults; no peer is told.")] = True,
    out: Out = None,
    json_file: Json = None,
) -> None:  # fmt: skip
    """Ours and its peers on ISO roads with every fault, on bumps, within the rig's limits, and on tones."""
    writable({"--out": out, "--json": json_file})
    lines = _contest(seeds, knobs, told=told)
    tones = _tones(setup(configuration()))
    say(contest.markdown(lines) + "\n\n" + contest.tones_markdown(tones), out)
    write_json(json_file, {"lines": lines, "tones": list(tones.items())})


def robust_command(seeds: Seeds = 5, out: Out = None, json_file: Json = None) -> None:
    """The loop with the fault estimator, on a leak that appears: other loads, late and lost samples."""
    writable({"--out": out, "--json": json_file})
    of, knobs = setup(configuration()), _knobs(None)
    constant = knobs["constant"]["duty"]
    with progress_of("cases") as tick:
        found = robust.rows(of, seeds, constant, tick)
    say(robust.markdown(found, constant), out)
    write_json(json_file, {"constant": constant, "cases": found})


def front_command(
    picture: Annotated[Path, typer.Argument(help="Picture to write.")],
    seeds: Seeds = 20,
) -> None:
    """Deflection against comfort of ours and every peer, on ISO roads and bumps, healthy and with a leak."""
    from er_studies.control.report.front import front_picture

    front_picture(
        picture, [x for x in _contest(seeds, None, told=True) if x.fault in ("healthy", "leakage")]
    )


def _knobs(file: Path | None) -> Mapping[str, Mapping[str, float]]:
    """Knobs of all peers."""
    found: Mapping[str, Mapping[str, float]] = read_yaml(
        file or configuration() / "weights" / "peers.yaml", "a file of knobs"
    )
    return found


def _contest(seeds: int, knobs: Path | None, *, told: bool) -> list[Line]:
    """Every controller on all kinds of roads."""
    of = setup(configuration())
    model = of.model
    given = _knobs(knobs)
    riders: dict[str, Rider] = {
        name: contest.peer(model, name, {k: given[name][k] for k in peer.knobs})
        for name, peer in PEERS.items()
    }
    riders[OURS] = contest.ours(_built(of), told=told)
    cars = [Ridden(model, left) for left in FAULTS.values()]
    two = [Ridden(model), Ridden(model, FAULTS["leakage"])]
    roads = [contest.iso(model, SCORED + k) for k in range(seeds)]
    bumps = [contest.bump(model, SCORED + k) for k in range(seeds)]
    kinds = {
        "ISO": (roads, cars),
        "bumps": (bumps, two),
        "bumps, rig": (bumps, contest.limited(two, 0.3, 1)),
    }
    names = {left: name for name, left in FAULTS.items()}
    with progress_of("cars") as tick:
        return contest.contest(riders, kinds, names, tick)


def _tones(of: Setup) -> dict[float, Array]:
    """Changes of ours at each frequency [Hz]."""
    rider, car = contest.ours(_built(of)), Ridden(of.model)
    roads = [contest.tone(of.model, hertz) for hertz in TONES]
    bare = contest.scores(car, roads, contest.passive)
    return dict(zip(TONES, contest.scores(car, roads, rider) / bare - 1.0, strict=True))


def _built(of: Setup) -> Callable[[Ridden], Ftc]:
    """What makes the shipped controller within the limits of a ride, once for each."""
    loaded = load_gains(of.parameters.gains_file, of.model)

    @lru_cache(maxsize=8)
    def limited(u_max: float, latency: int) -> Ftc:
        p = replace(of.parameters, u_max=u_max, latency=latency * DT)
        return controller_of(p, of.model, loaded)

    return lambda car: limited(car.u_max, car.latency)
