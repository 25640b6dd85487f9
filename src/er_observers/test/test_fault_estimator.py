"""The fault estimator: right fault, right size, none where there is none, and not silent about what is no fault."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import replace

import numpy as np
import pytest

pytest.importorskip("er_studies", reason="the whole workspace drives them")
from er_models.constants import SAMPLE_TIME as DT
from er_models.errors import InputError
from er_models.model import Array, Model
from er_models.simulation import initial_state, prepare, simulate
from er_models.simulation import step as step_car
from er_observers.faults import decision, evidence, follow, passage, regression, sums, tick
from er_observers.faults.estimator import start, step
from er_observers.faults.rules import RULES, Rules, estimator
from er_observers.faults.sample import Estimate, FactorStatus, Kind, Sample, Status
from er_studies.faults.trials import Drive, Trial, drive, faults
from scipy.stats import norm

SAME_AT_ONE_DUTY = ("field_saturation",)
"""Effects that are a weaker field and nothing else while the duty has one strength."""
NAMED = {"f1": Kind.ELECTRICAL, "f2": Kind.LEAKAGE, "f3": Kind.DEFORMATION}


def said(
    model: Model, samples: Sequence[Sample], force_noise: float | None = None, rules: Rules = RULES
) -> list[Estimate]:
    """Every estimate along the samples."""
    p = estimator(model, rules, force_noise)
    state = start(p, samples[0])
    found = [state.estimate]
    for sample in samples[1:]:
        state, estimate = step(p, state, sample)
        found.append(estimate)
    return found


@pytest.mark.parametrize(("factor", "left"), [("f1", 0.6), ("f2", 0.75), ("f3", 0.5)])
def test_a_fault_is_named_and_measured(car: Model, factor: str, left: float) -> None:
    trial = Trial(1004, {factor: left}, fault_time=6.0, duration=10.5)
    found = said(car, drive(trial, car).samples)
    begun = round(trial.fault_time / DT)
    assert all(e.kind in (Kind.UNKNOWN, Kind.NONE) for e in found[:begun])
    which = int(factor[1]) - 1
    after_2, last = found[begun + round(2.0 / DT)], found[-1]
    assert abs(after_2.factors[which] - left) < (0.05 if factor == "f2" else 0.1)
    assert last.kind is NAMED[factor]
    assert last.states[which] is FactorStatus.CONFIRMED
    assert abs(last.factors[which] - left) < 4.0 * last.deviations[which] + 0.01
    others = [last.states[i] for i in range(3) if i != which]
    assert others == [FactorStatus.HEALTHY] * 2
    assert not last.unexplained


def test_three_faults_at_once_are_told_apart(car: Model) -> None:
    left = {"f1": 0.7, "f2": 0.8, "f3": 0.6}
    trial = Trial(1004, left, fault_time=6.0, duration=11.0)
    last = said(car, drive(trial, car).samples)[-1]
    assert last.kind is Kind.COMBINED
    assert last.factors == pytest.approx(tuple(left.values()), abs=0.1)


@pytest.mark.parametrize("seed", [5000, 5001, 5002])
def test_a_healthy_damper_whose_model_is_off_is_healthy(car: Model, seed: int) -> None:
    found = said(car, drive(Trial(seed, spread=0.05, duration=8.0), car).samples)
    assert {e.kind for e in found} <= {Kind.UNKNOWN, Kind.NONE}
    assert found[-1].kind is Kind.NONE
    assert not any(e.unexplained for e in found)


def test_nothing_is_said_of_what_nothing_excites(car: Model) -> None:
    still = said(car, drive(Trial(1, still=True, duration=4.0), car).samples)[-1]
    assert still.states == (FactorStatus.NOT_EXCITED,) * 3
    passive = said(car, drive(Trial(1004, duty=0.0, duration=4.0), car).samples)[-1]
    assert passive.states[0] is FactorStatus.NOT_EXCITED
    assert passive.states[1:] == (FactorStatus.HEALTHY,) * 2


def test_a_fault_that_can_no_longer_be_seen_stays_the_last_one_known(car: Model) -> None:
    faulty = drive(Trial(1004, {"f1": 0.5}, fault_time=3.0, duration=7.0), car).samples
    begun = faulty[-1].t
    rest = [Sample(begun + DT * k, 0.0, 0.0, 0.0, 0.0, 0.0) for k in range(1, 1600)]
    last = said(car, [*faulty, *rest])[-1]
    assert last.kind is Kind.ELECTRICAL
    assert last.states[0] is FactorStatus.NOT_EXCITED
    assert last.factors[0] == pytest.approx(0.5, abs=0.05)


@pytest.mark.parametrize(
    "name",
    [
        "coulomb_friction",
        "bouc_wen_hysteresis",
        "fluid_inertia",
        "field_saturation",
        "varying_time_constant",
    ],
)
def test_what_is_no_fault_is_not_called_one_in_silence(car: Model, name: str) -> None:
    found = said(
        car, drive(Trial(7000, hidden={name: {}}, duration=8.0, road="iso8608"), car).samples
    )
    assert found[-1].unexplained
    assert found[-1].status is Status.UNEXPLAINED
    if name not in SAME_AT_ONE_DUTY:
        assert max(e.test_ratio for e in found) > 1.0
    assert not any(e.kind > Kind.NONE and not e.unexplained for e in found)
    assert FactorStatus.CONFIRMED not in {s for e in found for s in e.states}


@pytest.mark.parametrize("lasting", [10.0, 30.0, 100.0])
def test_what_disagrees_is_in_doubt_before_it_is_unexplained(car: Model, lasting: float) -> None:
    samples = drive(Trial(7000, duration=16.0, road="iso8608"), car).samples
    rubs = 1.0 / car.effects["quarter_car"]["m_s"]
    disturbed = [
        s._replace(sprung_acceleration=s.sprung_acceleration - rubs * math.copysign(1.0, s.deflection_velocity))
        if 6.0 < s.t - samples[0].t < 6.6 else s
        for s in samples
    ]  # fmt: skip
    found = said(car, disturbed, rules=replace(RULES, lasting=lasting))
    doubts = [k for k, e in enumerate(found) if e.status is Status.DEGRADED]
    unexplained = [k for k, e in enumerate(found) if e.unexplained]
    assert 6.0 < doubts[0] * DT < 7.5
    assert not any(FactorStatus.CONFIRMED in found[k].states for k in doubts)
    if lasting == 100.0:
        assert not unexplained
    else:
        assert (unexplained[0] - doubts[0]) * DT == pytest.approx(0.1 * lasting, abs=0.11)
    assert found[-1].status is Status.OK


def test_a_fading_field_is_a_loss_of_f1_and_named_so(car: Model) -> None:
    """(6.2) whatever takes the yield force: both effects act through the same hook, and give the same motion."""
    fade, fault = (car.catalogue[n] for n in ("effectiveness_fade", "electrical_fault"))
    assert set(fade.hooks) == set(fault.hooks) == {"yield_scale"}
    settled = {"s": 0.3, "t_f": 2.0}
    lost = {"f": 0.7, "t_0": 0.0, "t_r": 0.0, "q": 0.0, "d": 0.5}
    n = round(70.0 / DT)
    road = 1e-3 * np.cumsum(np.random.default_rng(1).standard_normal(n))
    road, duty = road - np.linspace(road[0], road[-1], n), np.full(n, 0.3)
    cars = (
        car.with_effect("effectiveness_fade", settled),
        car.with_effect("electrical_fault", lost),
    )
    ends = [simulate(each, DT, road, duty)["damper_force"][-400:] for each in cars]
    assert ends[0] == pytest.approx(ends[1], abs=1e-6)
    healthy = simulate(car, DT, road, duty)["damper_force"][-400:]
    assert float(np.max(np.abs(healthy - ends[1]))) > 1.0
    trial = Trial(7000, hidden={"effectiveness_fade": {"s": 0.3, "t_f": 5.0}}, duration=12.0)
    found = said(car, drive(replace(trial, road="iso8608"), car).samples)
    assert found[-1].kind is Kind.ELECTRICAL
    assert found[-1].states == (FactorStatus.CONFIRMED, *[FactorStatus.HEALTHY] * 2)
    assert not any(e.unexplained for e in found)
    assert found[-1].factors[0] == pytest.approx(
        1.0 - 0.3 * (1.0 - math.exp(-12.0 / 5.0)), abs=0.1
    )
    assert {e.kind for e in found} == {Kind.UNKNOWN, Kind.NONE, Kind.ELECTRICAL}


def test_a_measured_force_needs_no_body(car: Model) -> None:
    """A mass that is twice what is believed is nothing to an estimator that is given the force."""
    heavy = car.with_effect("quarter_car", {**car.effects["quarter_car"], "m_s": 4.5})
    samples = drive(Trial(1004, {"f2": 0.6}, fault_time=5.0, duration=9.0), heavy).samples
    last = said(car, samples, force_noise=0.15)[-1]
    assert last.kind is Kind.LEAKAGE
    assert last.factors[1] == pytest.approx(0.6, abs=0.05)
    assert said(car, samples)[-1].kind is not Kind.LEAKAGE or said(car, samples)[-1].unexplained


def test_bad_samples_change_a_status_and_nothing_else(car: Model) -> None:
    samples = drive(Trial(1004, duration=3.0), car).samples
    p = estimator(car)
    state = start(p, samples[0]._replace(deflection=math.nan))
    assert state.estimate.status is Status.INITIALISING
    for sample in samples[1:400]:
        state, _ = step(p, state, sample)
    kept = state.memory.copy()
    again, estimate = step(p, state, samples[399])
    assert np.array_equal(state.memory, kept)
    assert again.rejected == state.rejected + 1
    assert estimate == state.estimate
    lost = state
    for sample in samples[400:409]:
        broken = sample._replace(deflection=math.inf, sprung_acceleration=math.nan, duty=math.nan)
        lost, estimate = step(p, lost, broken)
        assert all(
            map(math.isfinite, (*estimate.factors, *estimate.deviations, estimate.residual))
        )
    assert estimate.status is Status.DEGRADED
    for sample in samples[409:420]:
        lost, estimate = step(p, lost, sample._replace(deflection=math.nan))
    assert estimate.status is Status.INVALID
    lost, estimate = step(p, lost, samples[420])
    assert estimate.status is not Status.INVALID
    assert lost.resets == 1
    far, estimate = step(p, lost, samples[421]._replace(t=1e6))
    assert far.resets == 2
    assert np.isfinite(far.memory[tick.MIND]).all()


def test_the_step_is_pure(car: Model) -> None:
    samples = drive(Trial(1004, duration=2.0), car).samples
    p = estimator(car)
    state = start(p, samples[0])
    for sample in samples[1:200]:
        state, _ = step(p, state, sample)
    kept = state.memory.copy(), state.window.copy()
    first, second = step(p, state, samples[200]), step(p, state, samples[200])
    assert np.array_equal(first[0].memory, second[0].memory)
    assert first[1] == second[1]
    assert np.array_equal(kept[0], state.memory)
    assert np.array_equal(kept[1], state.window)


def test_the_evidence_is_that_of_a_gaussian_regression() -> None:
    """Against the density of the observations themselves, integrated over the unknowns by NumPy."""
    random = np.random.default_rng(0)
    Phi, y = random.standard_normal((40, sums.N)), random.standard_normal(40)
    spread = random.uniform(0.3, 1.0, sums.N)
    total, prior = np.zeros(sums.SIZE), np.zeros(sums.SIZE)
    for phi, value in zip(Phi, y, strict=True):
        sums.add(total, phi, value, 1.0 / 0.25)
    prior[: sums.TRIANGLE] = np.diag(spread**-2)[np.tril_indices(sums.N)]
    room = np.zeros(2 * sums.N + sums.N**2)

    def density(shares: Sequence[float]) -> float:
        D = np.array([*shares, 1.0, 1.0, *[shares[2]] * 3])
        C = 0.25 * np.eye(40) + (Phi * D * spread**2) @ (Phi * D).T
        return float(-0.5 * (y @ np.linalg.solve(C, y) + np.linalg.slogdet(C)[1]))

    one, other = (1.0, 1.0, 1.0), (0.4, 0.7, 0.2)
    found = [evidence.log_evidence(total, prior, 1.0, np.array(s), room) for s in (one, other)]
    assert found[0] - found[1] == pytest.approx(density(one) - density(other), rel=1e-9)


def followed(car: Model, record: Drive) -> tuple[Array, Array]:
    """Errors of the motion (n, 2) with their deviations, and innovations over their deviations (n, 3)."""
    p, mind, rows = estimator(car), np.zeros(follow.SIZE), np.zeros((3, follow.ROW))
    first = record.samples[0]
    follow.begin(p.p, p.noise, first.deflection, math.nan, mind)
    rig = follow.Rig(p.p, p.noise, 0.0)
    belief = follow.Belief(p.first[: sums.N], 0.0, np.zeros(follow.BENDS))
    errors, found, duty = [], [], first.duty
    for s, true in zip(record.samples[1:], record.motion[1:], strict=True):
        seen = np.array([*s[1:5], math.nan])
        follow.advance(rig, belief, follow.Step(seen, duty, DT), mind, rows)
        duty = s.duty
        P = mind[follow.COVARIANCE].reshape(5, 5)
        errors.append((mind[follow.STATE][:2] - true) / np.sqrt(np.diag(P)[:2]))
        found.append(rows[:, sums.N] / np.sqrt(rows[:, sums.N + 1]))
    return np.array(errors)[100:], np.array(found)[100:]


def test_the_follower_knows_how_wrong_it_is_and_errs_on_its_own(car: Model) -> None:
    """A filter whose model is right has errors as large as it says, and innovations that are white."""
    errors, innovations = followed(
        car, drive(Trial(1005, duration=8.0, road="iso8608", straight=True), car)
    )
    assert np.all(np.abs(np.sqrt(np.mean(errors**2, axis=0)) - 1.0) < 0.2)
    assert np.all(np.abs(np.sqrt(np.mean(innovations**2, axis=0)) - 1.0) < 0.08)
    for each in innovations.T:
        assert abs(float(np.corrcoef(each[1:], each[:-1])[0, 1])) < 4.0 / math.sqrt(each.size)


def test_how_a_road_bends_is_learnt(car: Model) -> None:
    """A smooth one goes on as it did; one that is straight between samples does not bend at all."""
    trial, p = Trial(1005, duration=8.0, road="bumps"), estimator(car)
    for straight, bends in ((False, 1.0), (True, 0.0)):
        samples = drive(replace(trial, straight=straight), car).samples
        state = start(p, samples[0])
        for sample in samples[1:]:
            state, _ = step(p, state, sample)
        assert state.memory[tick.BENDS][0] == pytest.approx(bends, abs=0.3)
        assert state.memory[tick.BENDS][2] < 0.3


def test_the_derivatives_of_a_sample_are_those_of_its_end(car: Model) -> None:
    """By state, slope of the road's rate and unknowns, against differences; also without response time."""
    p = estimator(car).p.copy()
    known = np.array([0.9, 0.7, 0.5, 0.02, 0.1, 0.01, -0.01, 0.02])
    start = np.array([1e-3, 4e-3, 1.5, 3.0, 0.02])
    sizes = np.array([1e-6, 1e-5, 1e-4, 1e-3, 1e-5, 1e-2, *[1e-5] * 8])

    def end(z: Array, slope: float, unknowns: Array) -> tuple[Array, Array]:
        law, turn = np.empty(passage.LAW), np.empty((sums.N, passage.TURNED))
        # the share that errors of the gate are counted in stays as believed
        passage.prescribe(p, known, 0.3, DT, math.nan, law, turn)
        for i, by in enumerate(turn):
            law[: passage.TURNED] += by * (unknowns[i] - known[i])
        h = law[passage.PIECE]
        if p[regression.TAU] > 0.0:
            law[passage.KEPT] = math.exp(-h / law[passage.LAG])
            law[passage.MEAN] = (1.0 - law[passage.KEPT]) * law[passage.LAG] / h
        law[passage.SLOPE] = slope
        viscous = 0.25 * h * law[passage.STIFF] + 0.5 * law[passage.VISCOUS]
        law[passage.HALF] = h * law[passage.PER_MASS] * viscous + 0.25 * h * h * law[passage.TYRE]
        out, T = z.copy(), np.eye(5, passage.COLUMNS + sums.N)
        passage.sample(law, turn, out, T, T.shape[1])
        return out, T

    for tau in (p[regression.TAU], 0.0):
        p[regression.TAU] = tau
        _, T = end(start, 3.0, known)
        for j, size in enumerate(sizes):
            by = np.zeros(T.shape[1])
            by[j] = size
            z, slope, q = by[:5], by[passage.RAMP], by[passage.COLUMNS :]
            ends = [end(start + way * z, 3.0 + way * slope, known + way * q)[0] for way in (1, -1)]
            assert T[:, j] == pytest.approx((ends[0] - ends[1]) / (2.0 * size), rel=1e-3, abs=1e-6)


