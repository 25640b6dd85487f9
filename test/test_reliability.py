"""The fault table of docs/reliability.md: each fault against the cores of the nodes, on a virtual clock."""

from __future__ import annotations

import math
from copy import deepcopy
from pathlib import Path
from typing import Any

import pytest

pytest.importorskip("rclpy")

from er_bringup.programs import CORES
from er_ros_common.injection import Kind

from er_common import topics
from er_damper_msgs.msg import DamperForce, PwmDuty
from test.reliability import table
from test.reliability.__main__ import DEFAULTS
from test.reliability.bus import NAMES, SECOND, Bus, Heard
from test.reliability.fuzz import fuzz, fuzz_plant
from test.reliability.kill import killed
from test.reliability.silence import once

SAMPLE = topics.ACCELERATION.name
CONTROLLERS = ("skyhook_controller", "ftc_controller")
PASSIVE_SAFE = 0.1
"""safe_duty of the configuration."""


def after(bus: Bus, topic: str, t: float) -> list[Heard]:
    """Messages of a topic from a time on."""
    return [each for each in bus.log[topic] if each.t >= t - 1e-9]


def first(messages: list[Heard], status: int) -> float:
    """Time of the first message with a status [s]."""
    return next((each.t for each in messages if each.message.status == status), math.inf)


def stamped(message: Any, sec: int, nanosec: int = 0) -> Any:
    """The message with another stamp."""
    message.header.stamp.sec, message.header.stamp.nanosec = sec, nanosec
    return message


@pytest.mark.parametrize("name", NAMES)
def test_a_sensor_that_is_silent_r1(name: str) -> None:
    bus, topic = Bus((name, "skyhook_controller")), f"force/{name.removesuffix('_observer')}"
    bus.run(2.0)
    gone = bus.log[topic][-1].t
    bus.inject(SAMPLE, Kind.OFF, duration=0.5)
    bus.run(1.5)
    answers = after(bus, topic, 2.0)
    assert first(answers, DamperForce.STATUS_DEGRADED) - gone <= 0.030
    assert first(answers, DamperForce.STATUS_LOST) - gone <= 0.060
    lost = [a.message for a in answers if a.message.status == DamperForce.STATUS_LOST]
    assert all(not m.valid and m.force == 0.0 for m in lost)
    back = [a for a in answers if a.t >= 2.5]
    assert next(a.t for a in back if a.message.valid) - 2.5 <= 0.01
    # later than the 0.2 s aimed at, see docs/results/reliability.md: the doubt of a fresh start has to decay
    assert first(back, DamperForce.STATUS_OK) - 2.5 <= 0.35


def test_without_the_deflection_an_observer_is_sure_again_later_r1() -> None:
    late, wrong = once(NAMES[0], 0, 0.06, deflection=False)
    assert 0.1 < late < 0.5
    assert wrong < 1.0


@pytest.mark.parametrize("name", NAMES)
def test_samples_that_say_they_are_not_valid_r1(name: str) -> None:
    bus, topic = Bus((name, "skyhook_controller")), f"force/{name.removesuffix('_observer')}"
    bus.run(2.0)

    def broken(kind: topics.Topic, message: Any) -> list[Any]:
        message.valid = kind.name != SAMPLE
        return [message]

    bus.between = broken
    bus.run(0.2)
    answers = after(bus, topic, 2.0)
    assert first(answers, DamperForce.STATUS_DEGRADED) - 2.0 <= 0.030
    assert first(answers, DamperForce.STATUS_LOST) - 2.0 <= 0.060
    assert len(answers) >= 40, "it still speaks"


@pytest.mark.parametrize("spoilt", ["missing", "not a number", "not valid", "from the future"])
@pytest.mark.parametrize("name", [*NAMES, "fault_estimator"])
def test_without_the_applied_duty_nothing_is_valid_after_50_ms_r1(name: str, spoilt: str) -> None:
    bus = Bus((name,), duty_source="program")
    bus.run(2.0)

    def broken(kind: topics.Topic, message: Any) -> list[Any]:
        if kind.name != topics.PWM_APPLIED.name:
            return [message]
        message.duty = math.nan if spoilt == "not a number" else message.duty
        message.valid = spoilt != "not valid"
        if spoilt == "from the future":
            stamped(message, message.header.stamp.sec + 25, message.header.stamp.nanosec)
        return [] if spoilt == "missing" else [message]

    bus.between = broken
    bus.run(0.5)
    topic = bus.cores[name].outputs[0].name
    answers = after(bus, topic, 2.0)
    lost = [a for a in answers if not a.message.valid]
    assert 0.045 <= lost[0].t - 2.0 <= 0.080
    assert {a.message.status for a in lost} == {DamperForce.STATUS_LOST}
    assert all(not a.message.valid for a in answers if a.t >= lost[0].t)
    bus.between, back = lambda _, message: [message], bus.rig_state.sim.tick
    bus.run(0.7)
    (again,) = (a.message for a in bus.log[topic] if a.message.seq == back)
    assert again.valid
    assert bus.log[topic][-1].message.status == DamperForce.STATUS_OK


