"""With a deflection sensor: the balance of the body and the model, fused; what is promised holds for any damper."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("er_studies", reason="the whole workspace drives them")
from er_observers.observers import fusion
from er_observers.observers.pooled import pooled
from er_observers.observers.status import ALONE, VERDICTS, WRONG, Status
from er_observers.running import runtime
from er_observers.running.ready import ready
from er_observers.running.runtime import Sample
from er_studies.observers.classes import scenario, with_noise
from er_studies.observers.nrmse import nrmse
from er_studies.observers.scenarios.drive import drive as ridden
from er_studies.observers.scenarios.files import load_scenario

CONFIG = Path(__file__).resolve().parents[3] / "config"
NAMES = (
    "t",
    "told_sprung_acceleration",
    "told_unsprung_acceleration",
    "told_duty",
    "told_deflection",
)


@pytest.fixture(scope="module")
def rides(car):
    """Records of class A, by case."""
    return {
        case: ridden(with_noise(scenario("A", case, 7101, 8.0), 20.0), car)
        for case in ("healthy", "f2", "heavy")
    }


def samples_of(record, **changed):
    columns = {name: record[name] for name in NAMES} | changed
    return [Sample(*row) for row in zip(*(columns[name].tolist() for name in NAMES), strict=True)]


def followed(gains, samples):
    """Estimates, and the memory of the fusion after each sample."""
    state = runtime.start(gains, samples[0])
    estimates, memories = [state.estimate], [state.memory[state.layout.fusion].copy()]
    for sample in samples[1:]:
        state, estimate = runtime.step(gains, state, sample)
        estimates.append(estimate)
        memories.append(state.memory[state.layout.fusion].copy())
    return estimates, np.array(memories)


def test_errors_on_a_smooth_road(gains, rides):
    """Healthy and with a leak of two fifths, where the accelerometers alone leave ten times as much."""
    for case, most in (("healthy", 0.0022), ("f2", 0.003)):
        record, rows = rides[case], rides[case]["t"] >= 2.0
        force = np.array([e.force for e in followed(gains, samples_of(record))[0]])
        assert nrmse(record["damper_force"][rows], force[rows]) < most
    alone = followed(replace(gains, sensors=None), samples_of(rides["f2"]))[0]
    assert nrmse(record["damper_force"][rows], np.array([e.force for e in alone])[rows]) > 0.01


def test_what_is_promised_holds_for_anything(gains):
    """No damper made these samples: the force stays within four deviations of the balance, whatever comes."""
    random, n = np.random.default_rng(5), 600
    t, waves = 0.005 * np.arange(n), ((12.6, 5e-3, 0.0), (44.0, 1e-3, 1.0))
    x = np.sum([a * np.sin(w * t + p) for w, a, p in waves], axis=0)
    bent = np.sum([-w * w * a * np.sin(w * t + p) for w, a, p in waves], axis=0)
    sprung = np.cumsum(random.normal(size=n))
    duty = random.uniform(0.0, 0.3, n)
    samples = [Sample(t[k], sprung[k], sprung[k] - bent[k], duty[k], x[k]) for k in range(n)]
    estimates, w = followed(gains, samples)
    p, mass = gains.fused, w[:, fusion.THETA] * gains.fused[fusion.M_S]
    band = 4.0 * np.hypot(mass * p[fusion.NOISE_A], p[fusion.K_S] * w[:, fusion.NOISE])
    balance = -mass * sprung - p[fusion.K_S] * x
    fused = w[:, fusion.TRUST] == fusion.BELIEVED
    force = np.array([e.force for e in estimates])
    assert fused.sum() > 50
    assert np.all(np.abs(force - balance)[fused] <= band[fused] * (1.0 + 1e-9) + 1e-9)


@pytest.mark.parametrize("what", ["hangs", "jumps", "is missing"])
def test_a_sensor_that_is_wrong_is_refused_at_once(gains, rides, what):
    """From the third sample at the latest the accelerometers answer, as if there had never been a sensor."""
    record, begin, end = rides["healthy"], 800, 1000
    x = record["told_deflection"].copy()
    x[begin:end] = {"hangs": x[begin], "jumps": x[begin:end] + 1e-3, "is missing": np.nan}[what]
    estimates, w = followed(gains, samples_of(record, told_deflection=x))
    alone = followed(replace(gains, sensors=None), samples_of(record))[0]
    late = begin + (8 if what == "hangs" else 0)
    assert np.all(w[late:end, fusion.TRUST] == fusion.REFUSED)
    for mine, theirs in zip(estimates[late:end], alone[late:end], strict=True):
        assert mine.force == theirs.force
        assert (mine.status, mine.reason) == VERDICTS[ALONE] or theirs.status is not Status.OK
    error = np.array([e.force for e in estimates]) - record["damper_force"]
    assert np.abs(error[begin : end + 200]).max() < 0.5
    assert estimates[-1].status in (Status.OK, Status.DEGRADED)


def test_without_a_deflection_nothing_changes(gains, rides):
    """Bit for bit: the two accelerometers are what runs where no deflection comes."""
    blind = samples_of(
        rides["healthy"], told_deflection=np.full(rides["healthy"]["t"].size, np.nan)
    )
    assert followed(gains, blind)[0] == followed(replace(gains, sensors=None), blind)[0]


def test_a_load_is_found_and_a_leak_is_none(gains, rides):
    """A fifth more mass within two hundredths; two fifths of the oil's force gone leave the mass where it was."""
    assert followed(gains, samples_of(rides["heavy"]))[1][-1, fusion.THETA] == pytest.approx(
        1.2, abs=0.04
    )
    assert followed(gains, samples_of(rides["f2"]))[1][-1, fusion.THETA] == pytest.approx(
        1.0, abs=0.01
    )
    fixed = replace(gains, payload=False)
    assert followed(fixed, samples_of(rides["heavy"]))[1][-1, fusion.THETA] == 1.0


