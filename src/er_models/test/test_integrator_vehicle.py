"""The quarter car: against SciPy, energy, rest, and one sample at a time against the whole record."""

from __future__ import annotations

import er_models.simulation as simulation
import numpy as np
import pytest
from er_models.errors import InputError
from er_models.files import load_model
from er_models.model import Array, Model
from er_models.program import Program, times
from er_models.simulation import initial_state, prepare, simulate, step, straight
from models_help import CONFIG, DT, car, guo, span
from reference import vehicle_run
from scipy.integrate import solve_ivp


def inputs(seconds: float, dt: float = DT) -> tuple[Array, Array]:
    """A road of two sines and a duty that steps."""
    t = times(seconds, dt)
    road = 0.004 * np.sin(2.0 * np.pi * 2.0 * t) + 0.0005 * np.sin(2.0 * np.pi * 9.0 * t)
    return road, np.where(np.mod(t + 1e-9, 0.4) < 0.2, 0.25, 0.05)


def with_damper(damper: Model) -> Model:
    """The quarter car with another damper."""
    return Model(
        "other", {**damper.effects, "quarter_car": car().effects["quarter_car"]}, damper.scales
    )


def bingham_car() -> Model:
    return with_damper(load_model(CONFIG / "dampers" / "inove_bingham.yaml"))


def test_converges_with_second_order(monkeypatch: pytest.MonkeyPatch) -> None:
    """Against a step sixteen times smaller; smooth enough a gate for the order to show."""
    model = car().with_effect("guo_yield", {"f_c": 29.0, "k1": 20.0, "c1": 20.0})
    road, duty = inputs(0.5)

    def force(fraction: int) -> Array:
        monkeypatch.setattr(simulation, "SUBSTEP", DT / fraction)
        return simulate(model, DT, road, duty)["damper_force"]

    exact = force(256)
    e = [np.abs(force(n) - exact).max() for n in (4, 8, 16)]
    assert 3.4 < e[0] / e[1] < 4.8
    assert 3.4 < e[1] / e[2] < 4.8


@pytest.mark.parametrize(
    "names", [(), ("fluid_inertia",), ("viscoelastic_branch",), ("mount_compliance",)]
)
def test_against_scipy(names: tuple[str, ...]) -> None:
    model = car()
    for name in names:
        model = model.with_effect(name)
    road, duty = inputs(0.4)
    states, force = vehicle_run(model, DT, road, duty)
    run = simulate(model, DT, road, duty)
    assert np.abs(run["damper_force"] - force).max() < 1e-3 * span(force)
    assert np.abs(run["deflection"] - states[:, 0]).max() < 1e-3 * span(states[:, 0])
    assert np.abs(run["tyre_deflection"] - states[:, 2]).max() < 1e-3 * span(states[:, 2])


def test_a_force_beside_the_damper_against_equations_written_anew() -> None:
    """SciPy on the thesis's (2.1)-(2.5) and (1.22) with F_a beside F_d, all of it written here."""
    model = car()
    p, d, g = (model.effects[name] for name in ("quarter_car", "passive", "guo_yield"))
    tau = model.value("response", "tau")
    road, duty = inputs(1.0)
    t = DT * np.arange(road.size)
    force = 6.0 * np.sin(2.0 * np.pi * 3.0 * t) + 2.0 * (t > 0.3)

    def rate(s: float, y: Array) -> Array:
        z_s, z_us, v_s, v_us, f_y = y
        x, v, f_a = z_s - z_us, v_s - v_us, np.interp(s, t, force)
        u = duty[min(int(s / DT + 1e-9), duty.size - 1)]
        f = p["k_s"] * x + d["k0"] * x + d["c0"] * v + f_y + f_a
        tyre = p["k_t"] * (z_us - np.interp(s, t, road))
        gate = g["f_c"] * u * np.tanh(g["k1"] * x + g["c1"] * v)
        return np.array([v_s, v_us, -f / p["m_s"], (f - tyre) / p["m_us"], (gate - f_y) / tau])

    y, states = np.array([road[0], road[0], 0.0, 0.0, 0.0]), []
    for k in range(road.size):
        states.append(y)
        y = solve_ivp(rate, (t[k], t[k] + DT), y, method="LSODA", rtol=1e-9, atol=1e-12).y[:, -1]
    exact = np.array(states)
    run = simulate(model, DT, road, duty, actuator_force=force)
    for name, y in {
        "sprung_displacement": exact[:, 0],
        "unsprung_displacement": exact[:, 1],
        "deflection": exact[:, 0] - exact[:, 1],
        "damper_force": [
            -p["m_s"] * rate(s, e)[2] - p["k_s"] * (e[0] - e[1]) - np.interp(s, t, force)
            for s, e in zip(t, exact)
        ],
        "sprung_acceleration": [rate(s, e)[2] for s, e in zip(t, exact)],
        "unsprung_acceleration": [rate(s, e)[3] for s, e in zip(t, exact)],
    }.items():
        assert np.abs(run[name] - y).max() < 1e-3 * span(np.asarray(y)), name
    without = simulate(model, DT, road, duty)
    assert np.abs(run["deflection"] - without["deflection"]).max() > 0.1 * span(run["deflection"])
    with pytest.raises(InputError, match="actuator_force: expected samples as the duty"):
        simulate(model, DT, road, duty, actuator_force=force[:-1])


