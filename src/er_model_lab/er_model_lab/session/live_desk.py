"""A desk beside a running graph: it learns from what was heard last, and the graph's monitor goes by what it learnt."""

from __future__ import annotations

import os
import threading
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
from er_models.errors import ErError, InputError
from er_models.model import Model
from er_models.program import save_program
from er_records.dataset import Dataset
from er_records.in_memory import from_arrays
from er_records.write import write_csv

from er_model_lab.live.coverage import Shown, carries, coverage
from er_model_lab.live.heard import MINUTES, Heard
from er_model_lab.live.link import Link
from er_model_lab.live.planned_run import PlannedRun
from er_model_lab.monitor.learner import kept
from er_model_lab.session.desk import Desk, loaded
from er_model_lab.session.sight import Selection
from er_model_lab.session.steps import Source
from er_model_lab.verbs.load import load_model

FAILS = "fails"
"""Mode of a monitor whose model does not explain any more."""
LEAST = 10.0
"""Time below which nothing is learnt from what was heard [s]."""
AFTER_ALARM = 20.0
"""How long after an alarm's beginning is listened before it is learnt from [s]."""
LOOK = 2.0
"""Time of the drive between two looks at what it shows [s]."""
AGAIN = 1.5
"""By how much the data grow before the next attempt by itself."""
UNDECIDED = ("insufficient_data", "ambiguous")
GENTLY = 19
"""Niceness of a job: the loop goes first."""

Connect = Callable[[str, Callable[[dict[str, Any]], None]], Link]