@pytest.mark.parametrize(("dt", "pieces"), [(DT, 16), (4.99e-3, 16), (1e-3, 4), (2e-4, 1)])
def test_a_sample_is_that_of_the_simulated_car(car: Model, dt: float, pieces: int) -> None:
    """The noise-free car one sample on, from any of its states; the two integrators differ by their own errors.

    A shorter sample has fewer pieces, none of them longer.
    """
    plant = prepare(car, dt)
    state, p = initial_state(plant), estimator(car)
    law, turn, T = np.empty(passage.LAW), np.empty((sums.N, passage.TURNED)), np.eye(5, 14)
    random, duty, gone = np.random.default_rng(3), 0.3, []
    for _ in range(400):
        height = state.road + dt / DT * 1e-3 * random.standard_normal()
        c, q, force = car.effects["quarter_car"], state.q, float(state.w[0])
        z = np.array([
            q[0], q[1] - q[3], force, -c["k_t"] * q[2] / c["m_us"], (height - state.road) / dt - q[1]
        ])  # fmt: skip
        passage.prescribe(p.p, p.first[: sums.N], duty, dt, math.nan, law, turn)
        assert int(law[passage.COUNT]) == pieces
        passage.sample(law, turn, z, T, 0)
        state, _ = step_car(plant, state, (height, duty))
        gone.append((z[0] - state.q[0], z[1] - (state.q[1] - state.q[3])))
    scale = np.array([1e-3, 0.1])
    assert np.all(np.sqrt(np.mean(np.array(gone) ** 2, axis=0)) < 2e-3 * scale)