@pytest.mark.parametrize("model", [with_damper(guo().without_effect("response")), bingham_car()])
def test_static_damper_at_full_duty_is_stable_and_right(
    model: Model, monkeypatch: pytest.MonkeyPatch
) -> None:
    """At duty 1 the gate is 1e5 times stiffer than the car: against a step eight times smaller."""
    road, duty = inputs(1.0)
    duty = np.where(duty > 0.1, 1.0, 0.5)
    run = simulate(model, DT, road, duty)
    monkeypatch.setattr(simulation, "SUBSTEP", simulation.SUBSTEP / 8.0)
    fine = simulate(model, DT, road, duty)
    for channel in ("damper_force", "deflection", "deflection_velocity"):
        error = run[channel] - fine[channel]
        assert error.std() < 2e-3 * span(fine[channel])
    assert np.abs(run["damper_force"]).max() < 60.0


@pytest.mark.parametrize("model", [car(), bingham_car()], ids=("guo", "bingham"))
def test_energy_is_balanced(model: Model) -> None:
    """Change of kinetic and spring energy = work of the road - work done on the damper."""
    dt = 1.25e-4
    road, duty = inputs(1.0, dt)
    run = simulate(model, dt, road, duty)
    p, x, z_t = model.effects["quarter_car"], run["deflection"], run["tyre_deflection"]
    v_s = np.concatenate([[0.0], np.cumsum(_pieces(run["sprung_acceleration"], dt))])
    v_us = v_s - run["deflection_velocity"]
    stored = 0.5 * (p["m_s"] * v_s**2 + p["m_us"] * v_us**2 + p["k_s"] * x**2 + p["k_t"] * z_t**2)
    damper = np.sum(_pieces(run["damper_force"] * run["deflection_velocity"], dt))
    tyre = -p["k_t"] * z_t
    from_road = np.sum(0.5 * (tyre[1:] + tyre[:-1]) * np.diff(road)) * -1.0
    assert damper > 0.0
    change = stored[-1] - stored[0]
    assert change == pytest.approx(-from_road - damper, abs=2e-3 * damper)


def _pieces(y: Array, dt: float) -> Array:
    """Integral of a signal over each sample interval."""
    return 0.5 * dt * (y[1:] + y[:-1])


def _stepped(model: Model, road: Array, duty: Array) -> dict[str, Array]:
    """Outputs of the plant, one sample at a time; the first row is the start."""
    plant = prepare(model, DT)
    state, rows = initial_state(plant, float(road[0]), float(duty[0])), []
    lines = (road.size - 1) // (duty.size - 1)
    for way, held in zip(road[1:].reshape(-1, lines), duty, strict=False):
        state, o = step(plant, state, (way, float(held)))
        rows.append((*o, state.q[2]))
    names = (
        "sprung_acceleration", "unsprung_acceleration", "deflection", "deflection_velocity",
        "true_force", "damper_force", "tyre_deflection",
    )  # fmt: skip
    return dict(zip(names, np.array(rows).T))


@pytest.mark.parametrize(
    "names",
    [
        (),
        ("dead_time", "mount_compliance"),
        ("effectiveness_fade", "self_heating", "force_lag"),
        ("deflection_zero", "velocity_lag", "force_delay"),
    ],
)
def test_one_sample_at_a_time_is_the_whole_record(names: tuple[str, ...]) -> None:
    """Bit for bit, so that a node and a record tell the same story."""
    model = car()
    for name in names:
        model = model.with_effect(name)
    road, duty = inputs(1.0)
    whole, stepped = simulate(model, DT, road, duty), _stepped(model, road, duty)
    for channel in set(whole) & set(stepped):
        assert np.array_equal(whole[channel][1:], stepped[channel]), channel


