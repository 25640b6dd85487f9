"""Plan the run that would tell two effects apart, or reveal one, within the limits of the rig."""

from __future__ import annotations

from concurrent.futures import Executor
from dataclasses import asdict, replace
from typing import Any

from er_common.command_line import command_line
from er_common.versions import versions
from er_models.errors import InputError
from er_models.model import Model
from er_records.dataset import Dataset
from er_records.load import fingerprint

from er_model_lab.blas import on_one_thread
from er_model_lab.fitting.velocity_channel import on_fused
from er_model_lab.level.damper import opened
from er_model_lab.planning.limits import Asked, Limits, limits_of, sensors_of
from er_model_lab.planning.planner import planned
from er_model_lab.planning.present import plan_json, plan_view, proposed
from er_model_lab.planning.question import Question, ask
from er_model_lab.problem.problem import Problem
from er_model_lab.results.result import PlanResult
from er_model_lab.results.values import clean
from er_model_lab.span.span import noted
from er_model_lab.verbs.asking import question
from er_model_lab.work import Event, Progress, Work


@on_one_thread
def plan(
    model: Model,
    *,
    between: tuple[str, ...] = (),
    reveal: str | None = None,
    data: Dataset | None = None,
    vehicle: Model | None = None,
    stroke: float | None = None,
    velocity: float | None = None,
    duty_max: float | None = None,
    duration: float | None = None,
    name: str = "next",
    seed: int = 0,
    anyway: bool = False,
    progress: Progress | None = None,
    cancel: Event | None = None,
    executor: Executor | None = None,
) -> PlanResult:
    """Plan the experiment; data: what is already measured, effects are then as strong as they are fitted to it.

    vehicle: the car that holds the damper, where the model is a damper alone; stroke [m], velocity [m/s], duty_max [1],
    duration [s]: limits of the rig, where they are not those of the model.
    """
    given = on_vehicle(model, vehicle)
    base = on_fused(given)
    asked = ask(base, between, reveal)
    within = limits_of(base, Asked(stroke, velocity, duty_max, duration), Limits.dt)
    problem, known = (None, {}) if data is None else _measured(data, asked, given, seed, anyway)
    if problem is not None:
        # finer than the rig's own rate is not planned: it would only take longer
        within = replace(within, dt=max(problem.motion.dt, Limits.dt))
    sensors, noise_source = sensors_of(base, problem)
    how = Work.by(executor, progress, cancel)
    found = planned(asked, within, sensors, problem=problem, seed=seed, work=how)
    origin = known.pop("provenance", {}) | _origin(base, model, seed)
    content = plan_json(found, noise_source) | known
    content |= {
        "program_file": None,
        "notes": _notes(found.bench.car, noise_source, problem),
        "complete": problem is None or problem.complete,
        "provenance": origin,
    }
    view = plan_view(found, clean(content), origin)
    program = proposed(found, name, _source(asked, seed)) if found.finalists else None
    return PlanResult(view, program=program)


def on_vehicle(model: Model, vehicle: Model | None) -> Model:
    """The model, its damper put into a vehicle where one is given.

    Raises:
        InputError: The vehicle holds no quarter car.
    """
    if vehicle is None:
        return model
    if not vehicle.is_vehicle:
        raise InputError(
            vehicle.file or vehicle.name, "quarter_car", "a vehicle model with quarter_car", "a damper only"
        )  # fmt: skip
    parts = {k: v for k, v in vehicle.effects.items() if vehicle.catalogue[k].stage == "vehicle"}
    return replace(model, effects={**model.effects, **parts}, rig=model.rig or vehicle.rig)


def _measured(
    data: Dataset, asked: Question, given: Model, seed: int, anyway: bool
) -> tuple[Problem, dict[str, Any]]:
    """What is already measured, and what the result holds of it.

    given: the model with the lag and gain of its velocity channel, which are undone in the data.
    """
    searched = question(data, given, seed=seed, anyway=anyway).data
    found = opened(searched, given)
    left = found.problem.force - found.problem.predict(on_fused(asked.base))
    whole = found.span.checked(found.problem, left, given=asked.base)
    records = searched.originals
    known: dict[str, Any] = {
        "provenance": {"data": fingerprint(records), "records": [r.name for r in records]}
    }
    if whole is not None:
        known["long"] = whole.as_json(again=False)
    return noted(found.problem, whole), known


def _source(asked: Question, seed: int) -> str:
    """What the program is for, as its file says it."""
    names = " or ".join(asked.names) if asked.second else f"{asked.first} or not"
    return f"lab plan: {names}, model {asked.base.name}, seed {seed}"


def _notes(car: bool, noise_source: str, problem: Problem | None) -> list[str]:
    """What to know before the program is run."""
    notes = [] if problem is None else list(problem.notes)
    if not car:
        notes.append(
            "the model holds no vehicle: the program imposes the deflection (minus its road) in a test machine; "
            "with a vehicle beside it a road is planned"
        )
    if noise_source.startswith("assumed"):
        notes.append(f"noise of the sensors {noise_source}")
    return notes


def _origin(base: Model, given: Model, seed: int) -> dict[str, Any]:
    """Where the plan comes from."""
    return {
        "model_file": given.file, "model": base.digest(), "seed": seed, "versions": versions(),
        "command_line": command_line(),
        "effects_from": {name: asdict(o) for name, o in base.catalogue.origins.items()},
    }  # fmt: skip
