"""The start phase: a wrong start is found in a tenth of a second, and the proved gain takes over unchanged."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

pytest.importorskip("er_studies", reason="the whole workspace drives them")
from er_models.errors import InputError
from er_models.program import Program, resolve
from er_models.simulation import history, initial_state, prepare
from er_observers.filters.flow import flow
from er_observers.observers.phi import phi_functions
from er_observers.observers.status import Status
from er_observers.opening import filter as start_filter
from er_observers.opening import phase as start_phase
from er_observers.running import runtime
from er_observers.running.runtime import Sample
from er_studies.observers.estimators import estimators_of
from er_studies.observers.nrmse import nrmse, settling_time
from er_studies.observers.run import follow as follow_record
from er_studies.observers.scenarios.drive import drive
from er_studies.observers.scenarios.files import choose_scenarios, load_scenarios
from er_studies.observers.scenarios.starts import NLPV

CONFIG = Path(__file__).resolve().parents[3] / "config"


@pytest.fixture(scope="module")
def record(car):
    """Three seconds of the noisy ISO road of chapter 5."""
    (s,) = choose_scenarios(load_scenarios(CONFIG / "scenarios"), ["chapter_5_noise"])
    return drive(replace(s, program=replace(s.program, duration=3.0)), car)


@pytest.mark.parametrize("name", ["nlpv_polytopic", "nlpv_gridding", "unified"])
def test_every_observer_settles_in_a_fifth_of_the_time(car, record, name):
    """From 10 mm wrong; without the phase the same gains need far longer and start 14 N wrong."""
    (e,) = [e for e in estimators_of(car, CONFIG / "gains") if e.name == name]
    x, t, true = e.form.chart @ NLPV, record["t"], record["damper_force"]
    found = follow_record(e, record, x)
    plain = follow_record(replace(e, parameters=replace(e.parameters, opening=None)), record, x)
    assert settling_time(t, true, found.force) < 0.5
    assert nrmse(true, found.force) < 0.4 * nrmse(true, plain.force)
    wrong = np.abs(found.force - true) > 0.02 * np.ptp(true)
    assert not np.any(wrong[t < 0.5] & (found.status[t < 0.5] == Status.OK))


@pytest.mark.parametrize("name", ["nlpv_polytopic", "nlpv_gridding", "unified"])
def test_a_car_that_really_starts_off_is_found(car, name):
    """10 mm and 5 N off, nothing told: the first sample counts once, not as a start and again as a measurement."""
    (e,) = [e for e in estimators_of(car, CONFIG / "gains") if e.name == name]
    road = {"kind": "iso8608", "road_class": "C", "peak_velocity": 0.15}
    plant, found = prepare(car, 0.005), []
    for seed in range(4):
        program = Program(road, {"kind": "constant", "level": 0.17}, 2.0, seed)
        ways, duty = resolve(program, car, 0.005).ride(0.005)
        begin = initial_state(plant, ways[0], 0.17, np.array([0.01, 0.0, 0.0, 0.0]))
        out = history(plant, begin, ways, duty)[2]
        assert out[0, 2] == pytest.approx(7.44, abs=0.01)  # of which the field has 4.8 N
        noise = 0.025 * np.random.default_rng(seed).standard_normal((out.shape[0], 2))
        rows = zip(0.005 * np.arange(out.shape[0]), *(out[:, :2] + noise).T, duty, strict=True)
        samples = [Sample(*map(float, row)) for row in rows]
        state = e.start(e.parameters, samples[0], None)
        force = [state.estimate.force]
        for sample in samples[1:]:
            state, estimate = e.step(e.parameters, state, sample)
            force.append(estimate.force)
        found.append(nrmse(out[:, 2], np.array(force)))
    assert np.mean(found) < 0.015


def test_it_ends_and_the_proved_gain_goes_on_from_there(gains, drive):
    samples = drive(400, 0.2)
    state, phases = runtime.start(gains, samples[0]), []
    for sample in samples[1:]:
        before = state
        state, _ = runtime.step(gains, state, sample)
        phases.append(state.P is not None)
        if before.P is None:
            free = runtime.step(replace(gains, opening=None), before, sample)[0]
            assert np.array_equal(free.x, state.x)
    assert phases[0]
    assert not phases[-1]
    assert sorted(phases, reverse=True) == phases


def test_the_doubt_grows_over_a_gap_and_the_prior_is_the_envelope(gains):
    o = gains.opening
    assert np.sqrt(np.diag(o.prior))[:2] == pytest.approx([0.010, 0.1])
    assert o.cost @ [1e-3, 0.0, 0.0, 0.0] == pytest.approx(-1.396)  # k_s times a millimetre
    x, P = start_phase.follow(o, np.zeros(4), o.prior, 0.2, 0.0, np.zeros(2))
    assert P[0, 0] < o.prior[0, 0]
    blind = start_phase.follow(o, x, P, 0.2, 0.005, np.full(2, np.nan))[1]
    seen = start_phase.follow(o, x, P, 0.2, 0.005, np.zeros(2))[1]
    assert blind[2, 2] > P[2, 2]
    assert np.all(np.linalg.eigvalsh(blind - seen) > -1e-12)
    assert start_phase.finished(o, 1e-6 * P)
    assert not start_phase.finished(o, P)


def test_a_start_beyond_the_envelope_is_refused_in_one_line(gains):
    """30 mm, 0.3 m/s and what belongs to them; the filter would call OK what it has not found. No number is none."""
    rest, far = Sample(0.0, 0.0, 0.0, 0.2), start_phase.FARTHEST * gains.spread
    assert runtime.start(gains, rest, far).P is not None
    assert runtime.start(gains, rest, -far).P is not None
    for i, name in enumerate(gains.form.states):
        for wrong in (1.001 * far[i], -1.001 * far[i], math.nan):
            x = np.zeros(4)
            x[i] = wrong
            with pytest.raises(InputError, match=r"start: x: .*: expected -.*, found ") as refused:
                runtime.start(replace(gains, opening=None), rest, x)
            assert name in str(refused.value)
            assert f"{wrong:.6g}" in str(refused.value)
    with pytest.raises(InputError, match="shape"):
        runtime.start(gains, rest, np.zeros(3))


def test_samples_that_are_missing_do_not_end_it(gains):
    rest = Sample(0.0, 0.1, -0.2, 0.2)
    state = runtime.start(gains, rest)
    for k in range(1, 5):
        gap = Sample(0.005 * k, float("nan"), 0.0, 0.2)
        state, estimate = runtime.step(gains, state, gap)
        assert state.P is not None
        assert np.isfinite(estimate.force)
    state, _ = runtime.step(gains, state, rest._replace(t=0.025))
    assert state.P is not None
    assert state.estimate.status is not Status.OK


def test_its_filter_has_the_mean_and_covariance_of_many_samples(gains):
    """Where the gate bends, the mean moves, and a linearised filter would not know; points that reach far see it
    coarsely where the spread is small. Without field all is linear."""
    o, h = gains.opening, 0.0025
    phi = phi_functions(h * o.A)
    kick, nothing = h * (phi[1] @ o.B), np.zeros((4, 4))
    x, P = np.array([0.0, 3e-3, 0.0, 0.0]), np.diag(np.square([1e-3, 4e-3, 1e-5, 0.1]))
    many = np.random.default_rng(1).multivariate_normal(x, P, 20000)
    centre, mean, spread = x.copy(), x.copy(), P.copy()
    for row in (centre, *many):
        flow(phi[0], kick, o.Gamma, 1.0, row)
    start_filter.predict(phi[0], kick, o.Gamma, nothing, 1.0, mean, spread)
    true = many.mean(axis=0)
    assert abs(mean[3] - true[3]) < 0.5 * abs(centre[3] - true[3])
    assert np.sqrt(np.diag(spread)) == pytest.approx(many.std(axis=0), rel=0.3)
    mean, spread = x.copy(), P.copy()
    start_filter.predict(phi[0], kick, o.Gamma, o.noise, 0.0, mean, spread)
    assert mean == pytest.approx(phi[0] @ x, abs=1e-12)
    assert spread == pytest.approx(phi[0] @ P @ phi[0].T + o.noise, rel=1e-9, abs=1e-18)


def test_its_filter_blames_a_road_that_is_rougher_than_thought(gains):
    """A wheel thrown up by a step moves the tyre, not the deflection that was nearly known."""
    o, x = gains.opening, np.zeros(4)
    P = np.diag(np.square([1e-4, 1e-2, 1e-4, 0.1]))
    thrown = o.C @ [0.0, 0.0, -0.005, 0.0]
    expected = np.array([0.0, 0.0, -0.005, 0.0])
    found, after = start_phase.follow(o, x, P, 0.2, 0.005, thrown)
    calm, usual = start_phase.follow(o, x, P, 0.2, 0.005, 0.0 * thrown)
    assert after[0, 0] >= usual[0, 0]
    assert abs((found - expected)[2]) < 1e-5
    assert gains.opening.cost @ (found - calm - expected) == pytest.approx(0.0, abs=0.2)
