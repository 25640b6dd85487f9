"""The pure step: timing of the duty, bad samples, lost time, statuses, speed."""

from __future__ import annotations

import math
import time
from collections.abc import Callable, Sequence
from dataclasses import replace

import numpy as np
import pytest
from er_models.model import Array, Model
from er_models.road import road_profile
from er_models.simulation import simulate
from er_observers.gains import Gains
from er_observers.observers.status import LIMITS, Status
from er_observers.running.evaluate import replay
from er_observers.running.runtime import Estimate, Sample, State, start, step
from hypothesis import given, settings
from hypothesis import strategies as st

DT = 0.005
NAN = math.nan


Drive = Callable[..., list[Sample]]


def run(gains: Gains, samples: Sequence[Sample]) -> tuple[State, list[Estimate]]:
    """All estimates and the last state."""
    state = start(gains, samples[0])
    estimates = [state.estimate]
    for sample in samples[1:]:
        state, estimate = step(gains, state, sample)
        estimates.append(estimate)
    return state, estimates


def assert_same(a: State, b: State) -> None:
    """Bit by bit, but for the counter of rejected samples."""
    np.testing.assert_array_equal(a.x, b.x)
    np.testing.assert_array_equal(a.y, b.y)
    assert (a.t, a.duty, a.health, a.estimate) == (b.t, b.duty, b.health, b.estimate)


def test_first_state_explains_the_first_sample(gains: Gains) -> None:
    """Whatever the duty, the start makes the accelerations measured, but for their noise; without start phase exactly,
    and without yield force where there is no field."""
    bare = replace(gains, opening=None)
    for duty in (0.0, 0.4, 1.0):
        state = start(gains, Sample(0.0, 2.0, -7.0, duty))
        np.testing.assert_allclose(gains.form.C @ state.x, [2.0, -7.0], atol=0.01)
        assert state.estimate.status is Status.INITIALISING
        exact = start(bare, Sample(0.0, 2.0, -7.0, duty))
        np.testing.assert_allclose(gains.form.C @ exact.x, [2.0, -7.0], rtol=1e-9)
    assert abs(start(bare, Sample(0.0, 2.0, -7.0, 0.0)).x[3]) < 1e-12


def test_duty_acts_after_its_stamp(gains: Gains, drive: Drive) -> None:
    """The duty stamped t_k is in force from t_k on: it cannot move the estimate at t_k."""
    state, _ = run(gains, drive(50))
    here = Sample(50 * DT, 1.0, -2.0, 0.2)
    (low, at_low), (high, at_high) = (
        step(gains, state, here._replace(duty=d)) for d in (0.0, 1.0)
    )
    assert at_low.force == at_high.force
    then = Sample(51 * DT, 1.5, -3.0, 0.2)
    assert step(gains, low, then)[1].force != step(gains, high, then)[1].force