def test_a_road_is_learnt_only_while_the_car_moves(car: Model) -> None:
    """A slow chirp: what noise said of its road made every bend possible, and a healthy damper was named faulty."""
    trial = Trial(800027, duration=60.0, spread=0.05, road="chirp", peak=0.282)
    p, samples = estimator(car), drive(trial, car).samples[: round(22.0 / DT)]
    state = start(p, samples[0])
    for sample in samples[1:]:
        state, estimate = step(p, state, sample)
        assert estimate.kind <= Kind.NONE
    assert state.memory[tick.BENDS][2] < 1.0


def test_doubt_waits_while_the_car_stands(car: Model) -> None:
    verdict, rules = decision.begin(), estimator(car).judging
    verdict[decision.RATIO] = 2.0
    while verdict[decision.DOUBTED] == 0.0:
        decision._doubt(rules, 1.0, verdict)
    for moved, doubted in ((0.0, 1.0), (0.5, 1.5), (1.0, 2.5)):
        decision._doubt(rules, moved, verdict)
        assert verdict[decision.DOUBTED] == doubted


@pytest.mark.parametrize("value", [-1.0, -0.3, 0.0, 0.6, 1.0, 1.1, 1.3])
@pytest.mark.parametrize("deviation", [0.01, 0.1, 1.0])
def test_a_factor_out_of_range_is_as_unlikely_as_a_gaussian_says(
    value: float, deviation: float
) -> None:
    """A tail held at 1e-12 let a fault with a share of 1.3 win against a healthy damper."""
    low, high = -value / deviation, (1.0 - value) / deviation
    low, high = (-high, -low) if low > 0.0 else (low, high)
    exact = norm.logcdf(high) + np.log1p(-np.exp(norm.logcdf(low) - norm.logcdf(high)))
    assert evidence.log_within(value, deviation) == pytest.approx(exact, rel=1e-3, abs=0.04)


