"""A planned run through the process that listens for the page: the plant of a running graph drives it, and is heard."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from time import monotonic, sleep
from types import SimpleNamespace

import numpy as np
import pytest

pytest.importorskip("rclpy")

from er_model_lab.session.live_desk import LiveDesk
from er_models.program import Program

from test.graph_help import Graph, own_domain, plant_arguments

RUN = Program(
    {"kind": "sine", "amplitude": 0.004, "frequency": 2.0},
    {"kind": "constant", "level": 0.25},
    duration=2.0,
    seed=0,
)


def until(there: Callable[[], bool], seconds: float = 60.0) -> None:
    end = monotonic() + seconds
    while not there():
        assert monotonic() < end
        sleep(0.1)


@pytest.mark.slow
@pytest.mark.alone
def test_the_plant_drives_a_planned_run_and_says_what_it_does_not(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    with own_domain() as env, Graph(env, tmp_path) as graph:
        for name, value in env.items():
            monkeypatch.setenv(name, value)
        desk = LiveDesk(tmp_path / "heard", "", models=tmp_path)
        desk.by_itself = False
        desk.planned = SimpleNamespace(program=RUN)  # type: ignore[assignment]
        desk.drive()
        until(lambda: desk.run is not None and bool(desk.run.reason))
        assert desk.run is not None
        assert desk.run.says(0.0) == (
            "no node drives it: expected one node that says pwm/applied, found none"
        )
        plant = graph.start(
            "plant", *plant_arguments("-p", "duty_source:=topic", "-p", "duration:=0.0")
        )
        until(lambda: desk.heard.seconds > 1.0)
        desk.drive()
        until(lambda: desk.driving)
        plant.wait_for("planned_2.yaml from sample")
        until(lambda: not desk.driving)
        duties = desk.heard.column("duty")
        assert (duties == 0.25).sum() == 400
        assert {*np.unique(duties[np.isfinite(duties)])} == {0.1, 0.25}
        desk.planned = SimpleNamespace(  # type: ignore[assignment]
            program=Program({**RUN.road, "amplitude": 0.06}, RUN.duty, 2.0, 0)
        )
        desk.drive()
        until(lambda: desk.run is not None and bool(desk.run.reason))
        assert "planned_3.yaml: rig: stroke: expected at most 0.012 m" in desk.run.says(0.0)
        desk.shut()