def test_a_duty_that_never_came_is_no_duty_r1() -> None:
    names = (*NAMES, "fault_estimator")
    bus = Bus(names, duty_source="program")
    bus.between = lambda kind, message: [] if kind.name == topics.PWM_APPLIED.name else [message]
    bus.run(1.0)
    for topic in (CORES[name].says for name in names):
        answers = bus.log[topic.name]
        assert len(answers) > 190
        assert not any(a.message.valid for a in answers if a.t > 0.1)


@pytest.mark.parametrize("name", CONTROLLERS)
@pytest.mark.parametrize(
    "unit", [topics.ACCELERATION.name, topics.DEFLECTION.name, topics.PWM_COMMAND.name]
)
def test_no_duty_acts_longer_than_50_ms_after_its_sample_r2(name: str, unit: str) -> None:
    bus = Bus((NAMES[0], name))
    bus.run(2.0)
    bus.inject(unit, Kind.OFF, duration=0.5)
    bus.run(1.0)
    duties = after(bus, topics.PWM_APPLIED.name, 2.0)
    # the last sample before the fault was that of the tick before
    safe = next(d.t for d in duties if d.message.source == PwmDuty.SOURCE_SAFE)
    assert safe - (2.0 - bus.rig.dt) <= 0.050 + 1e-9
    within = [d.message.duty for d in duties if safe + 0.020 <= d.t < 2.5]
    assert within
    assert set(within) == {PASSIVE_SAFE}
    back = [d.t for d in duties if d.t >= 2.5 and d.message.source != PwmDuty.SOURCE_SAFE]
    assert back[0] - 2.5 <= 0.2
    for d in duties:
        assert (
            d.message.source == PwmDuty.SOURCE_SAFE
            or (d.message.seq - d.message.command_seq) * bus.rig.dt <= 0.050
        )


@pytest.mark.parametrize("field", ["sprung", "unsprung"])
def test_a_stuck_accelerometer_r3(field: str) -> None:
    bus = Bus()
    bus.run(5.0)
    assert bus.states[NAMES[0]].unusable == 0
    bus.inject(f"{SAMPLE}.{field}", Kind.STUCK)
    bus.run(0.5)
    lost = first(after(bus, topics.estimated_force("unified").name, 5.0), DamperForce.STATUS_LOST)
    assert lost - 5.0 <= 0.150 + 0.055
    assert bus.log[topics.PWM_APPLIED.name][-1].message.duty == PASSIVE_SAFE


def test_a_stuck_velocity_ends_in_the_safe_duty_r3() -> None:
    bus = Bus()
    bus.run(5.0)
    bus.inject(f"{topics.DEFLECTION.name}.velocity", Kind.STUCK)
    bus.run(0.5)
    safe = [
        d.t
        for d in after(bus, topics.PWM_APPLIED.name, 5.0)
        if d.message.source == PwmDuty.SOURCE_SAFE
    ]
    assert safe[0] - 5.0 <= 0.150 + 0.050
    assert bus.log[topics.PWM_APPLIED.name][-1].message.duty == PASSIVE_SAFE


@pytest.mark.parametrize(("kind", "value"), [(Kind.BIAS, 3.0), (Kind.INTERMITTENT, 0.9)])
def test_a_wrong_accelerometer_is_doubted_r4(kind: Kind, value: float) -> None:
    bus = Bus()
    bus.run(3.0)
    bus.inject(SAMPLE if kind is Kind.INTERMITTENT else f"{SAMPLE}.sprung", kind, value)
    bus.run(1.0)
    doubt = [
        a.t
        for a in after(bus, topics.estimated_force("unified").name, 3.0)
        if a.message.status != DamperForce.STATUS_OK
    ]
    assert doubt[0] - 3.0 <= 0.5