def test_samples_after_a_change_are_followed_anew(car: Model) -> None:
    """Rows made for a healthy damper lead a faulty one astray: without, the factors err twice as much, and more."""
    p = estimator(car)
    setup = p.setup.copy()
    setup[tick.ANEW] = 0.0
    for each in faults("combined", 12, 3):
        trial = replace(each, straight=True)
        samples = drive(trial, car).samples[: round((trial.fault_time + 2.0) / DT)]
        errors = []
        for estimating in (p, replace(p, setup=setup)):
            state = start(estimating, samples[0])
            for sample in samples[1:]:
                state, estimate = step(estimating, state, sample)
            error = np.subtract(estimate.factors, tuple(trial.left.values()))
            errors.append(float(np.max(np.abs(error))))
        assert errors[0] < min(0.02, 0.5 * errors[1])


@pytest.mark.parametrize("seed", [1004, 7000])
def test_samples_followed_anew_do_not_run_across_a_gap(car: Model, seed: int) -> None:
    """A gap of 0.2 s in the first second: the motion before it says nothing of that after it."""
    samples, p = drive(Trial(seed, duration=2.0), car).samples, estimator(car)
    samples, worst = [*samples[:120], *samples[160:]], 0.0
    state = start(p, samples[0])
    for sample in samples[1:]:
        state, _ = step(p, state, sample)
        worst = max(worst, float(state.memory[tick.VERDICT][decision.MISFIT]))
    assert state.resets == 1
    assert 0.5 < worst < 1.5


