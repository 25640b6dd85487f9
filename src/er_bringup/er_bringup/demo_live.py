"""``er demo --live``: the same on the running graph, on a page that anyone may watch, and without one.

First drive: an effect is hidden in the damper. The page hears the graph, says what the drive has not shown yet,
diagnoses when the data carry a verdict, adds the effect, gives the new model to the graph's monitor, and the live error
falls. Second drive: the damper begins to leak, or to heat up; the monitor finds it, and the model is learnt anew from
what came since. Exit status 0 only if the effect was found and both errors fell.
"""

from __future__ import annotations

import os
import threading
from collections.abc import Callable
from contextlib import contextmanager
from dataclasses import dataclass, field, replace
from pathlib import Path
from time import monotonic, sleep
from typing import TYPE_CHECKING, Any

from er_common.port import HOST, free_port
from er_models.errors import ErError
from er_models.files import load_model, save_model
from er_models.model import Model
from rich import box
from rich.console import Console
from rich.table import Table

from er_bringup.hidden import choose, hide
from er_bringup.up import configuration, run

if TYPE_CHECKING:
    from collections.abc import Iterator

    from er_model_lab.session.live_desk import LiveDesk

BEGINS = 60.0
"""When something begins in the second drive [s]."""
LATER: dict[str, tuple[str, dict[str, float]]] = {
    "leak": ("oil_leakage", {"f": 0.75, "t_0": BEGINS, "t_r": 5.0, "q": 0.0, "d": 0.5}),
    "heat": ("self_heating", {"t_h": 5.0, "b_v": 3.0, "b_y": 3.0}),
}
"""What begins then: the effect that the plant's damper gets, and its values [SI]."""
LEARN = 15.0
"""Motion from which the monitor learns what the error of its model is like [s]."""
FALLS = 0.9
"""Live error after over before, at most, to have fallen."""
COUNTED = 10.0
"""Time of the drive over which a live error is taken [s]."""
START, VERDICT, ALARM, JOB = 400.0, 400.0, 400.0, 1800.0
"""Longest waits for the first sample, a verdict, an alarm and a job [s]; machines may be busy."""
LOOK = 0.2


@dataclass(frozen=True)
class Live:
    """What to do: effect and seed as in `Demo`, what begins later, pace of simulated time (1: the real clock).

    over: set once the page has ended, whoever ended it: no graph is left behind.
    """

    effect: str
    seed: int
    later: str
    pace: float
    out: Path
    browser: bool
    stay: bool
    over: threading.Event = field(default_factory=threading.Event)


@dataclass(frozen=True)
class Act:
    """One drive: what was hidden, what was found, the live error before and after [N], and whether that is right."""

    hidden: str
    found: str
    before: float
    after: float
    right: bool

    @property
    def success(self) -> bool:
        """Whether it was found and the live error fell."""
        return self.right and self.after <= FALLS * self.before


def play(live: Live, console: Console) -> bool:
    """Both drives; whether both went well."""
    from er_model_lab.page.server import serve
    from er_model_lab.session.live_desk import LiveDesk

    live.out.mkdir(parents=True, exist_ok=True)
    acts: list[Act] = []
    failed: list[ErError] = []
    desk = LiveDesk(live.out / "heard", "", models=live.out / "models", seed=live.seed)

    def steps() -> None:
        try:
            acts.append(first(live, desk, console))
            if live.later != "none":
                acts.append(second(live, desk, console))
        except ErError as error:
            failed.append(error)
        show(acts, console)
        while live.stay and not failed:
            sleep(1.0)

    say = console.print
    try:
        serve(
            desk, host=HOST, port=free_port(), browser=live.browser,
            say=lambda address: say(f"page: {address}", soft_wrap=True), beside=steps,
        )  # fmt: skip
    finally:
        live.over.set()
    if failed:
        raise failed[0]
    return len(acts) == 1 + (live.later != "none") and all(act.success for act in acts)


def first(live: Live, desk: LiveDesk, console: Console) -> Act:
    """An effect is hidden from the beginning."""
    hidden = choose(live.effect, live.seed) or "nothing"
    with drive(live, desk, truth_of(live), "first", live.seed):
        _wait("the first sample", START, lambda: desk.heard.seconds > 1.0, desk)
        console.print("driving: the page listens, and diagnoses when the data carry a verdict ...")
        _wait("a verdict", VERDICT, lambda: _decided(desk), desk)
        result, before = _result(desk), desk.heard.error(COUNTED)
        console.print(
            f"after {desk.heard.now:.0f} s of driving: {result['verdict']}, {', '.join(result['effects'])}"
        )
        desk.by_itself = False
        found = tuple(result["effects"])
        if found:
            desk.add(found[0])
        after = _given(desk, console)
    groups = [set(g) for g in result["alternatives"]]
    right = found == (hidden,) or (
        len(found) == 1 and any(hidden in g and len(g) <= 2 for g in groups)
    )
    return Act(hidden, ", ".join(found) or "nothing", before, after, right)


