"""The whole car: against SciPy on equations of its own, against quarter cars in its modes, and closed forms."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from er_models.car.body import CORNERS, Car
from er_models.car.files import load_car
from er_models.car.simulation import (
    car_at_rest,
    prepare_car,
    simulate_car,
    step_car,
    with_corner,
)
from er_models.errors import InputError
from er_models.files import load_model
from er_models.simulation import simulate
from models_help import CONFIG, DT, span
from numpy.typing import NDArray
from scipy.integrate import solve_ivp

Array = NDArray[np.float64]
FINE = 16
"""Heights of the road in each sample: those of the integrator's steps."""


def the_car() -> Car:
    return load_car(CONFIG / "cars" / "inove_car.yaml")


def even() -> Car:
    """A car whose motions do not see one another: as long in front of the centre as behind."""
    return replace(the_car(), to_front=0.26, to_rear=0.26, front_bar=200.0, rear_bar=200.0)


def street(seconds: float, shifts: tuple[float, ...] = (0.0, 0.013, 0.05, 0.063)) -> Array:
    """Four roads of two sines, (4, m), each later than the first by a shift [s]; level at first."""
    t = np.arange(FINE * round(seconds / DT) + 1) * DT / FINE
    rows = []
    for shift in shifts:
        s = np.maximum(t - shift, 0.0)
        rows.append(
            (0.004 * np.sin(4 * np.pi * s) + 0.0005 * np.sin(18 * np.pi * s))
            * np.minimum(4 * s, 1.0)
        )
    return np.array(rows)


