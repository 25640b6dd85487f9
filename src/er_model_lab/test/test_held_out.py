"""What is held out: nothing that only the held-out samples could have taught."""

import itertools

import numpy as np
import pytest
from er_model_lab.problem.held_out import STRETCHES, every_third, spared_stretches, split
from er_model_lab.residual.errors import errors
from er_model_lab.results.diagnosis import unseen
from er_models.files import load_model
from er_models.prediction import Motion, join, motion, predict
from er_records.dataset import Dataset
from er_records.record import Record
from lab_help import FORCE_NOISE, GUO, imposed, problem_of

import er_model_lab as lab

N = 4000
DT = 0.005


def parts() -> list[tuple[int, int]]:
    return list(itertools.pairwise(np.linspace(60, N, STRETCHES + 1).astype(int).tolist()))


def moved(far: dict[str, int], seed: int = 0) -> Motion:
    """A random drive whose deflection, velocity or duty goes furthest in one stretch each."""
    rng = np.random.default_rng(seed)
    signals = {name: np.tanh(rng.standard_normal(N)) for name in ("x", "v", "u")}
    signals["u"] = 0.1 + 0.05 * signals["u"]
    for name, place in far.items():
        i, j = parts()[place]
        signals[name][i + 100 : j - 100] *= 2.0
    x, v, u = (signals[name] for name in ("x", "v", "u"))
    return motion(DT, x, v, u)


@pytest.mark.parametrize("far", [{"x": 2, "v": 5, "u": 8}, {"x": 5, "v": 5, "u": 2}, {"v": 8}])
def test_what_only_one_stretch_shows_is_learnt_from(far):
    drive = moved(far)
    chosen = spared_stretches(drive, parts())
    assert len(set(chosen)) == 3
    assert not set(chosen) & set(far.values())
    _, held = split(drive)
    for name in far:
        signal = np.abs(getattr(drive, name))
        assert signal[held].max() < 0.7 * signal[~held].max()


def test_where_all_stretches_are_alike_every_third_is_held_out():
    one = moved({})
    length = (N - 60) // STRETCHES
    x, v, u = (np.resize(y[60 : 60 + length], N) for y in (one.x, one.v, one.u))
    alike = motion(DT, x, v, u)
    assert spared_stretches(alike, parts()) == every_third(STRETCHES)


@pytest.mark.parametrize(("larger", "notes"), [(1.2, 0), (2.0, 1)])
def test_more_left_of_the_held_out_data_than_of_the_others_is_said(larger, notes):
    _, problem = problem_of(None, {}, seed=2, seconds=8.0)
    left = np.where(problem.held_out, 0.2 * larger, 0.2) * (-1.0) ** np.arange(problem.force.size)
    rows = {"train": problem.train, "held_out": problem.held_out}
    said = unseen({name: errors(problem, left, mask).rmse for name, mask in rows.items()})
    assert len(said) == notes
    assert all("0.4 N" in note and "0.2 N" in note for note in said)


def test_a_standstill_is_not_held_out_though_the_rest_reaches_further():
    drive = moved({})
    still = np.concatenate([np.arange(*parts()[b]) for b in (0, 2, 3, 5)])
    v, x = drive.v.copy(), drive.x.copy()
    v[still], x[still] = 0.0, 0.0
    chosen = spared_stretches(motion(DT, x, v, drive.u), parts())
    assert sum(b in (0, 2, 3, 5) for b in chosen) <= 1


def test_a_motion_that_is_not_measured_is_split_evenly():
    _, held = split(moved({"v": 2}), evenly=True)
    middles = [sum(parts()[b]) // 2 for b in every_third(STRETCHES)]
    assert held[middles].all()
    assert held.sum() < 3 * N / STRETCHES


def test_no_record_that_alone_reaches_far_is_held_out():
    """Three records, each furthest in something: a stop that one of them alone touches must be learnt."""
    t = np.arange(2000) * DT
    runs = []
    for size, rate, duty in ((1.0, 2.0, 0.1), (0.6, 6.0, 0.2), (0.9, 1.0, 0.3)):
        w = 2.0 * np.pi * rate
        runs.append(
            motion(
                DT,
                0.01 * size * np.sin(w * t),
                0.01 * size * w * np.cos(w * t),
                np.full(t.size, duty),
            )
        )
    _, held = split(join(runs))
    assert [
        bool(held[i:j].any() and not held[i:j].all())
        for i, j in ((0, 2000), (2000, 4000), (4000, 6000))
    ] == [True] * 3
    alike = [
        motion(DT, k * m.x, k * m.v, m.u)
        for k, m in ((1.0, runs[0]), (0.97, runs[0]), (0.98, runs[0]))
    ]
    _, held = split(join(alike))
    assert held[2200:3900].all()


def test_the_model_stays_as_given_where_what_is_learnt_errs_more_on_held_out_data():
    """Training runs whose load cell read 1.3 times the force; another run with the truth, which the model holds."""
    rng, model = np.random.default_rng(5), load_model(GUO)

    def run(name, gain, n):
        x, v, a, u = imposed(rng, n)
        force = gain * predict(model, motion(DT, x, v, u, a)) + FORCE_NOISE * rng.standard_normal(
            n
        )
        given = {"deflection": x, "deflection_velocity": v, "duty": u, "damper_force": force}
        return Record(name, np.arange(n) * DT, given)

    data = Dataset.of([run("wrong", 1.3, 2400)], [run("right", 1.0, 1200)])
    result = lab.improve(data, model, seed=1)
    found = result.to_dict()
    assert result.model.effects == model.effects
    assert found["effects"] == []
    assert found["verdict"] in ("insufficient_data", "adequate")
    assert found["rmse_after"]["held_out"] == pytest.approx(found["rmse_as_given"], rel=1e-9)
    assert found["rmse_after"]["held_out"] == pytest.approx(FORCE_NOISE, rel=0.1)
    assert any(
        note.startswith("the model stays as it was given: on held-out data it errs by")
        for note in found["notes"]
    )
