"""Times of the lab's commands, from the file to the model, in wall and in processor time."""

from __future__ import annotations

import resource
import tempfile
import time
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

from er_model_lab.diagnosis.investigation import search_effects
from er_model_lab.fitting.fit import fit
from er_model_lab.level.damper import opened
from er_model_lab.problem.forward import DamperForward
from er_model_lab.problem.motion_error import Sensed
from er_model_lab.problem.problem import Problem
from er_model_lab.verbs.diagnose import diagnose
from er_model_lab.verbs.improve import improve
from er_model_lab.verbs.load import load
from er_models.effect import Effect
from er_models.files import load_model, save_model
from er_models.model import Array, Model
from er_models.prediction import predict_many
from er_records.dataset import Dataset
from er_records.write import write_parquet

from er_studies.bench.lab.data import record

MINUTE = 60.0
LENGTHS = (15.0, 30.0, 60.0, 120.0, 240.0, 1200.0, 3600.0)
NUMBERS = (4, 8, 16, 24)
BEGUN, OFF, TURNS = 10.0, 0.8, 10
"""Length of a record whose beginning is told [s], values of its effect that a fit begins with over the true ones, and
how often both ways are timed."""
STATES = (
    "bouc_wen_hysteresis", "viscoelastic_branch", "friction_with_play", "freeplay", "self_heating", "remanence",
)  # fmt: skip
"""Effects whose states begin somewhere."""


@dataclass(frozen=True)
class Line:
    """One measurement: what; n of whatever is varied; wall and processor time [s]; what was found; peak memory [GB]."""

    what: str
    n: float
    wall: float
    processor: float
    found: str
    memory: float


@dataclass(frozen=True)
class Few(DamperForward):
    """The force of the damper, with only the first effects of the catalogue as candidates."""

    number: int

    def candidates(self, model: Model) -> tuple[Effect, ...]:
        """So many of them, the hidden one among them."""
        every = sorted(super().candidates(model), key=lambda e: e.name != "coulomb_friction")
        return tuple(every[: self.number])


class Assumed(DamperForward):
    """The force of the damper, whose states begin settled."""

    def predict_many(self, data: Sensed, model: Model, vectors: Array) -> Array:
        """Forces (m, n), whatever the measured force says of the beginning."""
        return self._complete(predict_many(model, vectors, data.motion, longest=self.longest))

    def _looked(self, data: Sensed, model: Model) -> tuple[Array | None, DamperForward]:
        """Itself: nothing is looked for."""
        del data, model
        return None, self

    def beginnings(self, data: Sensed, model: Model) -> float:
        """None."""
        del data, model
        return 0.0


def timed(what: str, n: float, work: Callable[[], str]) -> Line:
    """One run."""
    wall, processor = time.perf_counter(), time.process_time()
    found = work()
    wall, processor = time.perf_counter() - wall, time.process_time() - processor
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024 / 1e9
    return Line(what, n, wall, processor, found, peak)


def minute(model_file: Path, *, seconds: float = MINUTE) -> list[Line]:
    """Diagnosis and improvement of a minute at 200 Hz over the full catalogue, null included; the first warms up."""
    with tempfile.TemporaryDirectory() as name:
        file, out = _written(model_file, seconds, Path(name)), Path(name) / "better.yaml"
        _diagnosed(file, model_file)
        return [
            timed("diagnose", seconds, lambda: _diagnosed(file, model_file)),
            timed("improve", seconds, lambda: _improved(file, model_file, out)),
        ]


def length(model_file: Path, *, lengths: tuple[float, ...] = LENGTHS) -> list[Line]:
    """Diagnosis of ever longer records; the memory is the peak of the process so far."""
    lines = []
    with tempfile.TemporaryDirectory() as name:
        _diagnosed(_written(model_file, lengths[0], Path(name)), model_file)
        for seconds in lengths:
            work = partial(_diagnosed, _written(model_file, seconds, Path(name)), model_file)
            lines.append(timed(f"{seconds:g} s", seconds, work))
    return lines


def number(
    model_file: Path, *, seconds: float = MINUTE, numbers: tuple[int, ...] = NUMBERS
) -> list[Line]:
    """The search in a minute with ever more candidates, and with all."""
    model = load_model(model_file)
    problem = opened(Dataset.of([record(model, seconds)]), model).problem
    every = len(problem.forward.candidates(model))
    lines: list[Line] = []
    for n in (*(k for k in numbers if k < every), every):
        few = Few(n)

        def work(few: Few = few) -> str:
            return " ".join(search_effects(model, replace(problem, forward=few)).effects)

        if not lines:
            work()
        lines.append(timed(f"{n} effects", n, work))
    return lines


def beginnings(model_file: Path, *, seconds: float = MINUTE) -> list[Line]:
    """Fits of models with states, where these are found at the beginning of each record and where they are assumed.

    Records of ten seconds begin in motion; n: ratio of the processor times, each the shortest of some that take turns.
    """
    model, lines = load_model(model_file), list[Line]()
    for name in STATES:
        hidden = model.with_effect(name)
        records = [
            replace(record(model, BEGUN, seed=k, damper=hidden), name=f"bench {k}")
            for k in range(max(round(seconds / BEGUN), 1))
        ]
        found = opened(Dataset.of(records), model).problem
        ways = {"found": found, "assumed": replace(found, forward=Assumed())}
        grown = hidden.with_effect(name, {k: OFF * v for k, v in hidden.effects[name].items()})
        times: dict[str, list[Line]] = {way: [] for way in ways}
        for _ in range(TURNS + 1):  # the first warms up
            for way, problem in ways.items():
                work = partial(_fitted, grown, problem)
                times[way].append(timed(f"{name}, states {way}", seconds, work))
        told, plain = (min(t[1:], key=lambda line: line.processor) for t in times.values())
        ratio = told.processor / plain.processor
        lines += [
            replace(told, n=ratio, found=f"{ratio:.2f} times that with states assumed"),
            plain,
        ]
    return lines


def _fitted(model: Model, problem: Problem) -> str:
    """What a fit leaves."""
    return f"{fit(model, problem).mse(problem.train) ** 0.5:.3g} N"


def _written(model_file: Path, seconds: float, folder: Path) -> Path:
    """So many seconds of data in a file."""
    path = folder / f"{seconds:g}.parquet"
    write_parquet(record(load_model(model_file), seconds), path)
    return path


def _diagnosed(data: Path, model_file: Path) -> str:
    """What the diagnosis says."""
    result = diagnose(load(data), load_model(model_file))
    return " ".join((result.verdict, *result.effects))


def _improved(data: Path, model_file: Path, out: Path) -> str:
    """The effects of the new model, which is written."""
    result = improve(load(data), load_model(model_file), name=out.stem)
    assert result.model is not None
    save_model(result.model, out)
    return " ".join(result.effects)
