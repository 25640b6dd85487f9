"""The level of the vehicle: records that begin in motion, what is knowable of a car, friction beside the damper."""

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from er_model_lab.cli.app import app
from er_model_lab.diagnosis.candidates import baseline, refit
from er_model_lab.diagnosis.noise_floor import noise_floor
from er_model_lab.diagnosis.null import simulate_null
from er_model_lab.fitting.deviations import with_deviations
from er_model_lab.fitting.envelope import with_unfelt
from er_model_lab.level.car_outputs import confounded
from er_model_lab.preflight.check import findings
from er_model_lab.preflight.usable_channels import use_findings
from er_model_lab.problem import stretches
from er_model_lab.problem.held_out import FOLDS
from er_model_lab.vehicle.ride import SETTLE
from er_model_lab.vehicle.ride_problem import open_ride
from er_models.errors import InputError
from er_models.files import load_model, save_model
from er_models.simulation import simulate
from er_records.dataset import Dataset
from er_records.missing_channels import NO_DUTY
from er_records.record import Record
from scipy.integrate import solve_ivp
from typer.testing import CliRunner

from er_model_lab import add

CAR = Path(__file__).resolve().parents[3] / "config" / "vehicles" / "inove_quarter_car.yaml"
DT, LEAD = 0.005, 200
NOISE = {
    "damper_force": 0.15, "sprung_acceleration": 0.025, "unsprung_acceleration": 0.025, "deflection": 2e-5,
    "deflection_velocity": 1e-3,
}  # fmt: skip
FRICTION = {"F_g": 0.8, "v_0": 0.003}