def duties(n: int) -> Array:
    """Duties that step, at another time in each corner, (4, n)."""
    k = np.arange(n)
    return np.array([np.where((k // 30 + i) % 2, 0.25, 0.05) for i in range(4)])


def by_scipy(
    car: Car, road: Array, duty: Array, forward: Array, left: Array
) -> tuple[Array, Array]:
    """Heave, roll, pitch (n, 3) and deflections (n, 4): Newton's and Euler's equations and Guo's damper, by SciPy."""
    g = load_model(CONFIG / "dampers" / "inove_guo.yaml").effects
    c = car.corners[0].effects["quarter_car"]
    x = np.array([car.to_front, car.to_front, -car.to_rear, -car.to_rear])
    y = np.array([car.front_track, -car.front_track, car.rear_track, -car.rear_track]) / 2
    t_road = np.arange(road.shape[1]) * DT / FINE
    n = duty.shape[1]

    def rates(t: float, s: Array) -> Array:
        (z, phi, theta, dz, dphi, dtheta), wheel, dwheel, f = s[:6], s[6:10], s[10:14], s[14:18]
        k = min(int(t / DT + 1e-9), n - 1)
        ground = np.array([np.interp(t, t_road, r) for r in road])
        e, de = z + y * phi - x * theta - wheel, dz + y * dphi - x * dtheta - dwheel
        target = (
            g["guo_yield"]["f_c"]
            * duty[:, k]
            * np.tanh(g["guo_yield"]["k1"] * e + g["guo_yield"]["c1"] * de)
        )
        damper = g["passive"]["k0"] * e + g["passive"]["c0"] * de + f
        bar = np.array([car.front_bar] * 2 + [car.rear_bar] * 2) * (e - e[[1, 0, 3, 2]])
        up = -(c["k_s"] * e + damper + bar)
        body = [
            up.sum() / car.mass,
            (y @ up + car.mass * car.height * left[k]) / car.roll_inertia,
            (-(x @ up) - car.mass * car.height * forward[k]) / car.pitch_inertia,
        ]
        return np.concatenate([
            s[3:6], body, dwheel, (-up - c["k_t"] * (wheel - ground)) / c["m_us"], (target - f) / g["response"]["tau"]
        ])  # fmt: skip

    states = [np.zeros(18)]
    for k in range(n - 1):  # the duty steps at samples: one integration each
        span_ = (k * DT + 1e-12, (k + 1) * DT)
        run = solve_ivp(rates, span_, states[-1], method="LSODA", rtol=1e-7, atol=1e-10)
        states.append(run.y[:, -1])
    s = np.array(states)
    z_s = s[:, :1] + np.outer(s[:, 1], y) - np.outer(s[:, 2], x)
    return s[:, :3], z_s - s[:, 6:10]


def test_against_scipy() -> None:
    n = 81
    road, duty = street((n - 1) * DT), duties(n)
    forward, left = np.where(np.arange(n) > 20, -3.0, 0.0), np.where(np.arange(n) > 40, 4.0, 0.0)
    pose, deflection = by_scipy(the_car(), road, duty, forward, left)
    run = simulate_car(the_car(), DT, road, duty, forward, left)
    for k, name in enumerate(("heave", "roll", "pitch")):
        assert np.abs(run[name] - pose[:, k]).max() < 1e-3 * span(pose[:, k])
    for i, corner in enumerate(CORNERS):
        assert np.abs(run[f"{corner}/deflection"] - deflection[:, i]).max() < 1e-3 * span(
            deflection
        )


@pytest.mark.parametrize(
    ("signs", "inertia", "bar"),
    [
        ((1, 1, 1, 1), "heave", 0.0),
        ((1, -1, 1, -1), "roll", 400.0),
        ((-1, -1, 1, 1), "pitch", 0.0),
    ],
)
def test_a_mode_is_a_quarter_car(signs: tuple[int, ...], inertia: str, bar: float) -> None:
    """On a road of one mode an even car moves as a quarter car of that mode's mass; the bar adds to its spring."""
    car, n = even(), 201
    mass = {
        "heave": car.mass / 4,
        "roll": car.roll_inertia / car.front_track**2,
        "pitch": car.pitch_inertia / (4 * car.to_front**2),
    }[inertia]
    road = street((n - 1) * DT, (0.0,))[0, ::FINE]
    duty = np.full((4, n), 0.15)
    model = car.corners[0]
    values = {**model.effects["quarter_car"], "m_s": mass}
    values["k_s"] += bar
    alone = simulate(model.with_effect("quarter_car", values), DT, road, duty[0])
    run = simulate_car(car, DT, np.outer(signs, road), duty)
    for i, corner in enumerate(CORNERS):
        found = signs[i] * run[f"{corner}/deflection"]
        assert np.abs(found - alone["deflection"]).max() < 1e-6 * span(alone["deflection"])
    found = signs[0] * run["front_left/sprung_acceleration"]
    assert np.abs(found[1:] - alone["sprung_acceleration"][1:]).max() < 1e-4 * span(found)


def test_it_leans_and_dives_as_statics_say() -> None:
    """Roll and pitch angle of a long turn and a long braking, and what the bars do to them."""
    car, n = even(), 1200
    flat, duty = np.zeros((4, n)), np.zeros((4, n))
    c, damper = car.corners[0].effects["quarter_car"], car.corners[0].effects["passive"]
    spring = c["k_s"] + damper["k0"]  # no field: the damper is a spring at rest
    for name, bar, arm, loads in (
        ("roll", 2 * car.front_bar, car.front_track / 2, {"left": 2.0}),
        ("pitch", 0.0, car.to_front, {"forward": -2.0}),
    ):
        rate = 1 / (1 / (spring + bar) + 1 / c["k_t"])
        angle = car.mass * car.height * 2.0 / (4 * rate * arm**2)
        ramp = {key: np.minimum(np.arange(n) / 400, 1.0) * value for key, value in loads.items()}
        run = simulate_car(car, DT, flat, duty, **ramp)
        assert run[name][-1] == pytest.approx(angle, rel=1e-3)


def test_one_sample_at_a_time_is_the_whole_record() -> None:
    car, n = the_car(), 40
    road, duty = street((n - 1) * DT), duties(n)
    whole = simulate_car(car, DT, road, duty)
    plant = prepare_car(car, DT)
    states = car_at_rest(plant, road[:, 0], duty[:, 0])
    for k in range(1, n):
        states, out = step_car(
            plant, states, road[:, (k - 1) * FINE + 1 : k * FINE + 1], duty[:, k - 1]
        )
        for i, corner in enumerate(CORNERS):
            assert out.corners[i].deflection == whole[f"{corner}/deflection"][k]
            assert out.corners[i].sprung_acceleration == pytest.approx(
                whole[f"{corner}/sprung_acceleration"][k], rel=1e-6, abs=1e-6
            )
        assert out.body[0] == pytest.approx(whole["heave_acceleration"][k], rel=1e-6, abs=1e-6)


def test_a_fault_at_one_corner_tilts_the_car() -> None:
    car, n = the_car(), 200
    same = np.tile(street((n - 1) * DT, (0.0,)), (4, 1))
    duty = np.full((4, n), 0.2)
    leaking = with_corner(car, "front_left", car.corners[0].with_effect("oil_leakage", {"f": 0.6}))
    assert np.abs(simulate_car(car, DT, same, duty)["roll"]).max() < 1e-9
    assert np.abs(simulate_car(leaking, DT, same, duty)["roll"]).max() > 1e-4


@pytest.mark.parametrize(
    ("old", "new", "words"),
    [
        ("mass: 9.08 ", "mass: -1 ", "body.mass: expected 0.01 to 100000 kg, found -1"),
        ("  to_rear: 0.28\n", "", "body.to_rear"),
        (
            "rear: ../vehicles/inove_quarter_car.yaml",
            "rear: ../dampers/inove_guo.yaml",
            "corners.rear",
        ),
        ("corners: {front", "corners: {fornt", "corners.fornt"),
        ("er_car 1", "er_model 1", "schema"),
    ],
)
def test_a_bad_file_is_one_line(old: str, new: str, words: str, tmp_path) -> None:  # type: ignore[no-untyped-def]
    text = (CONFIG / "cars" / "inove_car.yaml").read_text(encoding="utf-8")
    assert old in text
    text = text.replace(old, new).replace("../", f"{CONFIG}/")
    (tmp_path / "car.yaml").write_text(text, encoding="utf-8")
    with pytest.raises(InputError, match=words.split(":")[0].replace(".", r"\.")) as caught:
        load_car(tmp_path / "car.yaml")
    assert words in str(caught.value)


def test_arrays_that_do_not_fit_are_refused() -> None:
    with pytest.raises(InputError, match="heights beside"):
        simulate_car(the_car(), DT, np.zeros((4, 7)), np.zeros((4, 5)))
