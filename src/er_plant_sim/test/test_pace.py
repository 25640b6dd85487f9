"""Stamps follow a system clock that was set by anything that whoever takes them would refuse."""

from __future__ import annotations

from types import SimpleNamespace

import pytest
from er_common.stamps import StampLimits, StampState, check_stamp
from er_plant_sim.nodes import pace

MS, DT = 1_000_000, 5_000_000
STEADY, SYSTEM = 1_000_000_000_000, 1_700_000_000_000_000_000


@pytest.mark.parametrize("step", [-3_600_000, -11, -9, -6, -5, -3, -2, 0, 2, 8, 18, 3_600_000])
def test_no_step_of_the_clock_is_refused_for_long(
    monkeypatch: pytest.MonkeyPatch, step: int
) -> None:
    clock = SimpleNamespace(steady=STEADY, step=0)
    monkeypatch.setattr(pace, "monotonic_ns", lambda: clock.steady)
    monkeypatch.setattr(pace, "time_ns", lambda: SYSTEM + clock.steady - STEADY + clock.step)
    each = pace.Pace(1e-9 * DT, 1.0, real=True)
    each.restart(0)
    stamps, verdicts = StampState(), []
    for k in range(40):
        clock.step = step * MS if k >= 20 else 0
        if k == 30:
            each.follow_clock()
        stamp = each.stamp(k, k)
        stamps, verdict = check_stamp(StampLimits(), stamps, stamp, k + 1, pace.time_ns())
        verdicts.append(verdict)
        clock.steady += DT
    assert all(v.use for v in verdicts[:20])
    # one or two samples may be out of order where the clock was set back by a little
    assert all(v.use for v in verdicts[33:])
    assert each.clock_steps == (abs(step) > 2.5)
