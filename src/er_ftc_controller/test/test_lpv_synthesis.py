"""The LPV controller: the thesis's lack of room, ours, what its certificate refuses, its file, its command."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
import yaml
from er_ftc_controller.gains import load_gains, save_gains
from er_ftc_controller.synth import app
from er_ftc_controller.synthesis.certificate import certify, closed_loop, sampled_loop
from er_ftc_controller.synthesis.lmi import Wish, passive_gamma, smallest, solve
from er_ftc_controller.synthesis.solution import NoController, Solution
from er_ftc_controller.synthesis.study import HERTZ, gains, passive_gains, peaks
from er_ftc_controller.synthesis.weights import (
    THESIS,
    W_ROAD,
    Plant,
    generalised_plant,
    radius_for,
    weights_for,
)
from er_models.errors import InputError
from er_models.files import load_model
from er_models.forms.response import frequency_response
from er_models.gain_file import digest
from er_models.model import Model
from scipy.integrate import solve_ivp
from typer.testing import CliRunner

CONFIG = Path(__file__).resolve().parents[3] / "config"
MODEL = CONFIG / "vehicles" / "inove_quarter_car.yaml"


@pytest.fixture(scope="module")
def car() -> Model:
    return load_model(MODEL)


@pytest.fixture(scope="module")
def plant(car: Model) -> Plant:
    return generalised_plant(car, weights_for(car))


@pytest.fixture(scope="module")
def solution(plant: Plant) -> Solution:
    return solve(plant, Wish())


@pytest.mark.parametrize(("slower", "comfort", "holding"), [(1.0, 10.0, 5.0), (3.0, 3.33, 1.67)])
def test_our_weights_follow_the_frequencies_of_the_car(
    car: Model, slower: float, comfort: float, holding: float
) -> None:
    """A car whose every pole is so many times slower is weighed so many times lower."""
    effects = {name: dict(values) for name, values in car.effects.items()}
    for of, name, power in (
        ("quarter_car", "k_s", 2), ("quarter_car", "k_t", 2), ("passive", "k0", 2), ("passive", "c0", 1),
    ):  # fmt: skip
        effects[of][name] /= slower**power
    other = replace(car, effects=effects)
    found = weights_for(other)
    assert (found.body, found.wheel) == ((comfort, 1.0), (holding, 6.0))
    assert radius_for(other) == pytest.approx(Wish.radius / slower, rel=5e-3)


def test_the_thesis_car_is_weighed_as_its_committed_gains_are(car: Model) -> None:
    """To the last digit: they need not be made again."""
    committed = load_gains(CONFIG / "gains" / "lpv_ftc.yaml", car)
    assert weights_for(car) == committed.plant.weights
    assert radius_for(car) == Wish.radius


@pytest.mark.slow
def test_the_weights_of_the_thesis_leave_no_room(car: Model) -> None:
    """Its 0.1903 is worse than no control at all, and the best there is hardly better; only a smaller rho helps."""
    plant = generalised_plant(car, THESIS)
    passive = W_ROAD * passive_gamma(plant)
    assert passive == pytest.approx(0.1889, abs=1e-4)
    assert passive < 0.1903
    frozen = W_ROAD * smallest(plant, (0.01,), 4000.0)
    assert frozen == pytest.approx(0.1878, abs=2e-4)
    assert 0.99 * passive < frozen < passive
    free = W_ROAD * smallest(plant, (0.001,), 4000.0)
    assert W_ROAD * np.sqrt(5.0) < free < 0.16
    both = W_ROAD * smallest(plant, (0.001, 1.0), 4000.0, 0.25 / W_ROAD)
    assert both == pytest.approx(0.1888, abs=2e-4)


def test_comfort_at_the_lowest_rho_and_the_passive_car_at_the_greatest(
    car: Model, plant: Plant, solution: Solution
) -> None:
    passive = peaks(passive_gains(car))
    free, held = (peaks(gains(plant, k)) for k in solution.vertices)
    assert free.body < 0.85 * passive.body
    assert free.wheel - 1.0 < 0.8 * (passive.wheel - 1.0)
    assert free.wheel_anywhere - 1.0 < 0.8 * (passive.wheel_anywhere - 1.0)
    near = gains(plant, solution.vertices[-1]) / passive_gains(car)
    assert np.abs(near[:, :2] - 1.0).max() < 0.02
    assert held.body == pytest.approx(passive.body, rel=0.01)


def test_the_wheel_follows_the_body_whatever_the_force_between_them(
    car: Model, plant: Plant, solution: Solution
) -> None:
    """k_t (z_us - z_r) = -(m_s z_s'' + m_us z_us''): one of both transfers is the other."""
    of, w = car.effects["quarter_car"], 2.0 * np.pi * HERTZ
    rows = np.zeros((2, plant.n * 2))
    rows[[0, 1], [0, 2]] = 1.0
    A, B, _ = closed_loop(plant, solution.vertices[0])
    both = frequency_response(A * plant.rate, B[:, :1] * plant.rate, rows, HERTZ)[:, :, 0]
    follows = 1.0 + of["m_s"] * w**2 / of["k_t"] * both[:, 0]
    assert np.allclose(both[:, 1] * (1.0 - of["m_us"] * w**2 / of["k_t"]), follows, atol=1e-6)


def test_the_certificate_holds_and_the_sampled_car_settles(
    plant: Plant, solution: Solution
) -> None:
    found = certify(plant, solution)
    assert min(found.margins) > 1e-5
    assert all(p <= k.gamma for p, k in zip(found.peaks, solution.vertices, strict=True))
    assert max(found.slowest) < -1.0
    assert max(found.fastest) < Wish.radius
    assert found.mixed < 1.0


@pytest.mark.parametrize(
    ("wish", "why"),
    [
        (Wish(radius=1000.0), "sampled loop grows by 1.0.* smaller --radius than 1000 1/s"),
        (Wish(radius=400.0), "bears jumps of rho"),
        (Wish(held_back=0.5), r"rho = 5.* gamma is .* of the passive car's at least; --held-back allows 0.5"),
        (Wish(radius=5.0), "poles within --radius 5 1/s, not even for rho = 5 alone"),
    ],
)  # fmt: skip
def test_a_wish_that_cannot_be_had_says_what_stands_in_its_way(
    car: Model, wish: Wish, why: str
) -> None:
    """Two are proved in continuous time, and fail with force and deflection held for a sample; two are infeasible."""
    plant = generalised_plant(car, replace(weights_for(car), rho=(0.1, 5.0)))
    with pytest.raises(NoController, match=why):
        solve(plant, wish)


@pytest.mark.slow
def test_a_faster_rho_costs_a_lyapunov_function_of_rho_more(plant: Plant) -> None:
    limit, rhos = 1.3 * passive_gamma(plant), plant.weights.rho
    slow, fast = (smallest(plant, rhos, Wish.radius, limit, rate) for rate in (1.0, 100.0))
    assert smallest(plant, rhos[:1], Wish.radius) < slow < fast < passive_gamma(plant)


def test_the_certificate_refuses_what_is_no_controller(plant: Plant, solution: Solution) -> None:
    first, last = solution.vertices
    wrong = replace(solution, vertices=(replace(first, C=-first.C), last))
    with pytest.raises(NoController, match=r"\(6.24\) has the margin"):
        certify(plant, wrong)
    boast = replace(solution, vertices=(replace(first, gamma=0.9 * solution.optimum), last))
    with pytest.raises(NoController, match="margin"):
        certify(plant, boast)
    with pytest.raises(NoController, match="P is not positive"):
        certify(plant, replace(solution, P=-solution.P))
    with pytest.raises(NoController, match="P_sampled does not fall along the loop"):
        certify(plant, replace(solution, P_sampled=np.eye(len(solution.P_sampled))))


def test_a_sample_is_the_solution_of_the_differential_equations(
    plant: Plant, solution: Solution
) -> None:
    """Force and deflection held: from the suspension (2.8) in SI units, and the controller's own equations."""
    k, rng, sample = solution.vertices[0], np.random.default_rng(0), 0.005
    n, form, road = k.A.shape[0], plant.form, plant.weights.road
    x, xc = rng.normal(size=4), rng.normal(size=n)
    sizes = road * np.array([1.0, plant.rate, 1.0, plant.rate])
    force, y = float((k.C @ xc)[0]) * plant.unit, x[0] - x[2]
    ridden = solve_ivp(
        lambda _, q: form.rate(q, force, 0.0), (0.0, sample), x * sizes, rtol=1e-10, atol=1e-13
    ).y[:, -1]
    filtered = solve_ivp(
        lambda _, q: plant.rate * (k.A @ q + k.B[:, 0] * y),
        (0.0, sample),
        xc,
        rtol=1e-10,
        atol=1e-12,
    ).y[:, -1]
    found = sampled_loop(plant, k, sample) @ np.concatenate([x, xc])
    assert np.allclose(found, np.concatenate([ridden / sizes, filtered]), rtol=1e-6, atol=1e-8)


