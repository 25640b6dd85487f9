"""`lab plan`, apart from how it is called."""

from __future__ import annotations

from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from er_models.errors import InputError
from er_models.model import Model
from er_models.program import save_program

from er_model_lab.blas import on_one_thread
from er_model_lab.command_line import command_line
from er_model_lab.diagnosis.study import as_given, open_problem
from er_model_lab.fitting.velocity_channel import on_fused
from er_model_lab.long.check import told
from er_model_lab.plan.limits import Asked, Limits, limits_of, sensors_of
from er_model_lab.plan.planner import plan
from er_model_lab.plan.present import plan_json, plan_view, proposed
from er_model_lab.plan.question import Question, ask
from er_model_lab.problem.problem import Problem
from er_model_lab.records.load import fingerprint
from er_model_lab.records.record import originals
from er_model_lab.results.values import clean
from er_model_lab.verbs.ask import Outcome, Request, read
from er_model_lab.versions import versions
from er_model_lab.work import HERE, Work


@dataclass(frozen=True)
class Wanted:
    """Effects to tell apart (`between`) or one to `reveal`, the vehicle, limits, and where to write."""

    between: tuple[str, ...]
    reveal: str | None
    vehicle: Path | None
    limits: Asked
    out: Path | None


@on_one_thread
def run(request: Request, wanted: Wanted, work: Work = HERE) -> Outcome:
    """Plan the experiment; request.data may be empty."""
    given = _on_vehicle(request, wanted.vehicle)
    model = on_fused(given)
    question = ask(model, wanted.between, wanted.reveal)
    limits = limits_of(model, wanted.limits, Limits.dt)
    problem, origin, long = measurements(request, question, given)
    if (
        problem is not None
    ):  # finer than the rig's own rate is not planned: it would only take longer
        limits = replace(limits, dt=max(problem.motion.dt, Limits.dt))
    sensors, noise_source = sensors_of(model, problem)
    found = plan(question, limits, sensors, problem=problem, seed=request.seed, work=work)
    result = plan_json(found, noise_source) | long
    result["program_file"] = None
    if wanted.out is not None and found.finalists:
        save_program(proposed(found, wanted.out.stem, _source(question, request)), wanted.out)
        result["program_file"] = str(wanted.out)
    result["notes"] = _notes(found.bench.car, noise_source, problem)
    result["complete"] = problem is None or problem.complete
    result["provenance"] = origin | _origin(model, request)
    result = clean(result)
    view = plan_view(found, result, result["provenance"])
    return Outcome(result, view, None, bool(result["complete"]))


def _on_vehicle(request: Request, vehicle: Path | None) -> Model:
    """The model, its damper put into a vehicle where one is given."""
    model = request.model()
    if vehicle is None:
        return model
    car = replace(request, model_file=vehicle).model()
    if not car.is_vehicle:
        raise InputError(
            vehicle, "quarter_car", "a vehicle model with quarter_car", "a damper only"
        )
    parts = {k: v for k, v in car.effects.items() if car.catalogue[k].stage == "vehicle"}
    return replace(model, effects={**model.effects, **parts}, rig=model.rig or car.rig)


def measurements(
    request: Request, question: Question, given: Model
) -> tuple[Problem | None, dict[str, Any], dict[str, Any]]:
    """What is already measured, if anything is; where it comes from; and for the JSON what was used of long data.

    given: the model with the lag and gain of its velocity channel, which are undone in the data.
    """
    if not request.data:
        return None, {}, {}
    records, _ = read(request)
    problem, _ = open_problem(records, given)
    problem, long = told(problem, as_given(question.base, problem), given=question.base)
    data = originals(records)
    return problem, {"data": fingerprint(data), "records": [r.name for r in data]}, long


def _source(question: Question, request: Request) -> str:
    """What the program is for, as its file says it."""
    names = " or ".join(question.names) if question.second else f"{question.first} or not"
    return f"lab plan: {names}, model {question.base.name}, seed {request.seed}"


def _notes(car: bool, noise_source: str, problem: Problem | None) -> list[str]:
    """What to know before the program is run."""
    notes = [] if problem is None else list(problem.notes)
    if not car:
        notes.append(
            "the model holds no vehicle: the program imposes the deflection (minus its road) in a test machine; "
            "--vehicle FILE plans a road"
        )
    if noise_source.startswith("assumed"):
        notes.append(f"noise of the sensors {noise_source}")
    return notes


def _origin(model: Model, request: Request) -> dict[str, Any]:
    """Where the plan comes from."""
    return {
        "model_file": str(request.model_file), "model": model.digest(), "seed": request.seed,
        "versions": versions(), "command_line": command_line(),
        "effects_from": {name: asdict(o) for name, o in model.catalogue.origins.items()},
    }  # fmt: skip
