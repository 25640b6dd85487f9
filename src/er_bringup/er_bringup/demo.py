"""``er demo``: the main job from end to end, on a damper with an effect nobody told the lab.

Two runs of the whole graph are recorded: one to learn from (random road and duty), one to check (another
road, the controller in the loop). The lab sees the bags only: it compares, diagnoses, adds the effect, and
the error on the check run falls to the noise floor. Exit status 0 only if it found what was hidden.
"""

from __future__ import annotations

import argparse
import json
import secrets
import sys
import time
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from er_models.errors import ErError
from er_models.files import load_model, save_model
from er_models.model import Model
from er_models.one_line import BAD_USAGE, OneLine
from er_models.seed import OF_A_PLANT, seed_reader
from rich.console import Console
from rich.table import Table

from er_bringup.demo_live import LATER, Live, has_browser
from er_bringup.demo_live import play as play_live
from er_bringup.hidden import RANGES, choose, hide
from er_bringup.terminal import console
from er_bringup.up import configuration, run

CONTROLLER = "ftc_controller"
CLOSE = 1.15
"""Held-out error over noise floor that counts as reached."""
MAY_FAIL = 0.05
"""Share of repeated demonstrations that may fail: the lab names what is hidden in 95 of 100 recordings."""


@dataclass(frozen=True)
class Demo:
    """What to do: effect (name, none or random), seed, lengths of both runs [s], folder of results."""

    effect: str
    seed: int
    learn: float
    check: float
    out: Path
    mode: str


@dataclass(frozen=True)
class Verdict:
    """What was hidden, what was found, the errors on the check run [N], and whether it is a success."""

    hidden: str | None
    found: tuple[str, ...]
    verdict: str
    before: float
    after: float
    floor: float
    success: bool
    seconds: float


def play(demo: Demo, console: Console) -> Verdict:
    """Record, compare, diagnose, add, and judge."""
    from er_model_lab.verbs.improve import improve
    from er_model_lab.verbs.load import load

    began = time.monotonic()
    config = configuration()
    hidden = choose(demo.effect, demo.seed)
    model_file = config / "dampers" / "inove_guo.yaml"
    given = load_model(model_file)
    truth = hide(given, hidden, demo.seed)
    demo.out.mkdir(parents=True, exist_ok=True)
    sealed = demo.out / "sealed" / "damper.yaml"
    save_model(truth, sealed)
    console.print(
        f"seed {demo.seed}: an effect is hidden in the plant; the lab sees only the recordings"
    )
    learn = record(demo, sealed, "learn", demo.learn, "program", demo.seed, console)
    check = record(demo, sealed, "check", demo.check, "command", demo.seed + 1, console)
    console.print(repeated(check))
    console.print("comparing, diagnosing, adding ...")
    new = demo.out / "model.yaml"
    found = improve(load(learn), given, name=new.stem, held_out=load(check), seed=demo.seed)
    assert found.model is not None
    save_model(found.model, new)
    result, page = found.to_dict(), found.report(demo.out / "report")
    verdict = judge(result, hidden, reach(truth, learn, check), time.monotonic() - began)
    (demo.out / "result.json").write_text(json.dumps(result, indent=1) + "\n", encoding="utf-8")
    show(verdict, result, console)
    console.print(f"recordings: {learn}, {check}")
    console.print(f"new model:  {new}")
    console.print(f"report:     {page}")
    return verdict


def repeated(bag: Path) -> str:
    """What the controller says when the recording is played to it again, beside what it said live."""
    from er_bringup.played import core_of, play
    from er_bringup.recording import opened

    recording = opened(bag)
    found = play(recording, CONTROLLER, core_of(recording, CONTROLLER, "", {}), follow=True)
    words = "bit for bit as recorded" if not found.different else f"{found.different} others"
    return f"controller replayed from {bag.name}: {found.same} answers {words}, {found.speed:.0f} x real time"


def reach(truth: Model, learn: Path, check: Path) -> float:
    """Error of the true model itself on the check run [N]: what only the sensors leave."""
    from er_model_lab.level.damper import opened
    from er_model_lab.verbs.load import load
    from er_records.dataset import Dataset

    found = opened(Dataset.of(load(learn).records, load(check).records), truth)
    return float(np.sqrt(np.mean(found.given[found.problem.held_out] ** 2)))


def record(
    demo: Demo, damper: Path, name: str, seconds: float, duty: str, seed: int, console: Console
) -> Path:
    """Run the graph for some seconds and record it; raises `ErError` when a node fails."""
    bag, log = demo.out / name, demo.out / f"{name}.log"
    arguments = {
        "damper": str(damper), "duration": str(seconds), "seed": str(seed), "duty": duty,
        "record": str(bag), "program": "identification", "mode": demo.mode,
        "controller": "ftc", "fault_estimator": "true",
    }  # fmt: skip
    parts = "plant, three observers, fault estimator, controller and recorder"
    console.print(f"running {parts} for {seconds:g} s ({name}) ...")
    with log.open("w", encoding="utf-8") as stream:
        statuses = run(arguments, stream)
    failed = {label: status for label, status in statuses.items() if status}
    if failed:
        raise ErError(f"{log}: expected every node to end with status 0, found {failed}")
    return bag


def judge(result: dict[str, Any], hidden: str | None, floor: float, seconds: float) -> Verdict:
    """Success: the right name (or a pair the data cannot tell apart that holds it), and the floor reached.

    floor: error of the true model on the same run; nothing can do better but by luck.
    """
    found = tuple(result["effects"])
    after = result["rmse_after"]["held_out"]
    if hidden is None:
        right = result["verdict"] == "adequate"
    else:
        groups = [set(g) for g in result["alternatives"]]
        right = found == (hidden,) or (
            len(found) == 1 and any(hidden in g and len(g) <= 2 for g in groups)
        )
    success = right and after <= CLOSE * floor
    return Verdict(
        hidden,
        found,
        result["verdict"],
        result["rmse"]["held_out"],
        after,
        floor,
        success,
        seconds,
    )


