"""Figures of a node's own work."""

from __future__ import annotations

from collections import deque
from itertools import pairwise
from types import SimpleNamespace
from typing import Any

import pytest

pytest.importorskip("rclpy")

from er_ros_common.builders import Timing
from er_ros_common.core import Core, Shell
from er_ros_common.core_node import CoreNode
from er_ros_common.health import CALM, Health, Meter, Report, Shown, Task, settled
from er_ros_common.inputs import ERROR, OK, WARN
from rclpy.clock import ROSClock
from rclpy.logging import LoggingSeverity

from er_damper_msgs.msg import NodeStatus
from er_ros_common import log


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
        note=lambda: None,
    )
    CoreNode.configure(node)
    for seconds in (0.0005, 0.002, 0.007):
        meter.step(seconds)
    assert meter.deadline_misses == late


def test_a_better_level_is_shown_once_it_lasts_and_a_worse_one_at_once() -> None:
    good, bad = Task("timing", OK, "in time"), Task("timing", WARN, "slow")
    shown = settled(None, good, 0.0)
    levels = []
    for k in range(100):
        now = 0.1 * k
        shown = settled(shown, bad if k < 50 and k % 3 == 0 else good, now)
        levels.append(shown.task.level)
    changes = sum(a != b for a, b in pairwise(levels))
    assert (levels[0], levels[-1], changes) == (WARN, OK, 1)
    last = max(k for k in range(50) if k % 3 == 0)
    assert levels.index(OK) == pytest.approx(last + 10 * CALM, abs=1)
    state = settled(Shown(Task("state", ERROR, "silent"), 9.9), Task("state", OK, "running"), 10.0)
    assert state.task.level == OK


def made(**more: Any) -> tuple[Health, list[Any], list[tuple[int, str]]]:
    """Health of a node that is none, what it publishes as diagnostics, and what it logs at which level."""
    sent: list[Any] = []
    health = Health.__new__(Health)
    node = SimpleNamespace(get_fully_qualified_name=lambda: "/fl/plant", get_clock=ROSClock)
    vars(health).update(
        node=node, report=lambda: Report("running"), meter=Meter(0.005), inputs=tuple, problems=tuple,
        _timing=Timing(), _tasks={}, _word="", _missed=0, _sent=-1.0, _means=deque(maxlen=10), _late=deque(maxlen=10),
        _diagnostics=SimpleNamespace(publish=sent.append), **more,
    )  # fmt: skip
    return health, sent, []


def test_names_are_those_of_diagnostic_updater_and_levels_those_of_the_log(
    monkeypatch: pytest.MonkeyPatch,
) -> None:
    health, sent, lines = made()
    monkeypatch.setattr(log, "write", lambda _, severity, text: lines.append((severity, text)))
    for k in range(100):
        late = k in (10, 30, 50)  # one of 200 steps of a second
        slow = 60 <= k < 70
        health.meter.deadline_misses += late
        health._timing = Timing(step_time_mean=0.004 if slow else 0.0004)
        health._diagnose(Report("running"), 0.1 * k)
    assert {each.name for each in sent[0].status} == {
        f"fl/plant: {name}"
        for name in ("state", "input rate", "stamps", "values", "timing", "graph")
    }
    assert {each.hardware_id for each in sent[0].status} == {"/fl"}
    severities = [severity for severity, _ in lines]
    assert severities == [LoggingSeverity.WARN, LoggingSeverity.ERROR, LoggingSeverity.INFO]
    lines.clear()
    for status in (NodeStatus.STATUS_LOST, NodeStatus.STATUS_DEGRADED, NodeStatus.STATUS_OK):
        health._log(Report("some", status, str(status)))
    assert [severity for severity, _ in lines] == severities[1::-1] + severities[2:]
