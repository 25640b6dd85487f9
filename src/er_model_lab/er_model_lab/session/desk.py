"""The desk that a page shows: one session with its data, what is seen, and the work; every page shows the same one."""

from __future__ import annotations

import threading
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

from er_models.errors import ErError, InputError
from er_models.measured import is_term
from er_models.model import Array, Model
from er_records.dataset import Dataset
from er_records.record import Record

from er_model_lab.results.records import Errors
from er_model_lab.results.result import DiagnosisResult, PlanResult
from er_model_lab.session import dropped
from er_model_lab.session.fall import Stage, fall, fallen
from er_model_lab.session.job import Jobs
from er_model_lab.session.sight import Selection, Sight, look
from er_model_lab.session.steps import (
    SHORTEST,
    Session,
    Source,
    State,
    Step,
    Stretch,
    divided,
    joined,
)
from er_model_lab.work import Progress

BIGGEST = 4 * dropped.LARGEST
"""Most bytes of all dropped files together."""


class Desk:
    """One session and what belongs to it.

    beside: which of `choice` is laid beside the model that is shown; brought: models by the names of their files.
    folder: where dropped files are kept; given: paths that were named on the command line; code: whether dropped
    Python files may run. Work of more than a few milliseconds is a job; all else is done where it is called.
    """

    def __init__(
        self, folder: Path, *, given: Sequence[Path] = (), seed: int = 0, code: bool = False
    ) -> None:
        self.folder, self.given, self.code = folder, tuple(given), code
        self.session, self.selection = Session(seed=seed), Selection()
        self.records: tuple[Record, ...] = ()
        self.sight: Sight | None = None
        self.predicted: Array | None = None
        self.result: DiagnosisResult | None = None
        self.planned: PlanResult | None = None
        self.beside = ""
        self.brought: dict[str, Model] = {}
        self.code_files: tuple[Path, ...] = ()
        self.revision = self.progress = 0
        self.jobs = Jobs(self._went_on)
        self._lock = threading.RLock()

    def changed(self) -> None:
        """Say that there is something new to show."""
        self.revision += 1

    def _went_on(self) -> None:
        """Say that a job went on, which draws no plot anew; at its end there may be something new to show."""
        self.progress += 1
        if not self.jobs.running:
            self.changed()

    @property
    def now(self) -> State:
        """The state that is shown."""
        return self.session.now

    @property
    def residual(self) -> Array | None:
        """Measured minus predicted force (n,) [N]."""
        return (
            None
            if self.sight is None or self.predicted is None
            else self.sight.force - self.predicted
        )

    @property
    def choice(self) -> dict[str, Model]:
        """What may be laid beside the model that is shown: models of the steps, and those that were brought."""
        steps = (*self.session.past, *self.session.future)
        told = {f"{k}. {s.step.says}": s.model for k, s in enumerate(steps) if s.model is not None}
        return told | self.brought

    def lay(self, name: str | None) -> None:
        """Lay a model beside the one that is shown: one of `choice`, a shipped one, or none.

        Raises:
            InputError: No such model.
        """
        from er_model_lab.verbs.load import load_model

        if name and name not in self.choice:
            self.brought |= {name: load_model(name, self.code_files)}
        self.beside = name or ""
        self.changed()

    @property
    def laid(self) -> Array | None:
        """What the model beside predicts (n,) [N]; None where there is none, or none along this motion."""
        sight, model = self.sight, self.choice.get(self.beside)
        return sight.predicted(model) if sight and model and sight.fits(model) else None

    @property
    def data(self) -> Dataset:
        """The data of the session.

        Raises:
            InputError: There are none yet.
        """
        if not self.records:
            raise InputError("data", "", "measurements: drop a file", "none")
        return divided(self.records, self.now.held)

    def take(self, state: State) -> None:
        """Go one step further; what does not fit the sight any more is looked at anew, in a job.

        Raises:
            InputError: A job is at work that needs the session as it is.
        """
        self._may_change(state.step.says)
        self._show(self.session.then(state))

    def undo(self) -> None:
        """One step back."""
        self.go(self.session.undone())

    def redo(self) -> None:
        """One step forward."""
        self.go(self.session.redone())

    def go(self, session: Session) -> None:
        """Another place among the steps."""
        self._may_change("a step back")
        self._show(session)

    def _may_change(self, what: str) -> None:
        if self.jobs.running:
            raise InputError(
                what,
                "",
                "nothing is changed while a job runs: wait, or cancel it",
                "a running job",
            )

    def _show(self, session: Session) -> None:
        """Show a session: at once where the data are open for its model, else by a job."""
        before, self.session = self.now, session
        same = (before.sources, before.held) == (self.now.sources, self.now.held)
        if (
            same
            and self.now.model is not None
            and self.sight is not None
            and self.sight.fits(self.now.model)
        ):
            self._predict(self.sight)
        else:
            fresh = before.sources != self.now.sources
            self.jobs.start("open the data", lambda *_: self._open(fresh=fresh))
        self.changed()

    def _predict(self, sight: Sight) -> None:
        with self._lock:
            self.sight, self.predicted = sight, sight.predicted(self.now.known)

    def _open(self, *, fresh: bool = False) -> None:
        """Load the data of the session where they are not there, and open them for its model."""
        with self._lock:  # what is shown is never of other data, also where these cannot be opened
            self.sight = self.predicted = None
        if fresh:
            self.records, self.selection = loaded(self.now.sources), Selection()
        if self.records and self.now.model is not None:
            self._predict(look(self.data, self.now.model, whole=self.records))
        self.changed()

    def bring(
        self, sources: Sequence[Source], model: Model | None = None, origin: str = ""
    ) -> None:
        """Other data, or another model, as a job that reads them; what cannot be read changes nothing."""

        def work(*_: Any) -> None:
            state = self.now
            if tuple(sources) != state.sources:
                records = loaded(sources)
                state = state.with_data(sources)
                self.session, self.records, self.selection = (
                    self.session.then(state),
                    records,
                    Selection(),
                )
            if model is not None:
                self.brought |= {Path(origin).name or model.name: model}
                self.session = self.session.then(
                    state.started(model, origin or model.name, self.code_files)
                )
            self.result = None
            self._open()

        self.jobs.start("open the data", work)

    def new(self, kind: str) -> None:
        """A start model of a kind, scaled to the data, as a job."""
        from er_model_lab.verbs.new import new

        data = self.data

        def work(*_: Any) -> None:
            self.session = self.session.then(self.now.scaled(new(data, kind, anyway=True), kind))
            self.result = None
            self._open()

        self.jobs.start("open the data", work)

    def hold(self, held: Sequence[Stretch]) -> None:
        """Hold other stretches out.

        Raises:
            InputError: Nothing would be left to learn from.
        """
        self.take(self.now.with_held(held, self.records))

    def hold_between(self, begin: float, end: float) -> None:
        """Hold out what lies between two common times [s], too.

        Raises:
            InputError: Less than what is held out at least, none of a record, or nothing left to learn from.
        """
        self._may_change("hold out")
        parts = {p.name: p for p in self.sight.parts} if self.sight is not None else {}
        new = [
            cut for k, record in enumerate(self.records) if record.name in parts
            for cut in [parts[record.name].stretch(k, record, begin, end)] if cut.end - cut.start >= SHORTEST
        ]  # fmt: skip
        if not new:
            raise InputError(
                "held_out", "", f"at least {SHORTEST:g} s of a record", f"{end - begin:.3g} s"
            )
        self.hold(joined((*self.now.held, *new)))

    def errors(self, model: Model | None = None) -> Errors | None:
        """Errors of a model, by default of the one that is shown; None where nothing is predicted."""
        sight = self.sight
        if sight is None or self.predicted is None:
            return None
        if model is None:
            return sight.errors(sight.force - self.predicted)
        return sight.errors(sight.force - sight.predicted(model)) if sight.fits(model) else None

    def fall(self) -> list[Stage]:
        """The errors of the model as given and with everything that was added, and of what was set since."""
        return fall(self.session, self.errors)

    def learn(self) -> None:
        """Diagnose, as a job."""
        from er_model_lab.verbs.diagnose import diagnose

        gather, model, seed = self.gathering(), self.now.known, self.session.seed

        def work(progress: Progress, cancel: threading.Event) -> None:
            self.result = diagnose(
                gather(), model, seed=seed, anyway=True, progress=progress, cancel=cancel
            )

        self.result = None
        self.jobs.start("diagnose", work)

    def gathering(self, *, anew: bool = True) -> Callable[[], Dataset]:
        """What a job calls for the data that it is to learn from; raises as `data`.

        anew: what has come since counts, too, where data come by themselves.
        """
        del anew  # here none do
        data = self.data
        return lambda: data

    def learnt(self, model: Model) -> None:
        """A job has made another model, which is the one of the session now."""

    def add(self, effect: str) -> None:
        """Add an effect and refit everything, as a job."""
        from er_model_lab.verbs.add import add

        gather = self.gathering(anew=False)
        self._fit(Step("add", effect), lambda **how: add(gather(), self.now.known, effect, **how))

    def take_back(self, name: str) -> None:
        """Take an effect or a measured term out again and refit everything else, as a job."""
        from er_model_lab.verbs.add import refit

        gather, model = self.gathering(anew=False), self.now.known
        less = model.without_term(name) if is_term(name) else model.without_effect(name)
        step, seed = Step("back", name), self.session.seed

        def work(progress: Progress, cancel: threading.Event) -> None:
            made = refit(gather(), less, seed=seed, anyway=True, progress=progress, cancel=cancel)
            self._made(made, step)

        self.jobs.start(step.says, work)

    def improve(self, *, measured_terms: bool = False) -> None:
        """Add until nothing more is found, as a job."""
        from er_model_lab.verbs.improve import improve

        step = Step("improve", "", {"measured_terms": True} if measured_terms else {})
        gather = self.gathering()
        self._fit(
            step,
            lambda **how: improve(gather(), self.now.known, measured_terms=measured_terms, **how),
        )

    def plan(self, *, between: tuple[str, ...] = (), reveal: str | None = None) -> None:
        """Plan the run that tells two effects apart, or shows one, as a job."""
        from er_model_lab.verbs.plan import plan

        data, model, seed = self.data, self.now.known, self.session.seed

        def work(progress: Progress, cancel: threading.Event) -> None:
            self.planned = plan(
                model, between=between, reveal=reveal, data=data, seed=seed, anyway=True,
                progress=progress, cancel=cancel,
            )  # fmt: skip

        self.planned = None
        self.jobs.start("plan", work)

    def _fit(self, step: Step, verb: Callable[..., DiagnosisResult]) -> None:
        def work(progress: Progress, cancel: threading.Event) -> None:
            result = verb(seed=self.session.seed, anyway=True, progress=progress, cancel=cancel)
            if result.interrupted or result.model is None:
                raise ErError("cancelled: the model stays as it was")
            self.result = result
            way = {"fall": fallen(result)} if step.kind == "improve" else {}
            self._made(result.model, replace(step, values={**step.values, **way}))

        self.jobs.start(step.says, work)

    def _made(self, model: Model, step: Step) -> None:
        """What a fit made is the model of the session."""
        self.session = self.session.then(self.now.learnt(model, step))
        sight = self.sight
        if sight is None or not sight.fits(model):
            sight = look(self.data, model, whole=self.records)
        self._predict(sight)
        self.learnt(model)

    def admitted(self, name: str, size: int) -> str:
        """The kind of a file of this name and size [bytes] that may be dropped.

        Raises:
            InputError: It is too large, alone or with all that was dropped, or of no kind that may.
        """
        kind, most = dropped.kind_of(name, code=self.code), min(dropped.LARGEST, self.room())
        if size > most:
            raise InputError(
                name, "", f"at most {max(most, 0) / 1e6:.4g} MB more", f"{size / 1e6:.4g} MB"
            )
        return kind

    def room(self) -> int:
        """How many more bytes may be dropped."""
        return BIGGEST - sum(f.stat().st_size for f in self.folder.rglob("*") if f.is_file())

    def shut(self) -> None:
        """End what is running."""
        self.jobs.cancel()
        self.jobs.wait(2.0)


def loaded(sources: Sequence[Source]) -> tuple[Record, ...]:
    """The records of all sources."""
    from er_records.load import load, told_apart

    return tuple(told_apart([r for s in sources for r in load([s.path], s.names)]))


def with_source(state: State, source: Source) -> tuple[Source, ...]:
    """The sources of a state with one more, or with other names of one of them."""
    others = [s for s in state.sources if s.path != source.path]
    return (*others, replace(source))
