"""Skyhook among messages: what it says while its inputs are silent."""

from __future__ import annotations

from itertools import pairwise
from pathlib import Path

import pytest
import yaml

pytest.importorskip("rclpy")

from er_common.parameter_table import build
from er_ftc_controller.ros_skyhook import SkyhookCore, SkyhookParameters
from er_ros_common.builders import Tick
from er_ros_common.core import When

from er_common import topics
from er_damper_msgs.msg import PwmDuty
from er_ros_common import builders

CONFIG = Path(__file__).resolve().parents[3] / "config"
SYSTEM, STEADY, MS = 1_700_000_000_000_000_000, 10_000_000_000, 1_000_000


@pytest.fixture(scope="module")
def core() -> SkyhookCore:
    given = yaml.safe_load(
        (CONFIG / "nodes" / "skyhook_controller.yaml").read_text(encoding="utf-8")
    )
    return SkyhookCore(build(SkyhookParameters, given["/**"]["ros__parameters"], {}))


def test_silence_ends_at_the_safe_duty_after_25_ms_and_is_said_again_every_50(
    core: SkyhookCore,
) -> None:
    state = core.start()
    for k in range(1, 40):
        tick, when = Tick(SYSTEM + 5 * MS * k, k), When(STEADY + 5 * MS * k, SYSTEM + 5 * MS * k)
        body = builders.suspension_acceleration(tick, 0.01 * k, 0.1 + 0.02 * k)
        strut = builders.suspension_deflection(tick, 1e-4 * k, 0.1 + 1e-3 * k)
        state, _ = core.on_message(state, topics.ACCELERATION, body, when)
        state, said = core.on_message(state, topics.DEFLECTION, strut, when)
        assert [m.source for _, m in said] == [PwmDuty.SOURCE_NOMINAL]
    safe = []
    for ms in range(200):
        when = When(STEADY + (5 * 39 + ms) * MS, SYSTEM + (5 * 39 + ms) * MS)
        state, said = core.on_time(state, when)
        safe += [
            ms for _, m in said if m.source == PwmDuty.SOURCE_SAFE and m.duty == core.p.safe_duty
        ]
    assert 25 < safe[0] <= 27
    assert all(50 < later - earlier <= 52 for earlier, later in pairwise(safe))
    assert len(safe) == 4