def test_file_is_read_again_and_proved_and_refused_when_touched(
    car: Model, plant: Plant, solution: Solution, tmp_path: Path
) -> None:
    path = tmp_path / "gains.yaml"
    save_gains(path, car, plant, solution, {})
    again = load_gains(path, car).solution
    assert np.allclose(again.vertices[0].A, solution.vertices[0].A, rtol=1e-12)
    heavier = replace(
        car, effects={**car.effects, "quarter_car": {**car.effects["quarter_car"], "m_s": 3.0}}
    )
    with pytest.raises(InputError, match="fingerprint"):
        load_gains(path, heavier)
    text = path.read_text()
    path.write_text(text.replace("rho: 0.2", "rho: 0.3", 1))
    with pytest.raises(InputError, match="digest"):
        load_gains(path, car)


@pytest.mark.parametrize(
    ("key", "value", "complaint"),
    [
        ("A", {"shape": [2, 2], "data": [1.0]}, "a matrix 6 x 6"),
        ("C", {"shape": [1, 6], "data": [float("nan")] * 6}, "finite numbers"),
        ("gamma", "small", "finite numbers"),
    ],
)
def test_values_that_are_none_are_one_line(
    car: Model, tmp_path: Path, key: str, value: object, complaint: str
) -> None:
    content = yaml.safe_load((CONFIG / "gains" / "lpv_ftc.yaml").read_text(encoding="utf-8"))
    content["vertices"][0][key] = value
    content["digest"] = digest(content)
    path = tmp_path / "gains.yaml"
    path.write_text(yaml.safe_dump(content), encoding="utf-8")
    with pytest.raises(InputError, match=complaint) as caught:
        load_gains(path, car)
    assert "\n" not in str(caught.value)