@pytest.mark.parametrize("name", [*NAMES, "fault_estimator", *CONTROLLERS])
def test_whatever_comes_in_nothing_impossible_goes_out_r5(name: str) -> None:
    assert fuzz(name, 4000, seed=1) == []
    assert fuzz(name, 1000, seed=1, aged=False) == []


def test_whatever_is_commanded_the_plant_applies_a_duty_of_its_range_r5() -> None:
    assert fuzz_plant(2000, seed=1) == []


def test_a_lie_of_three_samples_leaves_no_trace_r5() -> None:
    """NaN at three samples: the estimate goes on, and is soon what it would have been."""
    good, bad = (Bus((NAMES[0],), duty_source="program") for _ in range(2))

    def lie(kind: topics.Topic, message: Any) -> list[Any]:
        if kind.name == SAMPLE and message.seq in (601, 602, 603):
            message.sprung = math.nan
        return [message]

    bad.between = lie
    for bus in (good, bad):
        bus.run(4.0)
    a, b = (each.log[topics.estimated_force("unified").name][-1].message for each in (good, bad))
    assert all(
        math.isfinite(each.message.force)
        for each in bad.log[topics.estimated_force("unified").name]
    )
    assert (b.status, b.valid) == (DamperForce.STATUS_OK, True)
    assert b.force == pytest.approx(a.force, abs=0.5)


@pytest.mark.parametrize("asked", [-3.0, 0.9, 1e308, math.nan, math.inf])
def test_the_plant_applies_no_duty_outside_its_range_r6(asked: float) -> None:
    bus = Bus((NAMES[0],))
    gate = bus.rig.gate

    def commanded(kind: topics.Topic, message: Any) -> list[Any]:
        if kind.name == SAMPLE:
            command = PwmDuty(duty=asked, seq=message.seq, valid=True)
            bus.command(command)
        return [message]

    bus.between = commanded
    bus.run(0.5)
    duties = [d.message for d in after(bus, topics.PWM_APPLIED.name, 0.1)]
    assert all(gate.duty_min <= d.duty <= gate.duty_max for d in duties)
    assert all(d.saturated == math.isfinite(asked) for d in duties)