def second(live: Live, desk: LiveDesk, console: Console) -> Act:
    """The same damper with its model in the monitor; something begins while it is driven."""
    from er_bringup.ros_ask import set_parameters

    (effect, values), truth, before = LATER[live.later], truth_of(live), desk.heard.now
    with drive(live, desk, truth, "second", live.seed + 1):
        _wait(
            "another drive",
            START,
            lambda: desk.heard.seconds > 1.0 and desk.heard.now < before,
            desk,
        )
        desk.give()
        _wait("the monitor", JOB, lambda: desk.heard.since > 0.0, desk)
        console.print("the monitor goes by the new model; something begins in this drive ...")
        _wait("the middle of the drive", ALARM, lambda: desk.heard.now > BEGINS, desk)
        changed = _sealed(live, truth.with_effect(effect, values), live.later)
        set_parameters("/plant", damper_file=str(changed))
        _wait("an alarm", ALARM, lambda: desk.failing, desk)
        at, began = desk.heard.now, desk.heard.began()
        console.print(f"alarm after {at:.0f} s of driving; it began about {began:.0f} s")
        _wait("more data", ALARM, lambda: desk.heard.now - at > 2.0 * COUNTED, desk)
        error = desk.heard.error(COUNTED)
        desk.improve()
        after = _given(desk, console)
    return Act(f"{effect}, later", "an alarm", error, after, at > BEGINS)


def _decided(desk: LiveDesk) -> bool:
    return (
        not desk.jobs.running
        and desk.result is not None
        and desk.result.verdict != "insufficient_data"
    )


def _result(desk: LiveDesk) -> dict[str, Any]:
    assert desk.result is not None
    return desk.result.to_dict()


def _given(desk: LiveDesk, console: Console) -> float:
    """Wait until the monitor goes by what a job learns; the live error some time later [N]."""
    since = desk.heard.since
    _wait("the fit", JOB, lambda: not desk.jobs.running, desk)
    _wait("the monitor", JOB, lambda: desk.heard.since > since, desk)
    console.print(f"from {desk.heard.since:.0f} s on the monitor goes by: {desk.running}")
    _wait("the error", JOB, lambda: desk.heard.now - desk.heard.since > COUNTED + 2.0, desk)
    return desk.heard.error(COUNTED)


def _wait(what: str, seconds: float, there: Callable[[], bool], desk: LiveDesk) -> None:
    """Wait for something, as long as jobs run; raises `ErError` where it does not come."""
    began, until = monotonic(), monotonic() + seconds
    while not there():
        job = desk.jobs.job
        if desk.jobs.running and monotonic() < began + JOB:
            until = max(until, monotonic() + seconds)
        wrong = desk.gone or desk.refused or (job.error if job and not job.running else "")
        if wrong or monotonic() > until:
            raise ErError(f"{what} did not come: {wrong or f'{seconds:g} s have passed'}")
        sleep(LOOK)


def truth_of(live: Live) -> Model:
    """The damper of the plant, which nobody sees but the plant."""
    given = load_model(configuration() / "dampers" / "inove_guo.yaml")
    return hide(given, choose(live.effect, live.seed), live.seed)


def _sealed(live: Live, truth: Model, name: str) -> Path:
    """The file of a damper that the plant alone is told."""
    path = live.out / "sealed" / f"{name}.yaml"
    save_model(replace(truth, name="hidden"), path)
    return path


@contextmanager
def drive(live: Live, desk: LiveDesk, truth: Model, name: str, seed: int) -> Iterator[None]:
    """The graph, with this damper in its plant, for as long as the block takes; raises `ErError` where it failed."""
    sealed, rules = _sealed(live, truth, name), live.out / "monitor.yaml"
    rules.write_text(
        f"/**/model_monitor:\n  ros__parameters:\n    learn: {LEARN}\n", encoding="utf-8"
    )
    paced = {"mode": "sim_time", "rate_factor": str(live.pace)} if live.pace != 1.0 else {}
    arguments = {
        "damper": str(sealed), "duration": "0", "seed": str(seed), "duty": "program", "program": "identification",
        "observers": "unified", "model_monitor": "true", "params_file": str(rules), **paced,
    }  # fmt: skip
    done, wrong = threading.Event(), list[BaseException]()

    def stopping() -> str:
        return "the demonstration is over" if done.is_set() or live.over.is_set() else ""

    def go() -> None:
        try:
            with (live.out / f"{name}.log").open("w", encoding="utf-8") as stream:
                run(arguments, stream, stopping)
        except BaseException as error:
            wrong.append(error)
            desk.refused = " ".join(str(error).split()) or type(error).__name__

    thread = threading.Thread(target=go, name=name)
    thread.start()
    try:
        yield
    finally:
        done.set()
        thread.join()
    if wrong:
        raise wrong[0]


def show(acts: list[Act], console: Console) -> None:
    """What was hidden, what was found, and the live errors; in Markdown."""
    table = Table(title="live error of the monitor's model", box=box.MARKDOWN)
    for column in ("hidden", "found", "before [N]", "after [N]", "ok"):
        table.add_column(column)
    for act in acts:
        words = (act.hidden, act.found, f"{act.before:.3f}", f"{act.after:.3f}")
        table.add_row(*words, "yes" if act.success else "NO")
    console.print(table)


def has_browser() -> bool:
    """Whether there is a screen that a browser could show a page on."""
    return any(os.environ.get(name) for name in ("DISPLAY", "WAYLAND_DISPLAY"))