@pytest.mark.parametrize("force", [1e4, 1e100, 1e300, -math.inf])
def test_a_force_beyond_belief_is_as_good_as_none(car: Model, force: float) -> None:
    """Once followed, it left a state of NaN until the next gap."""
    samples = drive(Trial(1004, duration=1.5), car).samples
    with_none, absurd = list(samples), list(samples)
    with_none[200] = samples[200]._replace(force=math.nan)
    absurd[200] = samples[200]._replace(force=force)
    noise = car.rig["force_noise"]
    assert said(car, absurd, noise) == said(car, with_none, noise)


def test_a_motion_that_is_no_number_begins_anew(car: Model) -> None:
    samples, p = drive(Trial(1004, duration=1.5), car).samples, estimator(car)
    state = start(p, samples[0])
    for k, sample in enumerate(samples[1:]):
        if k == 200:
            state.memory[tick.MIND][passage.V] = math.nan
        state, estimate = step(p, state, sample)
        assert np.isfinite(state.memory).all()
    assert (state.resets, estimate.kind) == (1, Kind.NONE)


def test_a_start_without_a_time_waits_for_one(car: Model) -> None:
    samples, p = drive(Trial(1004, duration=1.0), car).samples, estimator(car)
    state = start(p, samples[0]._replace(t=math.nan))
    for sample in samples[1:]:
        state, estimate = step(p, state, sample)
    assert (state.rejected, estimate.kind) == (1, Kind.NONE)