def test_step_leaves_its_state_alone() -> None:
    plant = prepare(car(), DT)
    state = initial_state(plant, 0.0, 0.2, np.array([0.005, 0.0, 0.0, 0.0]))
    before = [np.copy(part) for part in state]
    first, second = step(plant, state, (0.001, 0.1)), step(plant, state, (0.001, 0.1))
    assert all(np.array_equal(a, b) for a, b in zip(before, state))
    assert first[1] == second[1]


def test_dead_time_outlasts_any_sample_time() -> None:
    """A memory counted in samples would forget the duty at a fast rate."""
    model = car().with_effect("dead_time", {"T_d": 0.03})
    road, duty = inputs(0.6, 1e-3)
    later = np.concatenate([np.full(30, duty[0]), duty[:-30]])
    delayed = simulate(model, 1e-3, road, duty)["damper_force"]
    shifted = simulate(car(), 1e-3, road, later)["damper_force"]
    assert delayed == pytest.approx(shifted, abs=1e-9)


def test_starts_where_it_is_told() -> None:
    q = np.array([0.005, 0.1, -0.001, 0.05])
    run = simulate(car(), DT, np.zeros(10), np.full(10, 0.1), q)
    assert run["deflection"][0] == q[0]
    assert run["deflection_velocity"][0] == pytest.approx(0.05)
    gate = np.tanh(204.0283 * 0.005 + 492.6448 * 0.05)
    force = 263.1168 * 0.005 + 64.6433 * 0.05 + 2.9278 * gate
    assert run["damper_force"][0] == pytest.approx(force, rel=1e-9)
    a_s = -(1396.0 * 0.005 + force) / 2.27
    assert run["sprung_acceleration"][0] == pytest.approx(a_s, rel=1e-9)


def test_stays_at_rest_on_a_flat_road() -> None:
    for model in (car(), bingham_car()):
        run = simulate(model, DT, np.full(100, 0.02), np.full(100, 0.3))
        assert np.abs(run["damper_force"]).max() == 0.0
        assert np.abs(run["deflection"]).max() == 0.0


def test_settles_to_rest_after_a_step_of_the_road() -> None:
    run = simulate(car(), DT, np.concatenate([np.zeros(10), np.full(2000, 0.01)]), np.zeros(2010))
    assert abs(run["deflection"][-1]) < 1e-8
    assert np.abs(run["deflection"]).max() > 1e-3


def test_a_damper_alone_is_no_vehicle() -> None:
    with pytest.raises(InputError, match="quarter_car: expected a vehicle model"):
        prepare(guo(), DT)


@pytest.mark.parametrize(
    ("road", "least"),
    [
        ({"kind": "iso8608", "road_class": "C", "factor": 0.2}, 0.01),
        ({"kind": "bumps", "height": 0.004, "length": 0.2, "spacing": 6.0, "edge": 0.05}, 0.1),
    ],
    ids=("iso8608", "sharp bumps"),
)
def test_a_road_goes_on_between_samples(road: dict[str, object], least: float) -> None:
    """As in samples that are as short as the steps; a road that is straight between samples is another one."""
    program, lines = Program(road, {"kind": "steps"}, 1.5, 3), simulation.substeps(DT)
    heights, duty = program.ride(DT)
    run = simulate(car(), DT, heights, duty)
    held = np.repeat(duty, lines)[: heights.size]
    fine = simulate(car(), DT / lines, heights, held)
    held_apart = Program({**road, "straight": DT}, program.duty, 1.5, 3).ride(DT)[0]
    assert held_apart == pytest.approx(straight(heights[::lines], DT), abs=1e-12)
    bent = simulate(car(), DT, held_apart, duty)
    for channel in ("unsprung_acceleration", "damper_force", "tyre_deflection"):
        size = float(np.std(fine[channel]))
        assert np.std(run[channel] - fine[channel][::lines]) < 1e-6 * size
    off = np.std(run["unsprung_acceleration"] - bent["unsprung_acceleration"])
    assert off > least * np.std(bent["unsprung_acceleration"])
    stepped = _stepped(car(), heights, duty)
    assert np.array_equal(stepped["deflection"], run["deflection"][1:])


def test_a_road_that_does_not_fit_the_duty_is_refused() -> None:
    for points in (12, 21, 33 * 9):
        with pytest.raises(InputError, match="a divisor of 16 of its heights"):
            simulate(car(), DT, np.zeros(points), np.zeros(10))
