"""One value of every effect, worked by hand: property tests cannot see a wrong factor."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np
import pytest
from er_models.catalogue import CATALOGUE
from er_models.kernel.load import kernel
from er_models.model import Model
from er_models.predict import motion, predict
from er_models.rhs import damper_rate
from models_help import DT, SMALL, one_sample
from reference import vehicle_rate

Values = Mapping[str, Mapping[str, float]]

PASSIVE = {"passive": {"k0": 100.0, "c0": 50.0}}
YIELD = {"guo_yield": {"f_c": 20.0, "k1": 0.0, "c1": 1000.0}}
"""At a velocity of 0.1 m/s the tanh is 1 to the last digit: 20 N per duty."""

TABLE = {
    "u_1": 0.1, "d_u": 0.05,
    "tau_1": 0.01, "tau_2": 0.02, "tau_3": 0.04, "tau_4": 0.05, "tau_5": 0.06,
}  # fmt: skip

CUBE = {"gas_spring": {"k_2": 0.0, "k_3": 1e6}}
"""Shows the deflection of the damper itself where its passive force does not."""

# each row: its effects, the point x v u a, and the force in equilibrium; a colon tells rows of one effect apart
FORCES: dict[str, tuple[Values, tuple[float, float, float, float], float]] = {
    "passive": (PASSIVE, (0.01, 0.1, 0.0, 0.0), 6.0),
    "guo_yield": (
        {"guo_yield": {"f_c": 20.0, "k1": 100.0, "c1": 10.0}},
        (0.01, 0.05, 0.5, 0.0),
        9.051482536448664,  # 10 tanh 1.5
    ),
    "bingham_yield": (
        {"bingham_yield": {"sigma": 10.0, "beta": 0.5, "v_0": 0.01}},
        (0.0, 0.02, 0.25, 0.0),
        4.820137900379084,  # 5 tanh 2
    ),
    "passive_by_direction": (  # release
        {
            "passive_by_direction": {
                "k0_c": 300.0,
                "c0_c": 20.0,
                "k0_r": 100.0,
                "c0_r": 50.0,
                "v_0": 1e-3,
            }
        },
        (0.01, 0.1, 0.0, 0.0),
        6.0,
    ),
    "guo_yield_by_direction": (  # compression: -15 tanh 1.5
        {
            "guo_yield_by_direction": {
                "f_c_c": 30.0,
                "k1_c": 100.0,
                "c1_c": 50.0,
                "f_c_r": 20.0,
                "k1_r": 10.0,
                "c1_r": 10.0,
                "v_0": 1e-3,
            }
        },
        (0.01, -0.05, 0.5, 0.0),
        -13.577223804673,
    ),
    "bingham_yield_by_direction": (  # release: 16 / 4
        {
            "bingham_yield_by_direction": {
                "sigma_c": 10.0,
                "beta_c": 0.5,
                "sigma_r": 16.0,
                "beta_r": 1.0,
                "v_0": 1e-3,
            }
        },
        (0.0, 0.1, 0.25, 0.0),
        4.0,
    ),
    "preload": ({"preload": {"F_0": 1.5}}, (0.0, 0.0, 0.0, 0.0), 1.5),
    "gas_spring": ({"gas_spring": {"k_2": 1e4, "k_3": 2e6}}, (-0.01, 0.1, 0.0, 0.0), -1.0),
    "coulomb_friction": (
        {"coulomb_friction": {"F_c": 2.0, "v_0": 0.02}},
        (0.0, -0.02, 0.0, 0.0),
        -1.5231883119115297,  # -2 tanh 1
    ),
    "stribeck_friction": (
        {"stribeck_friction": {"F_c": 1.0, "F_s": 2.0, "v_s": 0.1, "v_0": 0.05}},
        (0.0, 0.1, 0.0, 0.0),
        1.6733194349401157,  # (1 + 2 / e) tanh 2
    ),
    "quadratic_damping": ({"quadratic_damping": {"c_2": 200.0}}, (0.0, -0.1, 0.0, 0.0), -2.0),
    "herschel_bulkley": (
        {"herschel_bulkley": {"c_h": 100.0, "n": 0.5, "v_0": 0.03, "v_r": 0.1}},
        (0.0, -0.04, 0.2, 0.0),
        -11.313708498984761,  # -100 0.2 0.4 / 0.25^(1/4)
    ),
    "asymmetric_damping": ({"asymmetric_damping": {"c_a": 10.0}}, (0.0, -0.2, 0.0, 0.0), 2.0),
    "shear_thinning": (
        {"passive": {"k0": 0.0, "c0": 100.0}, "shear_thinning": {"n": 0.5, "v_r": 0.1}},
        (0.0, 0.1 * 3.0**0.5, 0.0, 0.0),
        100.0 * 0.1 * 3.0**0.5 * 0.5**0.5,  # (1 + 3)^(-1/4)
    ),
    "position_dependent_damping": (
        {"position_dependent_damping": {"c_x": 1e5}},
        (-0.01, 0.2, 0.0, 0.0),
        2.0,
    ),
    "end_stop": ({"end_stop": {"k_b": 1000.0, "x_b": 0.008}}, (-0.01, 0.0, 0.0, 0.0), -2.0),
    "bouc_wen_hysteresis": (
        {"bouc_wen_hysteresis": {"F_h": 2.0, "F_u": 10.0, "z_y": 1e-3}},
        (0.0, -0.1, 0.3, 0.0),
        -5.0,
    ),
    "viscoelastic_branch": (
        {"viscoelastic_branch": {"k_m": 100.0, "t_m": 0.05}},
        (0.0, 0.2, 0.0, 0.0),
        1.0,
    ),
    "fluid_inertia": ({"fluid_inertia": {"m_f": 0.2}}, (0.0, 0.0, 0.0, -5.0), -1.0),
    "mount_compliance": (  # w = 6 N / (100 + 100) N/m = 30 mm stretch; 3 N either side
        {**PASSIVE, "mount_compliance": {"q": 0.01}},
        (0.01, 0.1, 0.0, 0.0),
        3.0,
    ),
    "passive_by_direction: in series": (  # release: as above
        {
            "passive_by_direction": {
                "k0_c": 300.0,
                "c0_c": 20.0,
                "k0_r": 100.0,
                "c0_r": 50.0,
                "v_0": 1e-3,
            },
            "mount_compliance": {"q": 0.01},
        },
        (0.01, 0.1, 0.0, 0.0),
        3.0,
    ),
    "freeplay": ({**PASSIVE, "freeplay": {"b": 0.002}}, (0.01, 0.1, 0.0, 0.0), 5.8),
    "force_lag": ({**PASSIVE, "force_lag": {"T_f": 0.01}}, (0.01, 0.1, 0.0, 0.0), 6.0),
    "field_viscosity": ({"field_viscosity": {"c_u": 100.0}}, (0.0, 0.1, 0.3, 0.0), 3.0),
    "field_stiffness": ({"field_stiffness": {"k_u": 1000.0}}, (0.01, 0.0, 0.3, 0.0), 3.0),
    "duty_dead_band": ({**YIELD, "duty_dead_band": {"u_0": 0.1}}, (0.0, 0.1, 0.3, 0.0), 4.0),
    "field_exponent": (
        {**YIELD, "field_exponent": {"b": 2.0, "u_r": 0.5}},
        (0.0, 0.1, 0.25, 0.0),
        2.5,  # 20 * 0.5 * (1/2)^2
    ),
    "field_saturation": (
        {**YIELD, "field_saturation": {"s": 2.0}},
        (0.0, 0.1, 0.25, 0.0),
        10.0 / 3.0,  # 20 0.25 / 1.5
    ),
    "velocity_lag": (
        {**PASSIVE, "velocity_lag": {"T_v": 0.01}},
        (0.0, 0.1, 0.0, 5.0),
        7.5,
    ),
    "deflection_zero": (
        {**PASSIVE, "deflection_zero": {"x_0": 0.002}},
        (0.01, 0.0, 0.0, 0.0),
        1.2,
    ),
    "velocity_gain": ({**PASSIVE, "velocity_gain": {"g_v": 2.0}}, (0.01, 0.1, 0.0, 0.0), 3.5),
    "force_gain": ({**PASSIVE, "force_gain": {"g_F": 1.5}}, (0.01, 0.1, 0.0, 0.0), 9.0),
    "duty_gain": ({**YIELD, "duty_gain": {"g_u": 0.5}}, (0.0, 0.1, 0.3, 0.0), 3.0),
}

# each row: its effects, own state, the point x v a u t, the rate of the state, and the force
RATES: dict[str, tuple[Values, float, tuple[float, float, float, float, float], float, float]] = {
    "response": ({**YIELD, "response": {"tau": 0.05}}, 1.0, (0.0, 0.1, 0.0, 0.3, 0.0), 100.0, 1.0),
    "response_quadratic": (  # 6 N - 1 N, over 0.01 + 0.1 * 0.3 + 1.0 * 0.09 s
        {**YIELD, "response_quadratic": {"tau_0": 0.01, "tau_1": 0.1, "tau_2": 1.0}},
        1.0,
        (0.0, 0.1, 0.0, 0.3, 0.0),
        5.0 / 0.13,
        1.0,
    ),
    "response_table": (  # duty 0.225 is the middle of 0.2 and 0.25: 45 ms
        {**YIELD, "response_table": TABLE},
        1.0,
        (0.0, 0.1, 0.0, 0.225, 0.0),
        3.5 / 0.045,
        1.0,
    ),
    "amplifier_lag": (
        {**YIELD, "amplifier_lag": {"T_a": 0.02}},
        0.1,
        (0.0, 0.1, 0.0, 0.3, 0.0),
        10.0,
        2.0,
    ),
    "self_heating": (  # 2 W above rest: 5 N e^-0.2 viscous, 6 N e^-0.1 yield
        {**PASSIVE, **YIELD, "self_heating": {"t_h": 10.0, "b_v": 0.1, "b_y": 0.05}},
        2.0,
        (0.0, 0.1, 0.0, 0.3, 0.0),
        (0.1 * 9.522678273605667 - 2.0) / 10.0,
        9.522678273605667,
    ),
    "mount_compliance": (  # 4/s of 20 mm, 0.1 + 1 / 50 m/s; 2 N in the mount, and 1e6 (-10 mm)^3
        {**PASSIVE, **CUBE, "mount_compliance": {"q": 0.01}},
        0.02,
        (0.01, 0.1, 0.0, 0.0, 0.0),
        0.04,
        1.0,
    ),
    "freeplay": (  # open, free of force: 100 N/m 9 mm and 1e6 (9 mm)^3 push the damper 50 Ns/m -0.03258 m/s
        {**PASSIVE, **CUBE, "freeplay": {"b": 0.002}},
        0.001,
        (0.01, 0.1, 0.0, 0.0, 0.0),
        0.13258,
        0.0,
    ),
    "cavitation": (  # 5 N pull where 4 N can be: 1 / 50 m/s less 2 / s of 3 mm; 3 / 4 of the newton is missing
        {**PASSIVE, "cavitation": {"F_v": 4.0, "r": 2.0, "w_s": 1e-3}},
        3e-3,
        (0.01, 0.1, 0.0, 0.0, 0.0),
        0.014,
        5.25,
    ),
    "cavitation: all that the fluid carries": (  # flow 5 0.841 + 1 + 2 + 1 + 3 N; springs, preload 6 N
        {
            **PASSIVE,
            "shear_thinning": {"n": 0.5, "v_r": 0.1},
            "quadratic_damping": {"c_2": 100.0},
            "asymmetric_damping": {"c_a": 20.0},
            "position_dependent_damping": {"c_x": 1e5},
            "field_viscosity": {"c_u": 100.0},
            "field_stiffness": {"k_u": 1000.0},
            "preload": {"F_0": 2.0},
            "cavitation": {"F_v": 4.0, "r": 0.0, "w_s": 1e-3},
        },
        3e-3,
        (0.01, 0.1, 0.0, 0.3, 0.0),
        (11.204482076268573 - 4.0) / 50.0,
        6.0 + 11.204482076268573 - 0.75 * (11.204482076268573 - 4.0),
    ),
    "cavitation: closing in compression": (  # 1 N where -4 N would be held: -5 / 50 m/s
        {**PASSIVE, "cavitation": {"F_v": -4.0, "r": 0.0, "w_s": 1e-3}},
        1e-3,
        (0.01, 0.02, 0.0, 0.0, 0.0),
        -0.1,
        -0.5,
    ),
    "bouc_wen_hysteresis": (
        {"bouc_wen_hysteresis": {"F_h": 2.0, "F_u": 10.0, "z_y": 1e-3}},
        -5e-4,
        (0.0, -0.1, 0.0, 0.3, 0.0),
        -0.05,
        -2.5,
    ),
    "viscoelastic_branch": (
        {"viscoelastic_branch": {"k_m": 100.0, "t_m": 0.05}},
        0.4,
        (0.0, 0.2, 0.0, 0.0, 0.0),
        12.0,
        0.4,
    ),
    "piston_play": (  # open: 6 tanh(100 9 mm + 10 (v - f_y / 100)), with v such that it is 6 tanh 1
        {
            "guo_yield": {"f_c": 20.0, "k1": 100.0, "c1": 10.0},
            "piston_play": {"b": 0.002, "c_p": 100.0},
        },
        0.001,
        (0.01, 0.05569564935734589, 0.0, 0.3, 0.0),
        0.04569564935734589,
        4.569564935734589,
    ),
    "force_lag": (
        {**PASSIVE, "force_lag": {"T_f": 0.01}},
        2.0,
        (0.0, 0.1, 0.0, 0.0, 0.0),
        300.0,
        5.0,
    ),
    "effectiveness_fade": (  # no state: 6 N (1 - 0.4 (1 - 1 / e))
        {**YIELD, "effectiveness_fade": {"s": 0.4, "t_f": 10.0}},
        0.0,
        (0.0, 0.1, 0.0, 0.3, 10.0),
        0.0,
        4.482910658811462,
    ),
    **{
        f"{fault}: {when}": (  # no state: 1 N stiffness, 5 N viscous, 6 N yield
            {
                **PASSIVE,
                **YIELD,
                fault: {"f": 0.6, "t_0": 2.0, "t_r": t_r, "q": q, "d": 0.25},
            },
            0.0,
            (0.01, 0.1, 0.0, 0.3, t),
            0.0,
            1.0 * stiff + 5.0 * viscous + 6.0 * field,
        )
        for fault, losses in {
            "electrical_fault": (0.0, 0.0, 1.0),
            "oil_leakage": (1.0, 1.0, 1.0),
            "duct_deformation": (0.0, 1.0, 1.0),
        }.items()
        for when, t_r, q, t, loss in (
            ("before it", 0.0, 0.0, 1.9, 0.0),
            ("a step", 0.0, 0.0, 2.0, 0.4),
            ("half grown", 1.0, 0.0, 2.5, 0.2),
            ("grown", 1.0, 0.0, 50.0, 0.4),
            ("gone for a while", 0.0, 0.25, 3.5, 0.0),
            ("back, half grown", 1.0, 0.25, 6.5, 0.2),
        )
        for stiff, viscous, field in [tuple(1.0 - loss * part for part in losses)]
    },
    "varying_time_constant": (  # (6 - 1) N / (0.05 s (1 + 5 0.3 + 10 0.3^2))
        {**YIELD, "response": {"tau": 0.05}, "varying_time_constant": {"g": 5.0, "h": 10.0}},
        1.0,
        (0.0, 0.1, 0.0, 0.3, 0.0),
        29.411764705882355,
        1.0,
    ),
    "rise_fall_asymmetry": (  # 8 / (8 + 0.05 6) = 0.964: -2 N / (0.05 s 2^0.982)
        {**YIELD, "response": {"tau": 0.05}, "rise_fall_asymmetry": {"r": 2.0}},
        8.0,
        (0.0, 0.1, 0.0, 0.3, 0.0),
        -20.252110894616408,
        8.0,
    ),
}

# each row: parameters, and the delay; what a delay does to a record is in test_integrator_damper
DELAYS: dict[str, tuple[Mapping[str, float], float]] = {
    "dead_time": ({"T_d": 0.0123}, 0.0123),
    "force_delay": ({"d": -0.0042}, -0.0042),
}

# each row: its effects, a velocity held for 0.05 s from where its states rest, the duty, and the force at the end
STROKES: dict[str, tuple[Values, float, float, float]] = {
    "passive_by_direction: cavitation": (  # a void of 0.05 s 1 N / 50 Ns/m = w_s: half of 1 N lacks at 0.5 + 5 N
        {
            "passive_by_direction": {
                "k0_c": 300.0,
                "c0_c": 20.0,
                "k0_r": 100.0,
                "c0_r": 50.0,
                "v_0": 1e-3,
            },
            "cavitation": {"F_v": 4.0, "r": 0.0, "w_s": 1e-3},
        },
        0.1,
        0.0,
        5.0,
    ),
    "piston_play": (  # closed: 6 tanh(100 (2.5 - 0.5) mm + 16 0.05 m/s)
        {
            "guo_yield": {"f_c": 20.0, "k1": 100.0, "c1": 16.0},
            "piston_play": {"b": 5e-4, "c_p": 20.0},
        },
        0.05,
        0.3,
        4.569564935734589,
    ),
}


@pytest.mark.parametrize("name", FORCES)
def test_force(name: str) -> None:
    effects, (x, v, u, a), expected = FORCES[name]
    found = predict(Model(name, effects, SMALL), one_sample(x, v, u, a))[0]
    assert found == pytest.approx(expected, rel=1e-7)


@pytest.mark.parametrize("name", RATES)
def test_rate(name: str) -> None:
    effects, w, (x, v, a, u, t), rate, force = RATES[name]
    slot = CATALOGUE.slots.get(name.split(":")[0], CATALOGUE.slots["response"])
    state = np.zeros(CATALOGUE.n_states)
    state[slot] = w
    rates, found = damper_rate(Model(name, effects, SMALL), state, x, v, a, u, t)
    assert found == pytest.approx(force, rel=1e-7, abs=1e-9)
    assert rates[slot] == pytest.approx(rate, rel=1e-6)


@pytest.mark.parametrize("name", STROKES)
def test_stroke(name: str) -> None:
    effects, v, u, expected = STROKES[name]
    t = np.arange(11) * DT
    found = predict(Model(name, effects, SMALL), motion(DT, v * t, 0.0 * t + v, 0.0 * t + u))
    assert found[-1] == pytest.approx(expected, rel=1e-7)


@pytest.mark.parametrize("name", DELAYS)
def test_delay(name: str) -> None:
    parameters, expected = DELAYS[name]
    found = [f(**parameters) for h, f in CATALOGUE[name].hooks.items() if h.endswith("_delay")]
    assert found == [expected]


def test_rise_is_not_fall() -> None:
    """The same distance from the target, from below: nearly the plain time constant, 0.05 s 2^0.0349."""
    effects, _, (x, v, a, u, t), _, _ = RATES["rise_fall_asymmetry"]
    state = np.zeros(CATALOGUE.n_states)
    state[CATALOGUE.slots["response"]] = 4.0
    rates, _ = damper_rate(Model("rise", effects, SMALL), state, x, v, a, u, t)
    assert rates[CATALOGUE.slots["response"]] == pytest.approx(39.04441722605839, rel=1e-6)


CAR = {"m_s": 2.0, "m_us": 0.5, "k_s": 1000.0, "k_t": 10000.0}
STATE = (0.01, 0.3, 0.001, 0.2, 0.05)
"""Deflection, velocity of the body, deflection of the tyre, velocity of the wheel, rate of the road."""

# each row: its effect, the state, and the accelerations of body and wheel that are reported; passive damper.
# plain car: k_s 1000 N/m 10 mm + 6 N = 16 N on 2 kg; tyre 10 kN/m 1 mm = 10 N; 0.5 kg wheel.
RIDES: dict[str, tuple[Mapping[str, float], tuple[float, ...], tuple[float, float]]] = {
    "quarter_car": (CAR, STATE, (-8.0, 12.0)),
    "tyre_damping": ({"c_t": 20.0}, STATE, (-8.0, 6.0)),  # 20 N s/m 0.15 m/s = 3 N
    "tyre_lift_off": (  # 50 N pull, 2.5 kg half carried by the tyre: 12.2583125 N
        {"r": 0.5},
        (0.01, 0.3, 0.005, 0.2, 0.05),
        (-8.0, 7.483375),
    ),
    "guide_friction": (  # 2 tanh 1 beside the 16 N
        {"F_g": 2.0, "v_0": 0.1},
        STATE,
        (-8.0 - 0.7615941559557649, 12.0 + 4.0 * 0.7615941559557649),
    ),
    "spring_nonlinearity": ({"k_3": 1e6, "x_c": -0.01}, STATE, (-11.5, 26.0)),  # 8 N - 1 N
    "sprung_mass_error": ({"e": 0.6}, STATE, (-5.0, 12.0)),
    "accelerometer_bias": ({"b_s": 0.5, "b_us": -0.25}, STATE, (-7.5, 11.75)),
}


@pytest.mark.parametrize("name", RIDES)
def test_ride(name: str) -> None:
    values, (x, v_s, z_t, v_us, road_rate), expected = RIDES[name]
    model = Model(name, {**PASSIVE, "quarter_car": CAR, name: values}, SMALL)
    c, out = model.compiled(plant=True), np.zeros((1, 6))
    w, rate = np.zeros(CATALOGUE.n_states), np.zeros(CATALOGUE.n_states)
    kernel(CATALOGUE).vehicle_point(
        c.on, c.slots, c.links, c.p, np.array([x, v_s, z_t, v_us]), w, 0.0, 0.0, road_rate, rate, rate, out
    )  # fmt: skip
    assert out[0, 4:] == pytest.approx(expected, rel=1e-9)


def test_quarter_car_moves_as_its_forces_say() -> None:
    model = Model("car", {**PASSIVE, "quarter_car": CAR}, SMALL)
    dq, _, outputs = vehicle_rate(
        model, np.array(STATE[:4]), np.zeros(CATALOGUE.n_states), 0.0, STATE[4]
    )
    assert outputs == pytest.approx([-8.0, 12.0, 6.0], rel=1e-9)
    assert dq == pytest.approx([0.1, -8.0, 0.15, 12.0], rel=1e-9)


def test_the_bias_of_an_accelerometer_moves_nothing() -> None:
    biased = {"b_s": 0.5, "b_us": -0.25}
    model = Model("car", {**PASSIVE, "quarter_car": CAR, "accelerometer_bias": biased}, SMALL)
    _, _, outputs = vehicle_rate(
        model, np.array(STATE[:4]), np.zeros(CATALOGUE.n_states), 0.0, STATE[4]
    )
    assert outputs == pytest.approx([-8.0, 12.0, 6.0], rel=1e-9)


def test_every_effect_has_its_value() -> None:
    rows = (*FORCES, *RATES, *RIDES, *DELAYS, *STROKES)
    assert {row.partition(":")[0] for row in rows} == set(CATALOGUE.names)