def show(v: Verdict, result: dict[str, Any], console: Console) -> None:
    """The falling error, and what was hidden beside what was found."""
    table = Table(title="error on the check run, never used to learn")
    for column in ("model", "rms error [N]", "over the noise floor"):
        table.add_column(column)
    table.add_row(
        "as shipped", f"{result['rmse_as_given']:.3f}", f"{result['rmse_as_given'] / v.floor:.2f}"
    )
    for step in result["steps"]:
        label = "refitted" if step["added"] is None else f"+ {step['added']}"
        table.add_row(
            label, f"{step['rmse_held_out']:.3f}", f"{step['rmse_held_out'] / v.floor:.2f}"
        )
    table.add_row("noise floor: the true model", f"{v.floor:.3f}", "1.00")
    table.add_row(
        "noise floor as the lab sees it",
        f"{result['noise_floor']:.3f}",
        f"{result['noise_floor'] / v.floor:.2f}",
    )
    console.print(table)
    console.print(
        f"hidden: {v.hidden or 'nothing'}   verdict: {v.verdict}   found: {', '.join(v.found) or 'nothing'}"
    )
    word = "success" if v.success else "FAILED"
    console.print(
        f"{word}: held-out error {v.after / v.floor:.2f} of the noise floor, {v.seconds:.0f} s"
    )


def repeat(demo: Demo, times: int, console: Console) -> int:
    """Many demonstrations with seeds in a row, as a table in Markdown; returns how many failed."""

    def say(*cells: str) -> None:
        line = f"| {' | '.join(cells)} |"
        console.print(line, soft_wrap=True, markup=False, highlight=False)

    say("seed", "hidden", "found", "verdict", "before [N]", "after [N]", "floor [N]", "ok")
    say(*["---"] * 8)
    failures = 0
    for k in range(times):
        place = demo.out / f"{k:02d}"
        one = Demo(demo.effect, demo.seed + 10 * k, demo.learn, demo.check, place, demo.mode)
        v = play(one, Console(quiet=True))
        failures += not v.success
        errors = (f"{error:.3f}" for error in (v.before, v.after, v.floor))
        names = v.hidden or "none", " ".join(v.found) or "-", v.verdict
        say(f"{one.seed}", *names, *errors, "yes" if v.success else "NO")
    console.print(f"{times - failures} passed, {failures} failed")
    return failures


def parser() -> OneLine:
    """The command line."""
    p = OneLine(
        prog="er demo", description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    p.add_argument(
        "--effect", default="random", help=f"effect to hide: random, none, {', '.join(RANGES)}"
    )
    p.add_argument(
        "--seed",
        type=seed_reader(OF_A_PLANT - 1),
        help="seed of everything random; by default one nobody has seen",
    )
    p.add_argument("--learn", type=float, default=24.0, help="length of the run to learn from [s]")
    p.add_argument("--check", type=float, default=10.0, help="length of the run that checks [s]")
    p.add_argument("--out", type=Path, help="folder of recordings, model and report")
    p.add_argument(
        "--mode",
        default="realtime",
        choices=("realtime", "sim_time", "lockstep"),
        help="pace: of the real clock, of simulated time, or of the duties that answer",
    )
    p.add_argument("--repeat", type=int, default=1, help="that many demonstrations, and a table")
    live = p.add_argument_group("on the running graph, on a page")
    live.add_argument(
        "--live",
        action="store_true",
        help="find it while it is driven, and once more what begins then",
    )
    live.add_argument(
        "--later", default="leak", choices=(*LATER, "none"), help="what begins in the second drive"
    )
    live.add_argument(
        "--pace", type=float, default=1.0, help="speed of simulated time; 1: the real clock"
    )
    live.add_argument("--no-browser", action="store_true", help="only print the page's address")
    live.add_argument("--stay", action="store_true", help="the page stays until Ctrl-C")
    return p


def live_of(given: argparse.Namespace, seed: int, out: Path) -> Live:
    """What to do on the running graph."""
    browser = has_browser() and not given.no_browser
    return Live(given.effect, seed, given.later, given.pace, out, browser, given.stay)


def main() -> None:
    """Entry point; exit status 0 only if the effect was found and the floor reached; of many, in all but `MAY_FAIL`."""
    given = parser().parse_args()
    seed = given.seed if given.seed is not None else secrets.randbelow(OF_A_PLANT)
    out = given.out or Path("log") / "demo" / f"{time.strftime('%Y%m%d-%H%M%S')}-{seed}"
    demo = Demo(given.effect, seed, given.learn, given.check, out.absolute(), given.mode)
    try:
        if given.live:
            sys.exit(0 if play_live(live_of(given, seed, out.absolute()), console()) else 1)
        if given.repeat > 1:
            sys.exit(1 if repeat(demo, given.repeat, console()) > MAY_FAIL * given.repeat else 0)
        sys.exit(0 if play(demo, console()).success else 1)
    except ErError as error:
        sys.stderr.write(f"er demo: {error}\n")
        sys.exit(error.exit_status)
    except OSError as error:
        # of a write that found no room it is not known where
        sys.stderr.write(f"er demo: {error.filename or demo.out}: {error.strerror or error}\n")
        sys.exit(BAD_USAGE)


if __name__ == "__main__":
    main()
