"""Runs every controller on every road and fault of a scenario: the same road and the same noise for each."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any, NamedTuple

from er_common.parameter_table import build
from er_ftc_controller.gains import load_gains
from er_ftc_controller.settings import FtcParameters, controller_of
from er_ftc_controller.skyhook import Skyhook
from er_models.constants import SAMPLE_TIME as DT
from er_models.files import load_model
from er_models.model import Array, Model
from er_models.yaml_file import read_yaml

from er_studies.control import rivals
from er_studies.control.closed_loop import Sensors, Watch, drive, known
from er_studies.control.measures import Measures, measure
from er_studies.control.rivals import Law
from er_studies.control.scenarios import Scenario

TOLERANCE = 3.0
"""Violations count from so many standard deviations of the force sensor on."""
LAWS = (
    "passive", "skyhook", "nominal", "force_feedback", "faults_known", "fault_tolerant",
)  # fmt: skip
"""Controllers in the order they are shown.

nominal: as if the damper were healthy. force_feedback: the LPV law of the deflection alone, nominal, its loop corrected
by the force that the accelerometer tells. faults_known: fault_tolerant, told the true faults.
"""
FEEDBACK = 0.3
"""Correction of the force loop with feedback."""
WatchOf = Callable[[Model, Model], Watch]
"""Source of fault estimates for the healthy car that is believed in, and the true one."""


@dataclass(frozen=True)
class Setup:
    """The healthy car, the parameters of both controllers, and the Skyhook's."""

    model: Model
    parameters: FtcParameters
    skyhook: Skyhook

    def law(self, name: str, scenario: Scenario) -> Law:
        """A controller of `LAWS` within the limits of a scenario."""
        if name == "passive":
            return rivals.passive(self.parameters.u_min)
        if name == "skyhook":
            return rivals.two_states(self.skyhook)
        p = replace(self.parameters, u_max=scenario.duty_max, latency=scenario.latency * DT)
        if name == "force_feedback":
            p = replace(p, feedback="deflection", correction=FEEDBACK)
        return self.built(p, nominal=name in ("nominal", "force_feedback"))

    def built(self, p: FtcParameters, *, nominal: bool = False) -> Law:
        """The LPV controller of some parameters."""
        ftc = controller_of(p, self.model, load_gains(p.gains_file, self.model))
        return rivals.nominal(ftc) if nominal else rivals.fault_tolerant(ftc)


class Outcome(NamedTuple):
    """One controller on one road with one fault."""

    scenario: str
    fault: str
    law: str
    number: int
    measures: Measures


def setup(config: Path, model: Path | None = None) -> Setup:
    """Car and controllers as `config` has them."""
    car = model or config / "vehicles" / "inove_quarter_car.yaml"
    given = _parameters(config, "ftc_controller")
    given |= {"model_file": str(car), "gains_file": str(config / "gains" / "lpv_ftc.yaml")}
    hook = _parameters(config, "skyhook_controller")
    skyhook = Skyhook(hook["u_min"], hook["u_max"], hook["corner_frequency"])
    return Setup(load_model(car), build(FtcParameters, given, {}), skyhook)


def _parameters(config: Path, node: str) -> dict[str, Any]:
    """Parameters of a node in its own file."""
    document = read_yaml(config / "nodes" / f"{node}.yaml", "a parameter file")
    return dict(document["/**"]["ros__parameters"])


def run(
    setup: Setup, scenario: Scenario, fault: str, law: Law, watch: WatchOf, number: int
) -> dict[str, Array]:
    """Record of one run, as `closed_loop.drive`."""
    car, seed = scenario.car(setup.model, fault), scenario.program.seed + number
    road = scenario.road(setup.model, number)
    return drive(
        car, road, DT, law, watch(setup.model, car), Sensors(latency=scenario.latency), seed
    )


def compare(
    setup: Setup, scenarios: Sequence[Scenario], watch: WatchOf, seeds: int | None = None,
    laws: Sequence[str] = LAWS, tick: Callable[[int, int], None] | None = None,
) -> list[Outcome]:  # fmt: skip
    """Every controller on every fault and road, or the first `seeds` roads; tick: runs done and of all."""
    jobs = [
        (s, fault, number)
        for s in scenarios
        for fault in s.faults
        for number in range(min(s.seeds, seeds or s.seeds))
    ]
    each: Mapping[tuple[str, str], Law] = {
        (s.name, name): setup.law(name, s) for s in scenarios for name in laws
    }
    found = []
    for done, (s, fault, number) in enumerate(jobs, 1):
        for name in laws:
            source = watch if name == "fault_tolerant" else known
            record = run(setup, s, fault, each[s.name, name], source, number)
            found.append(Outcome(s.name, fault, name, number, judged(setup, s, record)))
        if tick is not None:
            tick(done, len(jobs))
    return found


def judged(setup: Setup, scenario: Scenario, record: dict[str, Array]) -> Measures:
    """Measures of a record of a scenario."""
    from er_models.static_damper import static_damper

    return measure(
        record, scenario.window, setup.model.value("quarter_car", "k_t"), static_damper(setup.model),
        (setup.parameters.u_min, scenario.duty_max), TOLERANCE * Sensors().force,
    )  # fmt: skip