class LiveDesk(Desk):
    """A desk that hears a graph.

    heard: of the graph; shown: what the drive shows; status: of the monitor; running: its model; refused: why the last
    thing asked for was not done; gone: why nobody listens any more; alone: whether the graph is silent; follow: whether
    the plots show the graph, else what was learnt from; by_itself: whether it diagnoses when the data carry a verdict;
    observers: whether those of the graph go over with the monitor; run: the planned run that was asked for last.
    """

    def __init__(
        self, folder: Path, namespace: str, *, models: Path = Path("models"), minutes: float = MINUTES,
        seed: int = 0, connect: Connect = Link, niceness: int = GENTLY,
    ) -> None:  # fmt: skip
        """models: folder for models that the monitor is given; connect: who listens; niceness: of what jobs compute."""
        super().__init__(folder, seed=seed)
        self.heard, self.shown, self.models = Heard(minutes), list[Shown](), models
        self.niceness = niceness
        self.status: dict[str, str] = {}
        self.running, self.refused, self.gone = "", "", ""
        self.follow = self.by_itself = True
        self.observers = False
        self.run: PlannedRun | None = None
        self.alone = True
        self._looked, self._next, self._number, self._runs, self._given = 0.0, 0.0, 0, 0, ""
        self.link = connect(namespace, self.word)
        self.namespace = namespace

    def word(self, content: dict[str, Any]) -> None:
        """Take a word of the process that listens."""
        try:
            for kind, value in content.items():
                getattr(self, f"_on_{kind}")(value)
        except ErError as error:  # who listens goes on
            self.refused = " ".join(str(error).split())
            self.changed()

    def _on_rows(self, rows: list[Any]) -> None:
        under_way = self.driving
        self.heard.add(rows)
        if under_way and not self.driving:
            self._driven()
        if self.heard.now - self._looked >= LOOK:
            self._looked = self.heard.now
            channels = self.heard.channels()
            self.shown = coverage(channels, self.now.model) if "deflection" in channels else []
            if self.by_itself and self.due():
                self.learn()

    def _on_again(self, _: int) -> None:
        """Another drive."""
        self.heard.clear()
        self.shown, self._looked, self._next, self.run = [], 0.0, 0.0, None

    def _on_status(self, status: dict[str, str]) -> None:
        before, self.status = self.status, status
        if (before.get("mode") == FAILS) != (status["mode"] == FAILS):
            self.heard.mark("alarm" if status["mode"] == FAILS else "explains")
            self._next = 0.0
        if before != status:
            self.changed()

    def _on_model(self, path: str) -> None:
        """What the monitor goes by is what the session begins with, where nobody said otherwise."""
        self.running = Path(path).stem
        if self.now.model is None:
            self.bring((), load_model(path, self.code_files), path)

    def _on_used(self, answer: dict[str, Any]) -> None:
        self.refused = "" if answer["accepted"] else str(answer["reason"])
        if answer["accepted"]:
            self.running, self.heard.since = Path(answer["model"]).stem, self.heard.now
            self.heard.mark(self._given)
        self.changed()

    def _on_ran(self, answer: dict[str, Any]) -> None:
        """What came of a planned run, or of the wish to end it."""
        run, node, reason = self.run, str(answer["node"]), str(answer["reason"])
        if run is None:
            return
        if answer["run"]:
            self.run = replace(run, node=node, reason=reason, begin=self.heard.now)
            if self.run.accepted:
                self.heard.mark("planned run")
        elif not reason and run.under_way(self.heard.now):
            driven = min(max(run.driven(self.heard.now), 0.0), run.program.duration)
            self.run = replace(run, program=replace(run.program, duration=driven))
        else:
            self.refused = reason
        self.changed()

    def _driven(self) -> None:
        """The run is over: what was heard until now has what it was planned for."""
        self.heard.mark("run over")
        self.changed()
        if self.by_itself and not self.jobs.running and self.now.model is not None:
            self.learn()

    def _on_alone(self, alone: bool) -> None:
        self.alone = alone
        self.changed()

    def _on_ended(self, why: str) -> None:
        self.gone = why
        self.changed()

    @property
    def failing(self) -> bool:
        """Whether the monitor says that its model does not explain any more."""
        return self.status.get("mode") == FAILS

    @property
    def driving(self) -> bool:
        """Whether the graph drives a planned run."""
        return self.run is not None and self.run.under_way(self.heard.now)

    @property
    def since(self) -> float:
        """From when on is learnt: where an alarm began, else all that is remembered [s]."""
        return self.heard.began() if self.failing else float("-inf")

    def due(self) -> bool:
        """Whether it is time to diagnose: the data carry a verdict, and there is none for the model in use."""
        if self.jobs.running or self.now.model is None:
            return False
        if self.heard.now < self._next or self.heard.seconds < LEAST:
            return False
        if self.failing:
            return self.heard.now - self.since >= AFTER_ALARM
        verdict = self.result.verdict if self.result else UNDECIDED[0]
        return verdict in UNDECIDED and carries(self.shown)

    def gathering(self, *, anew: bool = True) -> Callable[[], Dataset]:
        """What was heard becomes data of the session, in a file that a session's program can name."""
        if self.records and not anew:
            return super().gathering()
        channels = self.heard.channels(self.since)
        t = channels.get("t", np.zeros(0))
        if t.size < 2 or t[-1] - t[0] < LEAST or "damper_force" not in channels:
            heard = f"{t[-1] - t[0] if t.size else 0.0:.0f} s"
            raise InputError("live", "", f"{LEAST:g} s of motion with a force", heard)
        self._next = AGAIN * self.heard.now

        def gather() -> Dataset:
            gently(self.niceness)
            self._number += 1
            path = self.folder / f"heard_{self._number}.csv"
            self.folder.mkdir(exist_ok=True)
            write_csv(from_arrays(name=path.stem, **channels).records[0], path)  # type: ignore[arg-type]
            self._learn_from(Source(path))
            return self.data

        return gather

    def _learn_from(self, source: Source) -> None:
        records = loaded([source])
        self.session = self.session.then(self.now.with_data([source]))
        self.records, self.selection = records, Selection()
        self._open()

    def learnt(self, model: Model) -> None:
        """The monitor goes by what was learnt, from a file that was not there."""
        self._given = self.now.step.says
        self.link.use(kept(model, model.name, self.models), observers=self.observers)

    def give(self) -> None:
        """Have the monitor go by the model that is shown."""
        self.learnt(self.now.known)

    def drive(self) -> None:
        """Have the graph drive the planned run now, from a file of its own: `run` says what comes of it.

        Raises:
            InputError: Nothing was planned.
        """
        program = self.planned.program if self.planned is not None else None
        if program is None:
            raise InputError("run", "", "a run that was planned: diagnose, then plan", "none yet")
        self._runs += 1
        path = self.folder / f"planned_{self._runs}.yaml"
        self.folder.mkdir(exist_ok=True)
        save_program(program, path)
        self.run = PlannedRun(program)
        self.link.run(str(path.absolute()))
        self.changed()

    def end_run(self) -> None:
        """Have the graph end it."""
        self.link.run("")

    def shut(self) -> None:
        """Listen no more."""
        super().shut()
        self.link.stop()


def gently(niceness: int) -> None:
    """This thread, and what it starts, is as nice to others, or nicer: it has what a loop leaves of the machine."""
    me = threading.get_native_id()
    os.setpriority(os.PRIO_PROCESS, me, max(niceness, os.getpriority(os.PRIO_PROCESS, me)))