@pytest.mark.parametrize("skew", [-SECOND // 20, SECOND // 50])
@pytest.mark.parametrize("name", CONTROLLERS)
def test_old_and_future_stamps_are_not_used_r7_r8(name: str, skew: int) -> None:
    bus = Bus((NAMES[0], name))
    bus.run(1.0)
    bus.skew = skew
    bus.run(0.5)
    stamps = bus.states[name].stamps
    assert (stamps.stale if skew < 0 else stamps.future) >= 99
    assert after(bus, topics.estimated_force("unified").name, 1.2) == [] if skew > 0 else True
    assert bus.log[topics.PWM_APPLIED.name][-1].message.duty == PASSIVE_SAFE


def test_messages_without_a_stamp_are_not_used_r8() -> None:
    bus = Bus()
    bus.run(1.0)

    def unset(_: topics.Topic, message: Any) -> list[Any]:
        message.header.stamp.sec = message.header.stamp.nanosec = 0
        return [message]

    bus.between = unset
    bus.run(0.5)
    assert bus.states["skyhook_controller"].stamps.zero_stamp >= 99
    assert bus.states[NAMES[0]].stamps.zero_stamp >= 99
    assert bus.log[topics.PWM_APPLIED.name][-1].message.duty == PASSIVE_SAFE


SEEN = (topics.ACCELERATION.name, topics.DEFLECTION.name, topics.PWM_APPLIED.name)


@pytest.mark.parametrize("unit", SEEN)
@pytest.mark.parametrize("name", [NAMES[0], "fault_estimator", *CONTROLLERS])
def test_a_bad_stamp_beside_the_good_one_changes_nothing_r7_r8(name: str, unit: str) -> None:
    """Each tick once more, without a stamp, 2 s old, before the start of time, and from the future."""
    plain, mixed = Bus((name,), duty_source="program"), Bus((name,), duty_source="program")

    def more(kind: topics.Topic, message: Any) -> list[Any]:
        if kind.name != unit or message.seq < 100:
            return [message]
        sec = message.header.stamp.sec
        stamps = [(0, 0), (-5, 0), (sec - 2, 0), (sec + 25, message.seq), (sec, 2 * SECOND)]
        return [*(stamped(deepcopy(message), *each) for each in stamps), message]

    mixed.between = more
    for bus in (plain, mixed):
        bus.run(1.0)
    topic = bus.cores[name].outputs[0].name
    said = [[repr(each.message) for each in bus.log[topic]] for bus in (plain, mixed)]
    assert said[0] == said[1]
    counts, heard = mixed.states[name].stamps, unit in [t.name for t in mixed.cores[name].inputs]
    found = (counts.zero_stamp, counts.stale, counts.future)
    assert found == ((3 * 101, 101, 101) if heard else (0, 0, 0))


@pytest.mark.parametrize("unit", SEEN[:2])
@pytest.mark.parametrize("name", CONTROLLERS)
def test_after_a_burst_of_future_stamps_the_next_sample_is_answered_r8(
    name: str, unit: str
) -> None:
    bus = Bus((NAMES[0], name))
    bus.run(1.0)

    def ahead(kind: topics.Topic, message: Any) -> list[Any]:
        if kind.name == unit:
            stamped(message, message.header.stamp.sec + 25, message.header.stamp.nanosec)
        return [message]

    bus.between = ahead
    bus.run(0.2)
    assert bus.log[topics.PWM_APPLIED.name][-1].message.duty == PASSIVE_SAFE
    bus.between, good = lambda _, message: [message], bus.rig_state.sim.tick
    bus.run(0.5)
    answers = [c.message for c in bus.log[topics.PWM_COMMAND.name] if c.message.seq >= good]
    assert {m.source for m in answers} == {PwmDuty.SOURCE_NOMINAL}
    assert len(answers) == 100


@pytest.mark.parametrize("name", [*NAMES, "fault_estimator", *CONTROLLERS])
def test_repeated_and_late_messages_change_nothing_r9(name: str) -> None:
    """Every message twice, and each once more after the next one of its topic."""
    partner = NAMES[0] if name in CONTROLLERS else "skyhook_controller"
    plain, mixed = Bus((name, partner)), Bus((name, partner))
    before: dict[str, Any] = {}

    def again(kind: topics.Topic, message: Any) -> list[Any]:
        old = before.get(kind.name)
        before[kind.name] = message
        return [message, message] if old is None else [message, message, old]

    mixed.between = again
    for bus in (plain, mixed):
        bus.run(1.0)
    topic = bus.cores[name].outputs[0].name
    said = [{m.message.seq: repr(m.message) for m in bus.log[topic]} for bus in (plain, mixed)]
    assert said[0] == said[1]
    assert mixed.states[name].stamps.used == plain.states[name].stamps.used


@pytest.mark.parametrize("name", [*NAMES, "skyhook_controller"])
def test_a_bag_that_loops_starts_afresh_r10(name: str) -> None:
    bus = Bus((name,), duty_source="program")
    bus.run(2.0)
    topic = bus.cores[name].outputs[0].name
    played = [(kind, each) for kind in bus.cores[name].inputs for each in bus.log[kind.name]]
    played.sort(key=lambda one: (one[1].message.seq, one[0] is topics.PWM_APPLIED))
    each = bus.cores[name]
    state, loops = each.start(), []
    for _ in range(2):
        said: list[Any] = []
        for kind, heard in played:
            state, now = each.on_message(
                state, kind, heard.message, bus.when()._replace(system=None)
            )
            said += [m for _, m in now]
        loops.append(said)
    assert state.stamps.resets == 1
    key = "force" if topic.startswith("force") else "duty"
    one, two = ([getattr(m, key) for m in loop] for loop in loops)
    # the last sample of the first loop may still wait for its duty
    assert len(two) - len(one) in (0, 1)
    assert max(abs(a - b) for a, b in zip(one, two[len(two) - len(one) :], strict=True)) <= 1e-9


def test_nothing_is_integrated_over_a_gap_r11() -> None:
    bus = Bus()
    bus.run(2.0)
    bus.inject(SAMPLE, Kind.OFF, duration=1.0)
    bus.run(1.005)
    assert bus.states["skyhook_controller"].mind.velocity == 0.0
    bus.run(1.0)
    assert bus.states["skyhook_controller"].mind.resets == 1
    assert bus.states[NAMES[0]].mind.resets == 1


@pytest.mark.parametrize("step", [-3600 * SECOND, 3600 * SECOND])
def test_a_system_clock_that_is_set_r12(step: int) -> None:
    bus = Bus()
    bus.run(1.5)
    bus.jump = step
    bus.run(2.0)
    duties = after(bus, topics.PWM_APPLIED.name, 1.5)
    ticks = [d.message.seq for d in duties]
    assert ticks == list(range(ticks[0], ticks[0] + 400)), "the ticks keep their pace"
    held = [d.t for d in duties if d.message.source != PwmDuty.SOURCE_SAFE and 1.56 < d.t < 1.99]
    assert held == []
    assert duties[-1].message.source == PwmDuty.SOURCE_NOMINAL
    back = max(d.t for d in duties if d.message.source == PwmDuty.SOURCE_SAFE)
    assert back - 1.5 <= 1.2


@pytest.mark.parametrize("milliseconds", [-12, -9, -6, -4, -2, 8, 19])
@pytest.mark.parametrize("name", CONTROLLERS)
def test_a_system_clock_that_is_set_by_a_little_r12(name: str, milliseconds: int) -> None:
    bus = Bus((NAMES[0], name))
    bus.run(1.5)
    bus.jump = milliseconds * 1_000_000
    bus.run(1.5)
    duties = after(bus, topics.PWM_APPLIED.name, 1.5 + 1.2)
    assert {d.message.source for d in duties} == {PwmDuty.SOURCE_NOMINAL}


def test_two_controllers_are_no_controller_r17() -> None:
    bus = Bus()
    bus.run(1.0)
    bus.conflict = True
    bus.run(0.1)
    duties = after(bus, topics.PWM_APPLIED.name, 1.0)
    assert {d.message.duty for d in duties} == {PASSIVE_SAFE}
    assert {d.message.status for d in duties} == {PwmDuty.STATUS_FAULT}


def test_a_run_repeats_bit_for_bit_r28() -> None:
    runs = []
    for _ in range(2):
        bus = Bus((*NAMES, *CONTROLLERS[:1]), seed=3)
        bus.run(1.0)
        runs.append([repr(each.message) for topic in bus.log.values() for each in topic])
    assert runs[0] == runs[1]


def test_commands_for_a_plant_that_was_here_before_block_nothing_r18() -> None:
    """A controller that outlives its plant answers the old numbers until it hears the new ones."""
    bus = Bus((NAMES[0], "skyhook_controller"))
    bus.command(PwmDuty(duty=0.1, seq=100_000, valid=True, source=PwmDuty.SOURCE_SAFE))
    bus.run(0.2)
    assert bus.log[topics.PWM_APPLIED.name][-1].message.source == PwmDuty.SOURCE_NOMINAL


@pytest.mark.slow
@pytest.mark.alone
def test_a_killed_node_comes_back_by_itself_r18(tmp_path: Path) -> None:
    """Each once; twenty times each, and how soon, is `python -m test.reliability kill`.

    A restart is two seconds of processor time: how long that takes depends on what else the machine does.
    """
    found = killed(1, tmp_path, within=60.0)
    assert all(math.isfinite(t) for each in found.values() for t in each), found


def test_every_row_of_the_documented_table_is_held_by_something_that_exists() -> None:
    rows = table.rows()
    assert rows == tuple(f"R{k}" for k in range(1, 29))
    assert {*table.ELSEWHERE, *table.RUNS} <= {*rows}
    for row in rows:
        ids = table.tests_of(row)
        assert ids or row in table.RUNS, row
        for each in ids:
            file, _, name = each.partition("::")
            assert table.tests_in(file) >= ({name} if name else set()), each
    assert {words[0] for words in table.RUNS.values()} <= {*DEFAULTS}


def test_a_row_is_held_where_each_of_its_tests_ran_and_none_failed(tmp_path: Path) -> None:
    cases = {
        "good": ["", ""],
        "half": ["", "<failure/>"],
        "left": ["<skipped/>"],
        "bad": ["<error/>"],
    }
    lines = [
        f'<testcase file="a.py" name="test_{name}[{k}]">{each}</testcase>'
        for name, found in cases.items()
        for k, each in enumerate(found)
    ]
    report = tmp_path / "report.xml"
    report.write_text(f"<testsuite>{''.join(lines)}</testsuite>")
    found = table.outcomes(report)
    good = {name for name in cases if table.held([f"a.py::test_{name}"], found)}
    assert good == {"good"}
    assert not table.held(["a.py"], found)
    assert not table.held(["a.py::test_good", "a.py::test_gone"], found)
