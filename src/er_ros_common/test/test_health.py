"""Figures of a node's own work."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

import pytest

pytest.importorskip("rclpy")

from er_ros_common.core import Core, Shell
from er_ros_common.core_node import CoreNode
from er_ros_common.health import Meter


def test_figures_are_those_since_the_last_look() -> None:
    meter = Meter(deadline=0.005)
    meter.look(10.0)
    for seconds in (0.001, 0.003, 0.007, 0.001):
        meter.step(seconds)
    timing = meter.look(10.5)
    assert timing.output_rate == pytest.approx(8.0)
    assert timing.step_time_mean == pytest.approx(0.003)
    assert timing.step_time_max == 0.007
    assert (timing.published, timing.deadline_misses) == (4, 1)
    later = meter.look(11.0)
    assert (later.output_rate, later.step_time_max) == (0.0, 0.0)
    assert (later.published, later.deadline_misses) == (4, 1)


def test_the_first_look_has_no_rate() -> None:
    meter = Meter(deadline=0.005)
    meter.step(0.001)
    assert meter.look(10.0).output_rate == 0.0


def test_a_step_without_output_counts_for_time_only() -> None:
    meter = Meter(deadline=0.005)
    meter.look(10.0)
    meter.step(0.002, outputs=0)
    timing = meter.look(11.0)
    assert (timing.published, timing.step_time_mean) == (0, 0.002)


@pytest.mark.parametrize(
    ("parameters", "late"), [({}, 1), ({"rate": 1000.0}, 2), ({"rate": 100.0}, 0)]
)
def test_a_step_is_late_at_the_rate_the_node_is_made_for(
    parameters: dict[str, float], late: int
) -> None:
    core: Any = Core()
    core.p = SimpleNamespace(timeout=0.05, max_age=0.02, **parameters)
    core.inputs = core.outputs = core.limits = ()
    meter = Meter(deadline=1.0)
    node: Any = SimpleNamespace(
        p=core.p,
        shell=Shell(object, lambda _: core, (), ()),
        health=SimpleNamespace(meter=meter),
        watch_every=lambda *_: None,
        on_watch=None,
    )
    CoreNode.configure(node)
    for seconds in (0.0005, 0.002, 0.007):
        meter.step(seconds)
    assert meter.deadline_misses == late