def test_a_file_whose_sampled_loop_is_not_proved_is_refused(
    car: Model, plant: Plant, solution: Solution, tmp_path: Path
) -> None:
    path = tmp_path / "gains.yaml"
    save_gains(path, car, plant, replace(solution, P_sampled=np.eye(len(solution.P_sampled))), {})
    with pytest.raises(InputError, match="P_sampled does not fall"):
        load_gains(path, car)


def test_the_shipped_file_is_proved(car: Model) -> None:
    assert load_gains(CONFIG / "gains" / "lpv_ftc.yaml", car).solution.vertices[0].rho == 0.2


def test_a_model_is_not_overwritten_by_its_gains(tmp_path: Path) -> None:
    model = tmp_path / "car.yaml"
    model.write_bytes(MODEL.read_bytes())
    done = CliRunner().invoke(app, ["--model", str(model), "--out", str(model)])
    assert isinstance(done.exception, InputError)
    assert "another place than --model" in str(done.exception)
    assert model.read_bytes() == MODEL.read_bytes()


def test_command_writes_gains(tmp_path: Path) -> None:
    out = tmp_path / "gains.yaml"
    done = CliRunner().invoke(app, ["--model", str(MODEL), "--out", str(out)])
    assert done.exit_code == 0, done.output
    assert "1 to 10 Hz" in done.output
    assert out.is_file()