def ride(seed=1, seconds=14.0, truth=None, without=(), finer=1):
    """A record of a car on sines of road that was in motion before, with noise on every output.

    finer: straight lines of road in a sample; many are a smooth road.
    """
    rng, n = np.random.default_rng(seed), round(seconds / DT) + LEAD
    t = np.arange(n * finer) * (DT / finer)
    f = np.array([1.1, 1.9, 2.7, 3.6, 4.6, 6.1])
    phase = np.multiply.outer(t, 2 * np.pi * f) + rng.uniform(0, 2 * np.pi, f.size)
    road = np.sin(phase) @ (0.012 / f) * np.minimum(t / 0.5, 1.0)
    duty = np.repeat(rng.choice([0.0, 0.1, 0.2, 0.3], n // 150 + 1), 150)[:n]
    run = simulate(truth or load_model(CAR), DT / finer, road, np.repeat(duty, finer))
    channels = {c: run[c][::finer] + sd * rng.standard_normal(n) for c, sd in NOISE.items()}
    channels |= {"road": road[::finer], "duty": duty}
    kept = {c: y[LEAD:] for c, y in channels.items() if c not in without}
    return Record(f"ride {seed}", t[LEAD * finer :: finer], kept)


def active(seed=1, seconds=8.0, truth=None):
    """A ride with an actuator beside the damper and heights of body and wheel; SciPy integrates (2.1)-(2.5), (1.22)."""
    rng, model = np.random.default_rng(seed), truth or load_model(CAR)
    c, d, g = (model.effects[name] for name in ("quarter_car", "passive", "guo_yield"))
    tau, extra = model.value("response", "tau"), model.effects.get("guide_friction")
    n = round(seconds / DT)
    t, f = DT * np.arange(n), np.array([1.3, 2.2, 3.1, 4.4])
    road = np.sin(np.multiply.outer(t, 2 * np.pi * f) + rng.uniform(0, 6.0, 4)) @ (0.006 / f)
    force = 3.0 * np.sin(np.multiply.outer(t, 2 * np.pi * f[::-1] * 1.17)) @ np.ones(4) / 2.0
    duty = np.repeat(rng.choice([0.0, 0.1, 0.3], n // 100 + 1), 100)[:n]

    def rate(s, y, k):
        z_s, z_us, v_s, v_us, f_y = y
        x, v, share = z_s - z_us, v_s - v_us, s / DT - k
        f_a, z_r = ((1 - share) * w[k] + share * w[min(k + 1, n - 1)] for w in (force, road))
        gate = g["f_c"] * duty[k] * np.tanh(g["k1"] * x + g["c1"] * v)
        f_d = d["k0"] * x + d["c0"] * v + f_y
        f_g = extra["F_g"] * np.tanh(v / extra["v_0"]) if extra else 0.0
        pull, tyre = c["k_s"] * x + f_d + f_a + f_g, c["k_t"] * (z_us - z_r)
        return [v_s, v_us, -pull / c["m_s"], (pull - tyre) / c["m_us"], (gate - f_y) / tau], f_d

    y, rows = np.array([road[0], road[0], 0.0, 0.0, 0.0]), []
    for k in range(n):
        slope, f_d = rate(t[k], y, k)
        rows.append((y[0] - y[1], y[0], y[1], f_d, slope[2]))
        end = solve_ivp(
            lambda s, y, k=k: rate(s, y, k)[0],
            (t[k], t[k] + DT),
            y,
            method="LSODA",
            rtol=1e-8,
            atol=1e-11,
        )
        y = end.y[:, -1]
    names = (
        "deflection",
        "sprung_displacement",
        "unsprung_displacement",
        "damper_force",
        "sprung_acceleration",
    )
    noise = {**NOISE, "sprung_displacement": 3e-5, "unsprung_displacement": 3e-5}
    clean = dict(zip(names, np.array(rows).T, strict=True))
    channels = {k: v + noise[k] * rng.standard_normal(n) for k, v in clean.items()}
    return Record(
        f"active {seed}", t, channels | {"road": road, "duty": duty, "actuator_force": force}
    )


def test_a_car_with_an_actuator_is_compared_and_leaves_its_noise(tmp_path):
    import json

    record, found = active(), tmp_path / "r.json"
    noise = {**NOISE, "sprung_displacement": 3e-5, "unsprung_displacement": 3e-5}
    words = ("--model", CAR, "--level", "vehicle", "--json", found)
    assert lab("compare", write(tmp_path / "a.csv", record), *words).exit_code == 0
    channels = json.loads(found.read_text())["channels"]
    assert {*channels} == {*record.channels} - {"road", "duty", "actuator_force"}
    for name, entry in channels.items():
        assert entry["rmse"] == pytest.approx(noise[name], rel=0.08), name
    assert channels["sprung_displacement"]["unit"] == "m"
    left = {k: v for k, v in record.channels.items() if k != "actuator_force"}
    assert (
        lab("compare", write(tmp_path / "b.csv", replace(record, channels=left)), *words).exit_code
        == 0
    )
    without = json.loads(found.read_text())["channels"]["sprung_displacement"]["rmse"]
    assert without > 10.0 * noise["sprung_displacement"]


def test_with_an_actuator_a_spring_is_fitted_and_friction_beside_the_damper_added(tmp_path):
    record = active(seconds=5.0, truth=hidden())
    car = load_model(CAR)
    softer = {**car.effects["quarter_car"], "k_s": 1300.0}
    given = replace(car, effects={**car.effects, "quarter_car": softer})
    one = add(Dataset.of([record]), given, "guide_friction", level="vehicle")
    assert one.model.value("quarter_car", "k_s") == pytest.approx(1396.0, rel=0.01)
    assert one.model.value("guide_friction", "F_g") == pytest.approx(FRICTION["F_g"], rel=0.05)
    assert one.to_dict()["parameters"]["quarter_car"]["k_s"]["bounds"] == [650.0, 2600.0]


def test_where_only_some_records_have_an_actuator_it_counts_as_none_in_the_others():
    problem, _ = open_ride(Dataset.of([active(seconds=4.0), ride(seconds=5.0)]), load_model(CAR))
    assert "actuator_force counts as 0 in 1 of 2 records, which lack it" in problem.notes
    assert not problem.forward.courses[1].beside.any()


def hidden():
    return load_model(CAR).with_effect("guide_friction", FRICTION)


@pytest.fixture(scope="module")
def opened():
    return open_ride(Dataset.of([ride()]), load_model(CAR))


def test_a_record_that_begins_in_motion_leaves_its_noise_alone(opened):
    problem, fitted = opened
    forward = problem.forward
    assert forward.names == tuple(NOISE)
    for c, name in enumerate(forward.names):
        left = fitted.residual[c :: len(forward.names)][problem.used[c :: len(forward.names)]]
        assert np.std(left) / forward.weights[c] == pytest.approx(NOISE[name], rel=0.06)
        assert forward.noise[c] == pytest.approx(NOISE[name], rel=0.2)
    at_rest = replace(forward, starts=0.0 * forward.starts, slopes=(), pulls=())
    rows = at_rest.weighted(at_rest.ride(fitted.model)[1][None])[0]
    first = slice(0, round(0.1 / DT) * forward.outputs)
    assert np.std((problem.force - rows)[first]) > 2.0 * np.std(fitted.residual[first])


def test_a_ride_too_short_for_its_blocks_to_settle_is_refused():
    short = ride(seconds=2.0)
    with pytest.raises(InputError, match=r"expected 3 s at least, with 100 samples to fit"):
        open_ride(Dataset.of([short]), load_model(CAR))
    folds = open_ride(Dataset.of([ride(seconds=3.5)]), load_model(CAR))[0].fold
    assert np.unique(folds[folds >= 0]).size == FOLDS


def test_what_of_long_and_uneven_rides_is_not_used_is_said(monkeypatch):
    monkeypatch.setattr(stretches, "LONG", 4000)
    monkeypatch.setattr(stretches, "USED", 5200)
    rides = [ride(seconds=14.0), ride(seed=2, seconds=14.0, without=("deflection",))]
    problem, _ = open_ride(stretches.shortened(Dataset.of(rides)), load_model(CAR))
    assert any("of 28 s searched, in" in note for note in problem.notes)
    assert "deflection is not used: 1 of 2 records lack it" in problem.notes
    assert len(set(problem.notes)) == len(problem.notes)


def test_starts_suit_every_model_and_are_not_scored(opened):
    problem, fitted = opened
    n = problem.forward.outputs
    for i, _ in problem.forward.blocks():
        assert not problem.used[i * n : (i + round(SETTLE / DT)) * n].any()
    wrong = fitted.model.with_effect("gas_spring")
    moved = replace(problem.forward, starts=problem.forward.starts + 0.02 * problem.forward.sizes)
    for model in (fitted.model, wrong):
        here, there = problem.predict(model), moved.predict(problem, model)
        assert np.std(here - there) < 0.05 * problem.sd_force
    assert len(list(problem.forward.blocks())) == 1
    longer = open_ride(Dataset.of([ride(seconds=21.0)]), load_model(CAR))[0]
    assert len(list(longer.forward.blocks())) == 2


def test_effects_of_sensors_that_were_not_recorded_are_not_tried(opened):
    forward, model = opened[0].forward, load_model(CAR)
    part = replace(forward, names=("sprung_acceleration", "deflection"))
    tried, fewer = ({e.name for e in f.candidates(model)} for f in (forward, part))
    assert tried - fewer == {"force_delay", "force_lag", "velocity_lag"}
    part = replace(forward, names=("damper_force", "deflection_velocity"))
    assert tried - {e.name for e in part.candidates(model)} == {"deflection_zero"}


def test_a_known_car_comes_back_with_its_deviations(opened):
    from er_model_lab.fitting.deviations import with_deviations

    problem, fitted = opened
    model, truth = with_deviations(fitted, problem), load_model(CAR)
    for effect, name in fitted.free:
        sd = model.deviations[effect][name]
        assert abs(model.value(effect, name) - truth.value(effect, name)) < 4.5 * sd
        assert sd < 0.2 * abs(truth.value(effect, name))
    assert model.value("quarter_car", "m_s") == truth.value("quarter_car", "m_s")


def test_a_car_that_is_another_one_is_told():
    car = load_model(CAR)
    masses = {**car.effects["quarter_car"], "m_us": 0.4 * car.value("quarter_car", "m_us")}
    data, other = Dataset.of([ride(seconds=6.0)]), car.with_effect("quarter_car", masses)
    said = "m_us ends at 0.2 kg, twice what the model gives"
    assert [said in n for n in open_ride(data, other)[0].notes[:1]] == [True]
    assert not any("ends at" in n for n in open_ride(data, car)[0].notes)


def test_two_springs_are_one_where_the_force_is_not_measured(opened):
    problem, fitted = opened
    assert confounded(fitted, problem) == []
    blind, fit = open_ride(Dataset.of([ride(without=("damper_force",))]), load_model(CAR))
    groups = confounded(fit, blind)
    assert any({"passive.k0", "quarter_car.k_s"} <= set(group) for group in groups)
    assert blind.sd_force == pytest.approx(2.27 * 0.025, rel=0.1)


def test_the_floor_has_a_part_for_every_output(opened):
    from er_model_lab.diagnosis.candidates import Candidate

    problem, fitted = opened
    base = Candidate(
        (),
        fitted,
        fitted.residual,
        np.zeros(12),
        fitted.mse(problem.train),
        fitted.mse(problem.train),
        1.0,
        1.0,
    )
    floor = noise_floor(problem, base, simulate_null(base, [], problem, 0), 0)
    assert len(floor.parts) == problem.forward.outputs
    for part, sd, weight in zip(floor.parts, NOISE.values(), problem.forward.weights, strict=True):
        assert part.held_out / weight == pytest.approx(sd, rel=0.1)
    assert floor.floor == pytest.approx(problem.sd_force, rel=0.05)


def write(path, record):
    table = np.stack([record.t, *record.channels.values()], axis=1)
    names = ",".join(["t", *record.channels])
    np.savetxt(path, table, delimiter=",", header=names, comments="")
    return path


def lab(*words):
    return CliRunner().invoke(app, [str(w) for w in words])


def test_friction_beside_the_damper_is_added_with_its_value(tmp_path):
    import json

    data = write(tmp_path / "a.csv", ride(seconds=10.0, truth=hidden()))
    out, found = tmp_path / "new.yaml", tmp_path / "r.json"
    words = ("add", "guide_friction", data, "--model", CAR, "--out", out, "--json", found)
    assert lab(*words).exit_code == 2
    result = lab(*words, "--level", "vehicle")
    assert result.exit_code == 0, result.output
    r, model = json.loads(found.read_text()), load_model(out)
    assert (r["verdict"], r["effects"], r["level"]) == (
        "missing_effect",
        ["guide_friction"],
        "vehicle",
    )
    value, sd, unit = r["candidates"][0]["parameters"]["F_g"]
    assert unit == "N"
    assert abs(value - FRICTION["F_g"]) < 4.5 * sd < 0.2
    assert model.value("guide_friction", "F_g") == pytest.approx(value)
    assert r["channels"]["sprung_acceleration"]["unit"] == "m/s2"
    for name, sd in NOISE.items():
        assert r["channels"][name]["rmse_after"] == pytest.approx(sd, rel=0.1)
    body = r["channels"]["sprung_acceleration"]
    assert body["rmse"] > 2.0 * body["rmse_after"]


def test_a_comparison_leaves_of_the_true_car_its_noise_alone(tmp_path):
    import json

    data, found = write(tmp_path / "a.csv", ride(seconds=21.0, finer=8)), tmp_path / "r.json"
    heavy = tmp_path / "heavy.yaml"
    car = load_model(CAR)
    heavier = {**car.effects["quarter_car"], "m_s": 2.6}
    save_model(replace(car, effects={**car.effects, "quarter_car": heavier}), heavy)
    words = ("compare", data, "--model", CAR, "--model", heavy, "--level", "vehicle")
    result = lab(*words, "--json", found)
    assert result.exit_code == 0, result.output
    r = json.loads(found.read_text())
    for name, sd in NOISE.items():
        assert r["channels"][name]["rmse"] == pytest.approx(sd, rel=0.05)
    assert r["explainable"] < 0.1
    assert r["rmse_by_record"]["a"] == r["rmse"] < 0.5 * r["models"][1]["rmse"]
    assert any("smooth" in note for note in r["notes"])


def test_without_the_force_a_comparison_is_of_the_bodys_acceleration(tmp_path):
    import json

    record, found = ride(seconds=6.0, without=("damper_force",)), tmp_path / "r.json"
    data = write(tmp_path / "a.csv", record)
    words = ("compare", data, "--model", CAR, "--level", "vehicle", "--json", found)
    assert lab(*words).exit_code == 0
    r, mass = json.loads(found.read_text()), load_model(CAR).value("quarter_car", "m_s")
    assert "damper_force" not in r["channels"]
    assert r["rmse"] == pytest.approx(mass * NOISE["sprung_acceleration"], rel=0.1)


def test_without_road_one_line_says_so(tmp_path):
    data = write(tmp_path / "a.csv", ride(seconds=6.0, without=("road",)))
    result = lab("diagnose", data, "--model", CAR, "--level", "vehicle")
    assert result.exit_code == 4
    assert "channel 'road' is needed" in result.output
    assert len(result.output.strip().splitlines()) == 1


def test_without_a_duty_it_counts_as_none_and_a_note_says_so():
    """An active quarter car has an actuator and no field."""
    record = active(seconds=4.0)
    channels = {k: v for k, v in record.channels.items() if k != "duty"}
    none = replace(record, channels=channels)
    zero = replace(record, channels=channels | {"duty": np.zeros(len(record))})
    problems = [open_ride(Dataset.of([r]), load_model(CAR))[0] for r in (none, zero)]
    forces = [p.predict(load_model(CAR)) for p in problems]
    assert np.array_equal(*forces)
    assert [NO_DUTY in p.notes for p in problems] == [True, False]
    blind = replace(none, channels={k: v for k, v in channels.items() if k != "damper_force"})
    assert [f.remedy for f in use_findings(blind)] == ["use level='vehicle'"]


def test_an_actuator_whose_force_counts_the_other_way_is_told_before_anything_is_fitted():
    record = active(seconds=4.0)
    x = record.channels["deflection"]
    given = record.channels | {"deflection_velocity": np.gradient(x, DT)}

    def failed(force):
        channels = given | {"actuator_force": force}
        return [f for f in findings(replace(record, channels=channels)) if f.level == "fail"]

    assert failed(given["actuator_force"]) == []
    (fail,) = failed(-given["actuator_force"])
    assert fail.channel == "actuator_force"
    assert "sign: -1" in fail.remedy
    # of a force that a controller makes of the motion alone nobody can tell
    assert failed(-40.0 * x - 5.0 * given["deflection_velocity"]) == []


def test_a_yield_force_without_a_duty_keeps_its_value():
    """Of the other starts that a search tries none is better, nor worse."""
    record = active(seconds=4.0)
    none = replace(record, channels={k: v for k, v in record.channels.items() if k != "duty"})
    car = load_model(CAR)
    problem, fitted = open_ride(Dataset.of([none]), car)
    yielding = {**fitted.model.effects["guo_yield"], "f_c": 1e3 * car.value("guo_yield", "f_c")}
    moved = replace(fitted, model=fitted.model.with_effect("guo_yield", yielding))
    found = with_deviations(moved, problem)
    assert found.value("guo_yield", "f_c") > 1e4
    kept = with_unfelt(found, car, problem)
    assert kept.value("guo_yield", "f_c") == car.value("guo_yield", "f_c")
    assert kept.value("passive", "c0") == found.value("passive", "c0")


def test_a_damper_alone_cannot_ride(tmp_path):
    damper = CAR.parents[1] / "dampers" / "inove_guo.yaml"
    data = write(tmp_path / "a.csv", ride(seconds=6.0))
    result = lab("diagnose", data, "--model", damper, "--level", "vehicle")
    assert result.exit_code == 2
    assert "quarter_car" in result.output


def test_a_wheel_that_leaves_the_road_is_found_in_its_narrow_valley():
    flying = load_model(CAR).with_effect("tyre_lift_off", {"r": 0.6})
    problem, fitted = open_ride(Dataset.of([ride(seconds=7.0, truth=flying)]), load_model(CAR))
    found = refit(
        baseline(fitted.model, problem), fitted.model.catalogue["tyre_lift_off"], problem
    )
    assert fitted.mse(problem.train) > 1e3 * NOISE["damper_force"] ** 2
    assert found.seen < 9.0 * NOISE["damper_force"] ** 2
    assert found.fit.model.effects["tyre_lift_off"]["r"] == pytest.approx(0.6, rel=0.003)


def test_a_car_without_any_output_is_told_which_would_do(tmp_path):
    moved = ("deflection", "deflection_velocity", "sprung_acceleration", "unsprung_acceleration")
    data = write(tmp_path / "a.csv", ride(seconds=6.0, without=("damper_force", *moved)))
    result = lab("compare", data, "--model", CAR, "--level", "vehicle")
    assert result.exit_code == 4
    assert "'damper_force' is needed (or sprung_acceleration, unsprung_" in result.output