@pytest.mark.parametrize("rate", [100.0, 200.0, 1000.0])
def test_lessons_last_as_long_at_every_rate(car: Model, rate: float) -> None:
    setup = estimator(car, sample_time=1.0 / rate).setup
    blocks = RULES.memory * rate / tick.WITHIN
    assert setup[tick.KEPT] ** blocks == pytest.approx(math.exp(-1.0))
    assert setup[tick.FADING] * rate == pytest.approx(RULES.settle)


def test_a_model_that_is_no_such_car_is_refused(car: Model) -> None:
    with pytest.raises(InputError, match="quarter_car: expected a vehicle model"):
        estimator(
            replace(car, effects={k: v for k, v in car.effects.items() if k != "quarter_car"})
        )
    with pytest.raises(InputError, match="coulomb_friction"):
        estimator(car.with_effect("coulomb_friction"))


@pytest.mark.parametrize(("factor", "number"), [("f2", 15), ("f3", 6)])
def test_what_the_open_gate_errs_in_does_not_hide_the_fault(
    car: Model, factor: str, number: int
) -> None:
    """Drives on which rows that err alike left the fault 0.16 and 0.25 off."""
    trial = list(faults(factor, 1, number + 1))[number]
    samples = drive(trial, car).samples[: round((trial.fault_time + 5.0) / DT)]
    last, which = said(car, samples)[-1], int(factor[1]) - 1
    assert last.kind is NAMED[factor]
    assert last.factors[which] == pytest.approx(trial.left[factor], abs=0.03)