def test_one_sample_shift_of_the_duty_matters(car: Model, gains: Gains) -> None:
    """On a plant with switched duty the right pairing is clearly better than either neighbour."""
    k = np.arange(1200)
    road = 2e-3 * np.sin(2 * np.pi * 3.0 * DT * k) + 5e-4 * np.sin(2 * np.pi * 13.0 * DT * k)
    duty = np.where((k // 7) % 2 == 0, 1.0, 0.0)
    record = simulate(car, DT, road, duty)

    def error(shift: int) -> float:
        shifted = {**record, "duty": np.roll(duty, shift)}
        force = np.array([e.force for e in replay(gains, shifted)])
        return float(np.sqrt(np.mean((force - record["damper_force"])[400:] ** 2)))

    assert error(0) < 0.6 * min(error(-1), error(1))


@pytest.mark.parametrize("bad", [(NAN, 1.0), (1.0, NAN), (math.inf, 0.0), (0.0, 1e308)])
def test_bad_sample_is_bridged_and_healed(
    gains: Gains, drive: Drive, bad: tuple[float, float]
) -> None:
    """One bad sample: estimate near the true one, finite, and soon forgotten."""
    good = drive()
    spoilt = [s._replace(sprung_acceleration=bad[0], unsprung_acceleration=bad[1]) if i == 200 else s
              for i, s in enumerate(good)]  # fmt: skip
    (_, clean), (state, patched) = run(gains, good), run(gains, spoilt)
    assert all(math.isfinite(e.force) for e in patched)
    assert patched[200].force == pytest.approx(clean[200].force, abs=6.0)
    assert patched[300].force == pytest.approx(clean[300].force, abs=0.05)
    assert state.rejected == 1
    assert patched[200].status is Status.OK


def test_dropout_is_announced_and_recovered(gains: Gains, drive: Drive) -> None:
    """DEGRADED after 20 ms, INVALID after 50 ms, OK again within 0.2 s of the data's return."""
    samples = [s._replace(sprung_acceleration=NAN) if 200 <= i < 220 else s
               for i, s in enumerate(drive(400, duty=0.0))]  # fmt: skip
    state, estimates = run(gains, samples)
    statuses = [e.status for e in estimates]
    assert statuses[199:204] == [Status.OK] * 5
    assert set(statuses[204:210]) == {Status.DEGRADED}
    assert set(statuses[210:220]) == {Status.INVALID}
    assert all(e.force == 0.0 for e in estimates[210:220])
    back = next(i for i in range(220, 400) if statuses[i] is Status.OK)
    assert (back - 220) * DT <= 0.2 + 1e-9
    assert state.resets == 1


def test_short_dropout_keeps_the_state(gains: Gains, drive: Drive) -> None:
    """Up to the hold limit nothing starts afresh, and the status returns after 0.1 s."""
    samples = [s._replace(unsprung_acceleration=NAN) if 200 <= i < 206 else s
               for i, s in enumerate(drive())]  # fmt: skip
    state, estimates = run(gains, samples)
    assert state.resets == 0
    assert estimates[206].status is Status.DEGRADED
    assert estimates[206 + 22].status is Status.OK


def test_bridging_beats_holding_the_measurement(car: Model, gains: Gains) -> None:
    """ISO road, gaps of 30 ms: the model alone is nearer to the truth than a held measurement."""
    t = np.arange(2400) * DT
    record = simulate(car, DT, 0.2 * road_profile({"kind": "iso8608"}, t, 6), np.full(t.size, 0.1))
    gap = (np.arange(t.size) % 40 < 6) & (t > 1.0)
    source = np.maximum.accumulate(np.where(gap, 0, np.arange(t.size)))
    columns = ("sprung_acceleration", "unsprung_acceleration")
    held = {**record, **{c: record[c][source] for c in columns}}
    bridged = {**record, **{c: np.where(gap, NAN, record[c]) for c in columns}}

    def error(channels: dict[str, Array]) -> float:
        force = np.array([e.force for e in replay(gains, channels)])
        return float(np.sqrt(np.mean((force - record["damper_force"])[gap] ** 2)))

    assert error(bridged) < 0.85 * error(held)


def test_late_and_double_samples_change_nothing(gains: Gains, drive: Drive) -> None:
    """The state is bit for bit that of the run without them."""
    good = drive()
    extra: list[Sample] = []
    for i, sample in enumerate(good):
        extra.append(sample)
        if i % 50 == 49:
            extra += [sample._replace(sprung_acceleration=9.0), good[i - 3]]
    (clean, _), (mixed, _) = run(gains, good), run(gains, extra)
    assert_same(clean, mixed)
    assert mixed.rejected == 16


@pytest.mark.parametrize("jump", [-100.0, -0.2, 0.06, 3600.0])
def test_time_jump_starts_afresh(gains: Gains, drive: Drive, jump: float) -> None:
    """After a jump the run is that of a new observer, shifted in time; nothing is integrated."""
    first, second = drive(100), drive(150)
    shift = first[-1].t + DT + jump
    moved = [s._replace(t=round(s.t + shift, 9)) for s in second]
    (fresh, alone), (state, joined) = run(gains, second), run(gains, [*first, *moved])
    assert state.resets == 1
    assert joined[100].status is Status.INITIALISING
    np.testing.assert_allclose(state.x, fresh.x, rtol=1e-6, atol=1e-9)
    assert joined[-1].force == pytest.approx(alone[-1].force, abs=1e-6)


def test_jitter_of_the_stamps_is_followed(car: Model, gains: Gains) -> None:
    """Samples at uneven times: the true interval is integrated, not the nominal one."""
    n, fine = 1600, 10
    t = np.arange(n * fine) * DT / fine
    road = 2e-3 * np.sin(2 * np.pi * 15.0 * t)
    record = simulate(car, DT / fine, road, np.full(t.size, 0.3))
    pick = np.arange(0, t.size, fine)
    pick = pick + np.random.default_rng(7).integers(0, 6, pick.size)
    uneven = {name: values[pick] for name, values in record.items()}

    def error(times: Array) -> float:
        force = np.array([e.force for e in replay(gains, {**uneven, "t": times})])
        return float(np.sqrt(np.mean((force - uneven["damper_force"])[800:] ** 2)))

    assert error(uneven["t"]) < 0.15
    assert error(uneven["t"]) < 0.5 * error(np.arange(n) * DT)


def test_bad_first_samples_are_waited_out(gains: Gains, drive: Drive) -> None:
    """The observer starts with the first valid sample, whatever came before."""
    bad = [Sample(NAN, 1.0, 1.0, 0.1), Sample(0.0, NAN, 1.0, 0.1), Sample(DT, 1.0, NAN, 0.1)]
    good = [s._replace(t=s.t + 2 * DT) for s in drive(100)]
    state, estimates = run(gains, [*bad, *good])
    assert {e.status for e in estimates[:3]} == {Status.INVALID}
    assert estimates[3].status is Status.INITIALISING
    np.testing.assert_allclose(state.x, run(gains, drive(100))[0].x, rtol=1e-9, atol=1e-12)
    assert state.resets == 0


def test_bad_duty_is_repaired_and_said(gains: Gains, drive: Drive) -> None:
    """NaN keeps the duty before, too much is cut off; both are DEGRADED for a while."""
    state, _ = run(gains, drive(300))
    for duty, kept in ((NAN, 0.2), (1.7, 1.0), (-0.5, 0.0), (math.inf, 0.2)):
        after, estimate = step(gains, state, Sample(300 * DT, 0.5, 1.0, duty))
        assert after.duty == kept
        assert estimate.status is Status.DEGRADED
        assert "repaired" in estimate.reason


def test_rest_is_weak_with_field_and_fine_without(gains: Gains) -> None:
    """Pre-yield: at rest with full field the accelerometers do not see the deflection."""
    for duty, expected in ((1.0, Status.WEAK), (0.1, Status.WEAK), (0.0, Status.OK)):
        still = [Sample(DT * k, 0.0, 0.0, duty) for k in range(600)]
        estimate = run(gains, still)[1][-1]
        assert estimate.status is expected
        assert ("deflection" in estimate.reason) is (expected is Status.WEAK)


def test_wrong_start_stays_before_yield_and_goes_in_motion(gains: Gains) -> None:
    """The slow pole of the gains is real: 10 mm at rest, duty 1, decays at 0.52 1/s; without field at once.

    The start phase, whose gain is not constant, is no slower.
    """
    wrong = np.zeros(4)
    wrong[0] = 0.01
    left, constant = {}, replace(gains, opening=None)
    for name, duty, used in (("free", 0.0, gains), ("gain", 1.0, constant), ("all", 1.0, gains)):
        state = start(used, Sample(0.0, 0.0, 0.0, duty), wrong)
        seen = []
        for k in range(1, 601):
            state, _ = step(used, state, Sample(DT * k, 0.0, 0.0, duty))
            seen.append(abs(float(state.x[0])))
        left[name] = seen
    rate = {name: math.log(x[399] / x[599]) / (200 * DT) for name, x in left.items() if x[599]}
    assert rate["gain"] == pytest.approx(0.5245, rel=0.05)
    assert rate["all"] > 0.95 * 0.5245
    assert left["free"][199] < 1e-5


def test_weak_has_hysteresis(gains: Gains) -> None:
    """The status does not flicker where the decay rate hovers about the limit."""
    random = np.random.default_rng(9)
    samples = [Sample(DT * k, *random.normal(0.0, 0.05, 2), 0.05) for k in range(2000)]
    statuses = [e.status for e in run(gains, samples)[1]][400:]
    changes = sum(a is not b for a, b in zip(statuses[1:], statuses, strict=False))
    assert changes <= 6
    assert LIMITS.strong > LIMITS.weak


FAULTS = {
    "sprung sensor stuck": lambda s: s._replace(sprung_acceleration=3.0),
    "unsprung sensor stuck": lambda s: s._replace(unsprung_acceleration=3.0),
    "channels exchanged": lambda s: s._replace(
        sprung_acceleration=s.unsprung_acceleration, unsprung_acceleration=s.sprung_acceleration
    ),
    "wrong sign": lambda s: s._replace(sprung_acceleration=-s.sprung_acceleration),
}


def test_contradiction_is_low_when_all_is_well(gains: Gains, drive: Drive) -> None:
    """The test ratio stays below its gate with the right model and noise."""
    estimates = run(gains, drive(1200, 0.3))[1]
    assert max(e.test_ratio for e in estimates) < 0.7
    assert estimates[-1].status is Status.OK


@pytest.mark.parametrize("fault", sorted(FAULTS))
def test_contradiction_shows(gains: Gains, drive: Drive, fault: str) -> None:
    """Sensors that cannot be right raise the ratio above one and degrade the status."""
    broken = [FAULTS[fault](s) if i >= 600 else s for i, s in enumerate(drive(1200, 0.3))]
    late = run(gains, broken)[1][800:]
    assert np.median([e.test_ratio for e in late]) > 1.0
    assert Status.DEGRADED in {e.status for e in late}
    assert any("contradict" in e.reason for e in late)


numbers = st.floats(allow_nan=True, allow_infinity=True)


@settings(max_examples=60, deadline=None)
@given(st.lists(st.tuples(numbers, numbers, numbers, numbers), min_size=1, max_size=30))
def test_nothing_raises_and_nothing_infinite_comes_out(
    gains: Gains, drive: Drive, rows: list[tuple[float, float, float, float]]
) -> None:
    """Any four doubles, NaN and 1e308 included, mixed with good samples."""
    state = start(gains, Sample(*rows[0]))
    mixed = [Sample(*row) for row in rows[1:]] + drive(5)
    for sample in mixed:
        state, estimate = step(gains, state, sample)
        assert all(math.isfinite(v) for v in estimate[:3])
        assert math.isfinite(estimate.test_ratio)
        assert isinstance(estimate.status, Status)


def test_step_does_not_change_its_arguments(gains: Gains, drive: Drive) -> None:
    """Stepping twice from one state gives the same, bit by bit."""
    state, _ = run(gains, drive(50))
    before = state.x.copy()
    sample = Sample(50 * DT, 1.0, 2.0, 0.3)
    first, second = step(gains, state, sample)[0], step(gains, state, sample)[0]
    assert_same(first, second)
    np.testing.assert_array_equal(state.x, before)


def test_step_is_fast(gains: Gains, drive: Drive) -> None:
    """Well under the 5 ms of a sample: a tenth of a millisecond at the median, on any machine."""
    state, _ = run(gains, drive(20))
    durations = []
    for sample in drive(2000)[20:]:
        begun = time.perf_counter()
        state, _ = step(gains, state, sample)
        durations.append(time.perf_counter() - begun)
    assert np.median(durations) < 1e-4


def test_what_is_remembered_changes_nothing(gains: Gains) -> None:
    """Phi functions kept from earlier duties and steps give the bits that computing them again gives."""
    random, t, samples = np.random.default_rng(11), 0.0, []
    for _ in range(300):
        t += float(random.choice([0.005, 0.003]))
        duty = float(random.choice([0.0, 0.3, 0.7]))
        samples.append(Sample(t, *random.normal(size=2), duty))
    state, fresh = start(gains, samples[0]), start(replace(gains), samples[0])
    for sample in samples[1:]:
        state, _ = step(gains, state, sample)
        fresh, _ = step(replace(gains), fresh, sample)  # a new scratch remembers nothing
        assert np.array_equal(state.x, fresh.x)
