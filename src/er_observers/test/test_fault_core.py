"""Messages to the fault estimator: parts of a tick in any order, parts that never come, silence."""

from __future__ import annotations

from pathlib import Path

import pytest

pytest.importorskip("er_studies", reason="the whole workspace drives them")
from er_models.errors import InputError
from er_models.model import Model
from er_observers.fault_settings import FaultParameters
from er_observers.faults import tick
from er_observers.faults.sample import sample_of
from er_observers.ros_faults import FaultCore, State
from er_ros_common.core import Said, When
from er_studies.faults.trials import Trial, drive

from er_common import gather, topics
from er_damper_msgs.msg import FaultEstimate
from er_ros_common import builders

NEEDED = (gather.ACCELERATION, gather.DEFLECTION, gather.DUTY)
MS = 1_000_000


def test_a_tick_goes_on_when_it_is_complete_whatever_came_first() -> None:
    g = gather.Gathered()
    for which, part in ((gather.DUTY, (0.2,)), (gather.DEFLECTION, (1e-3, 0.1))):
        g, ready = gather.add(g, NEEDED, which, 5 * MS, 1, part)
        assert ready == []
    g, ready = gather.add(g, NEEDED, gather.ACCELERATION, 5 * MS, 1, (1.0, -2.0))
    assert [sample_of(t, 0)[:6] for t in ready] == [(0.005, 1.0, -2.0, 1e-3, 0.1, 0.2)]
    g, ready = gather.add(g, NEEDED, gather.DUTY, 5 * MS, 1, (0.3,))
    assert ready == []
    assert g.missing == 0


def test_a_lost_part_holds_nothing_up() -> None:
    g, said = gather.Gathered(), []
    for k in range(1, 12):
        for which, part in ((gather.ACCELERATION, (1.0, 2.0)), (gather.DEFLECTION, (0.0, 0.0))):
            g, ready = gather.add(g, NEEDED, which, k * 5 * MS, k, part)
            said += ready
    assert [tick.seq for tick in said] == list(range(1, 8))
    assert g.missing == 7
    assert str(sample_of(said[0], 0).duty) == "nan"
    g, ready = gather.add(g, NEEDED, gather.DUTY, 10 * 5 * MS, 10, (0.1,))
    assert [tick.seq for tick in ready] == [8, 9, 10]


def test_time_that_jumps_back_begins_anew() -> None:
    g = gather.Gathered(last=100_000 * MS)
    for which, part in zip(NEEDED, ((1.0, 2.0), (0.0, 0.0), (0.1,)), strict=True):
        g, ready = gather.add(g, NEEDED, which, 5 * MS, 1, part)
    assert [tick.seq for tick in ready] == [1]


def test_an_old_part_is_no_jump_of_time() -> None:
    g = gather.Gathered(last=100_000 * MS)
    for which in (gather.DEFLECTION, gather.DUTY):
        assert gather.add(g, NEEDED, which, 5 * MS, 1, (0.1, 0.1)) == (g, [])


def played(
    core: FaultCore, model: Model, seconds: float, held: str = "", since: float = 1.0
) -> tuple[State, list[Said]]:
    """A healthy drive, message by message; a sensor may hold its value from a time [s] on."""
    state, found, kept = core.start(), [], None
    for k, s in enumerate(drive(Trial(1004, duration=seconds), model).samples, 1):
        tick = builders.Tick(1_000 * MS + k * 5 * MS, k)
        if held and s.t >= since:
            kept = kept or s
            s = s._replace(**{held: getattr(kept, held)})
        messages = (
            (topics.PWM_APPLIED, builders.pwm_duty(tick, s.duty)),
            (topics.ACCELERATION, builders.suspension_acceleration(tick, *s[1:3])),
            (topics.DEFLECTION, builders.suspension_deflection(tick, *s[3:5])),
        )
        for topic, message in messages:
            state, said = core.on_message(state, topic, message, When(k * 5 * MS, None))
            found += said
    return state, found


@pytest.mark.parametrize("held", ["deflection", "unsprung_acceleration"])
def test_a_stuck_sensor_is_no_fault_of_the_damper(car: Model, car_file: Path, held: str) -> None:
    core = FaultCore(FaultParameters(model_file=str(car_file)))
    said = [m for _, m in played(core, car, 4.0, held)[1]]
    late = [m for m in said if m.seq > 240]
    assert all(m.valid for m in said[130:200])
    assert not any(m.valid for m in late)
    assert {m.status for m in late} == {FaultEstimate.STATUS_LOST}
    assert FaultEstimate.FAULT_CONFIRMED not in {m.f2_status for m in said}


def test_every_tick_is_answered_and_silence_is_said_once(car: Model, car_file: Path) -> None:
    core = FaultCore(FaultParameters(model_file=str(car_file)))
    state, said = played(core, car, 2.0)
    assert len(said) == 400
    assert all(topic is topics.FAULT for topic, _ in said)
    last: FaultEstimate = said[-1][1]
    assert (last.valid, last.kind, last.seq) == (True, FaultEstimate.KIND_NONE, 400)
    assert (last.f1_status, last.f2_status) == (FaultEstimate.FAULT_HEALTHY,) * 2
    assert last.certainty > 0.95
    now = When(400 * 5 * MS + 60 * MS, None)
    state, said = core.on_time(state, now)
    assert [(m.valid, m.status) for _, m in said] == [(False, FaultEstimate.STATUS_LOST)]
    assert core.on_time(state, now)[1] == []


def test_lessons_last_as_long_at_the_rate_of_the_samples(car_file: Path) -> None:
    usual, fast = (
        FaultCore(FaultParameters(model_file=str(car_file), rate=rate)).estimator.setup
        for rate in (200.0, 1000.0)
    )
    assert fast[tick.KEPT] ** 5 == pytest.approx(usual[tick.KEPT])


def test_an_observed_force_needs_its_deviation(car_file: Path) -> None:
    given = {"model_file": str(car_file), "force_source": "force/unified"}
    with pytest.raises(InputError, match=r"force_noise: expected the deviation of force/unified"):
        FaultCore(FaultParameters(**given))
    core = FaultCore(FaultParameters(**given, force_noise=0.5))
    assert core.inputs[-1] is topics.estimated_force("unified")
