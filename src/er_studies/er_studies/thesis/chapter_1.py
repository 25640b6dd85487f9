"""Chapter 1 of the thesis: both damper models identified as in section 1.5, and the four cases of section 1.6.

The real damper is not at hand. A vehicle model whose damper holds more than the models can stands in for it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from pathlib import Path

import numpy as np
from er_model_lab.identification import Identified, procedure
from er_model_lab.identification.roles import static
from er_model_lab.problem.held_out import WARM_UP
from er_model_lab.problem.prepare import prepare
from er_model_lab.work import Work
from er_models.files import load_model
from er_models.model import Array, Model
from er_models.prediction import Motion, motion, predict
from er_models.program import load_program
from er_models.scales import Scales
from er_records.dataset import Dataset
from er_records.record import Record
from numpy.typing import NDArray

from er_studies.thesis.testbench import measure

LAWS = {
    "bingham": ("passive_by_direction", "bingham_yield_by_direction", "response_table"),
    "guo": ("passive_by_direction", "guo_yield_by_direction", "response_table"),
}
"""Effects of the extended models (1.8) and (1.12): own values in compression and release, tau(u)."""
ROADS = {"bumps": "sine wave", "iso": "ISO road"}
"""Validation programs `chapter_1_<name>.yaml`, and the road as Table 1.5 calls it."""
ADDED = "coulomb_friction"
"""Effect that is added to the Guo model beyond the thesis, as "guo_added"."""
PUBLISHED = {
    "bumps": {"bingham": 0.1036, "guo": 0.0851},
    "iso": {"bingham": 0.0780, "guo": 0.0734},
}
"""NRMSE of Table 1.5, on the real damper."""
TURNING = 0.1
"""Share of the peak velocity below which the motion counts as turning, for case 2."""


@dataclass(frozen=True)
class Case:
    """One record with the force of every model on it; arrays (n,).

    road [m], force [N]: measured; motion: fused; scored: mask of the samples that count; forces [N]: by model.
    """

    name: str
    road: Array
    motion: Motion
    force: Array
    scored: NDArray[np.bool_]
    forces: dict[str, Array]

    def rmse(self, model: str, among: NDArray[np.bool_] | None = None) -> float:
        """Root mean square error of a model [N], on all scored samples or some."""
        rows = self.scored if among is None else self.scored & among
        return float(np.sqrt(np.mean((self.forces[model] - self.force)[rows] ** 2)))

    def nrmse(self, model: str) -> float:
        """The error over the range of the measured force, (3.79)."""
        return self.rmse(model) / float(np.ptp(self.force[self.scored]))

    @property
    def turning(self) -> NDArray[np.bool_]:
        """Mask of the samples around zero velocity."""
        speed = np.abs(self.motion.v)
        return np.asarray(speed < TURNING * speed[self.scored].max())


@dataclass(frozen=True)
class Chapter1:
    """What was measured, both identified models, and the cases.

    polynomial: a model with the response time (1.21); tests: the yield tests as a case (1 and 2); validation: by
    road (3 and 4).
    """

    truth: Model
    polynomial: Model
    identified: dict[str, Identified]
    tests: Case
    validation: dict[str, Case]


def chapter_1(config: Path, seed: int, tick: Callable[[str], None] | None = None) -> Chapter1:
    """Measure, identify and validate.

    config: folder with `vehicles/inove_stand_in.yaml`, `experiments/chapter_1_*.yaml`, and (1.21) in
    `dampers/inove_guo_tau_quadratic.yaml`. Raises `InputError` for files that are not there or not good.
    """
    say = tick or (lambda _: None)
    vehicle = load_model(config / "vehicles" / "inove_stand_in.yaml")
    polynomial = load_model(config / "dampers" / "inove_guo_tau_quadratic.yaml")
    names = ("linear", "yield", *ROADS)
    files = [config / "experiments" / f"chapter_1_{name}.yaml" for name in names]
    programs = [load_program(path) for path in files]
    say("measuring")
    records = {
        name: measure(vehicle, program, seed + k)
        for k, (name, program) in enumerate(zip(names, programs, strict=True))
    }
    tests = [records["linear"], records["yield"]]
    identified = {law: _identified(law, LAWS[law], tests, say) for law in LAWS}
    models = _models(identified, vehicle)
    models["guo_added"] = _identified("guo", (*LAWS["guo"], ADDED), tests, say).model
    say("validation")
    validation = {name: case(name, records[name], models) for name in ROADS}
    return Chapter1(vehicle, polynomial, identified, case("yield", tests[1], models), validation)


def _identified(
    law: str, effects: tuple[str, ...], tests: list[Record], say: Callable[[str], None]
) -> Identified:
    """An extended model, identified from starts that know nothing but the size of the data."""
    model = Model(f"extended {law}", {}, _scales(tests))
    for effect in effects:
        model = model.with_effect(effect)
    say(law)
    work = Work(progress=lambda stage, *_: say(f"{law}: {stage}"))
    return procedure.identified(Dataset.of(tests), model, work)


def _scales(records: list[Record]) -> Scales:
    """Peaks of force, deflection, velocity and duty over all records."""
    names = ("damper_force", "deflection", "deflection_velocity", "duty")
    return Scales(*(max(float(np.abs(r.channels[n]).max()) for r in records) for n in names))


def _models(identified: dict[str, Identified], vehicle: Model) -> dict[str, Model]:
    """Every model that is shown: what was measured; refined, after the stages alone, and static."""
    models = {"truth": vehicle.without_effect("quarter_car")}
    for law, found in identified.items():
        models[law] = found.model
        models[f"{law}_staged"] = found.stages[-1].model
        models[f"{law}_static"] = static(found.stages[1].model)
    return models


def case(name: str, record: Record, models: dict[str, Model]) -> Case:
    """Forces of all models along a measured record.

    On the fused motion; those of the staged models also on the motion as measured, as `<law>_raw`.
    """
    problem = prepare(Dataset.of([record]))
    forces = {key: predict(model, problem.motion) for key, model in models.items()}
    channels = (record.channels[n] for n in ("deflection", "deflection_velocity", "duty"))
    raw = motion(record.dt, *channels)
    for law in LAWS:
        forces[f"{law}_raw"] = predict(models[f"{law}_staged"], raw)
    scored = record.t >= record.t[0] + WARM_UP
    return Case(name, record.channels["road"], problem.motion, problem.force, scored, forces)
