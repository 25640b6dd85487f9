"""A running graph without ROS: a plant, and the monitor's own core, that say what `er_model_lab.ros_live` would say."""

from __future__ import annotations

import socket
import sys
from collections.abc import Callable
from contextlib import suppress
from dataclasses import replace
from functools import partial
from pathlib import Path
from tempfile import TemporaryDirectory
from time import sleep
from typing import Any

import numpy as np
from er_model_lab.monitor import compare
from er_model_lab.monitor.compare import Row, monitor
from er_model_lab.monitor.sequential import Rules
from er_model_lab.monitor.watch import Finding
from er_models.errors import ErError
from er_models.files import load_model
from er_models.model import Model
from er_models.program import load_program, resolve
from er_models.simulation import simulate

from test.conftest import ROOT

DT = 0.005
VEHICLE = ROOT / "config/vehicles/inove_quarter_car.yaml"
PROGRAM = ROOT / "config/experiments/identification.yaml"
STATUS = {Finding.LEARNING: 1.0, Finding.EXPLAINS: 0.0, Finding.FAILS: 2.0}
CHANNELS = (
    "sprung_acceleration", "unsprung_acceleration", "deflection", "deflection_velocity", "duty", "damper_force",
)  # fmt: skip


class PlayedGraph:
    """What `Link` is, driven by `drive`; truth: the plant; the monitor begins with `model`."""

    def __init__(
        self,
        truth: Model,
        seconds: float,
        model: Path = VEHICLE,
        seed: int = 1,
        learn: float = 10.0,
    ) -> None:
        self.rows, self.at = _driven(truth, seconds, seed), 0
        self.rules = Rules(blocks=round(learn / 0.25))
        self.used, self.asked, self.observers = list[str](), list[str](), False
        self.told: Callable[[dict[str, Any]], None] = lambda _: None
        self._take(str(model))
        self.model = str(model)

    def connect(self, _: str, heard: Callable[[dict[str, Any]], None]) -> PlayedGraph:
        """As `Link` is made; the first words follow with the first `drive`."""
        self.told = heard
        return self

    def _take(self, path: str) -> None:
        self.monitor = monitor(load_model(path), DT, 0.05, self.rules)
        self.mind = compare.State()

    def use(self, model: str, *, observers: bool = False) -> None:
        """The monitor goes on with another model; observers: whether those are asked, too."""
        self.observers = observers
        try:
            self._take(model)
        except ErError as error:
            self.told({"used": {"accepted": False, "reason": str(error), "model": model}})
            return
        self.used.append(model)
        self.told({"used": {"accepted": True, "reason": "", "model": model}})

    def run(self, program: str) -> None:
        """Say that the plant drives a program; the road stays what it is."""
        self.asked.append(program)
        self.told({"ran": {"accepted": True, "reason": "", "node": "/plant", "run": program}})

    def stop(self) -> None:
        """Nothing runs."""

    def drive(self, seconds: float) -> None:
        """Say what happens in the next seconds."""
        if self.at == 0:
            self.told({"model": self.model, "alone": False})
        said = []
        for _ in range(round(seconds / DT)):
            values = self.rows[self.at % len(self.rows)]
            self.at += 1
            self.mind, answer = compare.step(
                self.monitor, self.mind, Row(self.at * 5_000_000, *values)
            )
            watch = self.mind.watch
            left = (answer.error, watch.usual, watch.ratio, STATUS[watch.finding])
            said.append((self.at * DT, *values, *left))
        self.told({"rows": said})
        mode = self.mind.watch.finding.value
        self.told({"status": {"mode": mode, "reason": "", "model_id": ""}})


def _driven(truth: Model, seconds: float, seed: int) -> list[tuple[float, ...]]:
    """What the rig's sensors say on the road that the lab learns from; truth: a car with its damper."""
    asked = replace(load_program(PROGRAM), duration=seconds, seed=seed)
    rng = np.random.default_rng(seed)
    found = simulate(truth, DT, *resolve(asked, truth, DT).ride(DT))
    sizes = (*("acceleration",) * 2, "deflection", "velocity", "", "force")
    columns = [
        found[name]
        + (truth.rig[f"{kind}_noise"] * rng.standard_normal(found[name].size) if kind else 0.0)
        for name, kind in zip(CHANNELS, sizes, strict=True)
    ]
    return [tuple(map(float, row)) for row in np.column_stack(columns)]


def with_friction(car: Path) -> Model:
    """A car whose damper rubs."""
    return load_model(car).with_effect("coulomb_friction", {"F_c": 0.9, "v_0": 0.003})


def serve(folder: Path, *, heard: float, pace: float, busy: float) -> None:
    """A page over a drive of which so many seconds are heard already; it prints its address.

    The drive goes on at a multiple of its time, `pace`, at another one while a job runs, `busy`: a slow machine then
    shows what a fast one does.
    """
    from er_model_lab.page.server import serve as served
    from er_model_lab.session.live_desk import LiveDesk

    graph = PlayedGraph(with_friction(VEHICLE), 120.0)
    desk = LiveDesk(folder, "", models=folder / "models", connect=graph.connect, niceness=0)
    desk.by_itself = False
    for _ in range(round(heard)):
        graph.drive(1.0)

    def on() -> None:
        while True:
            sleep(0.25)
            graph.drive(0.25 * (busy if desk.jobs.running else pace))

    with socket.socket() as free:
        free.bind(("127.0.0.1", 0))
        port = int(free.getsockname()[1])
    served(
        desk, host="127.0.0.1", port=port, browser=False, say=partial(print, flush=True), beside=on
    )


def main() -> None:
    """A page until Ctrl-C, from the command line: seconds heard, pace, pace while a job runs."""
    given = {
        name: float(x) for name, x in zip(("heard", "pace", "busy"), sys.argv[1:], strict=True)
    }
    with TemporaryDirectory() as place, suppress(KeyboardInterrupt):
        serve(Path(place), **given)


if __name__ == "__main__":
    main()