def test_a_rough_sensor_is_no_load(gains, car):
    """200 um of noise on a smooth road: what the noise adds to the velocity's power is taken off, and no more."""
    record = ridden(with_noise(scenario("A", "healthy", 7101, 12.0), 200.0), car)
    loads = followed(gains, samples_of(record))[1][:, fusion.THETA]
    assert np.abs(loads - 1.0).max() < 0.005


@pytest.mark.parametrize(("case", "agree"), [("healthy", True), ("f1", False)])
def test_both_forces_count_while_they_agree(car, case, agree):
    """A sensor of 200 um leaves more than the accelerometers alone on a healthy damper, and far less under a fault."""
    gains = ready(CONFIG / "gains" / "unified.yaml", car, "unified")
    record = ridden(with_noise(scenario("D", case, 7103, 12.0), 200.0), car)
    rows = record["t"] >= 2.0
    estimates, memories = followed(gains, samples_of(record))
    alone = followed(replace(gains, sensors=None), samples_of(record))[0]
    p, told = gains.fused, zip(memories, samples_of(record), strict=True)
    fused = [fusion._answer(p, w, s.sprung_acceleration, s.deflection)[1] for w, s in told]
    forces = [[e.force for e in estimates], [e.force for e in alone], fused]
    both, one, other = (nrmse(record["damper_force"][rows], np.array(f)[rows]) for f in forces)
    assert (one < 0.7 * other) is agree
    assert both < 1.05 * min(one, other)
    if not agree:
        assert 3.0 * other < one
        assert np.array_equal(np.array(forces[0])[rows], np.array(fused)[rows])


def test_a_filter_without_variance_keeps_its_force(gains):
    """Rounding may take a covariance to zero and below: what was found stays, and is a number."""
    w, found = fusion.begin(), (True, 3.0, 1e-3, 0.1)
    for variance in (0.0, -1e-18):
        w[fusion.P33] = variance
        assert pooled(gains.fused, w, found, 5.0, 0.0, 0.0, 0.005) == found


def test_the_noise_of_a_velocity_behind_the_band(gains):
    """White noise through the band as it stands, by its own differences."""
    p, w, dt = gains.fused, fusion.begin(), 0.005
    w[fusion.NOISE] = 1e-4
    noise = np.random.default_rng(3).normal(0.0, 1e-4, 200_000)
    out = np.array([fusion._filtered(p, w, fusion.FILTERS, x, dt) for x in noise])
    seen = np.mean((p[fusion.C_0] * (out[:, 1] - out[:, 0]) / dt) ** 2)
    # the high passes take 6 %
    assert seen == pytest.approx(fusion._speed_noise(p, w, dt), rel=0.08)


def reasons(gains, record, **changed):
    """When, and as what, estimates from 1 s on are told as degraded: the first time of each reason [s]."""
    found = {}
    estimates = followed(gains, samples_of(record, **changed))[0]
    for t, e in zip(record["t"], estimates, strict=True):
        if t > 1.0 and e.status is Status.DEGRADED:
            found.setdefault(e.reason, t)
    return found


@pytest.mark.parametrize(("road", "most"), [("A", 0.5), ("B", 0.5), ("C", 1.2)])
def test_an_accelerometer_that_drifts_off_is_doubted(gains, car, road, most):
    """3 m/s2 more than there is, from 3 s on, of either accelerometer; and never without."""
    record = ridden(with_noise(scenario(road, "healthy", 7102, 6.0), 20.0), car)
    assert reasons(gains, record) == {}
    for name in NAMES[1:3]:
        off = record[name] + np.where(record["t"] >= 3.0, 3.0, 0.0)
        found = reasons(gains, record, **{name: off})
        assert 3.0 < found[VERDICTS[WRONG][1]] < 3.0 + most


@pytest.mark.parametrize("name", ["experiment_bumps", "chapter_3_chirp", "chapter_4_step"])
def test_no_bump_or_chirp_is_a_wrong_accelerometer(gains, car, name):
    for s in load_scenario(CONFIG / f"scenarios/{name}.yaml"):
        assert VERDICTS[WRONG][1] not in reasons(gains, ridden(with_noise(s, 20.0), car))


def test_a_silence_does_not_refuse_the_sensor(gains, rides):
    """The sensor answers with the first sample after half a second of which nothing is known."""
    samples = samples_of(rides["healthy"])
    state = runtime.start(gains, samples[0])
    for sample in samples[1:600]:
        state, _ = runtime.step(gains, state, sample)
    state = runtime.lose(gains, state, samples[600].t)
    for sample in samples[700:720]:
        state, estimate = runtime.step(gains, state, sample)
        assert estimate.status is Status.OK


def test_time_that_goes_back_forgets_what_was_learnt(gains, rides):
    """A recording that loops gives the same answers again."""
    samples = samples_of(rides["heavy"])[:600]
    once = followed(gains, samples)[0]
    twice = followed(gains, [*samples, *samples])[0]
    assert [e.force for e in twice[600:]] == [e.force for e in once]
