"""The shipped damper files of chapter 1 against its equations and tables, typed here once more."""

from __future__ import annotations

import numpy as np
import pytest
from er_models.catalogue import CATALOGUE
from er_models.errors import InputError
from er_models.files import load_model
from er_models.linear import NotThisForm, linearise
from er_models.model import Array, Model
from er_models.prediction import motion, predict
from er_models.rhs import damper_rate
from er_models.simulation import simulate
from models_help import CONFIG, DT, SMALL, Sine, imposed, one_sample, span
from reference import damper_force, vehicle_run

# Tables 1.2, 1.3: compression, release
K_0, C_0 = (263.1168, 170.4045), (64.6433, 68.8289)
SIGMA, BETA = (12.8157, 17.0442), (0.2373, 0.3948)
F_C, K_1, C_1 = (29.2780, 28.0699), (204.0283, 218.1615), (492.6448, 512.6200)
TABLE_1_4 = ((0.1, 0.15, 0.2, 0.25, 0.3), (0.0137, 0.0221, 0.0365, 0.055, 0.0631))
DUTIES = (0.05, 0.1, 0.13, 0.2, 0.225, 0.3, 0.4)
FILES = tuple(
    f"inove_{law}{kind}"
    for law, kinds in {
        "guo": ("_static", "", "_two_sided", "_tau_quadratic", "_tau_table", "_complete"),
        "bingham": ("", "_dynamic", "_two_sided", "_tau_quadratic", "_tau_table", "_complete"),
    }.items()
    for kind in kinds
)
EACH = pytest.mark.parametrize("name", FILES)
TWO_SIDED = pytest.mark.parametrize("name", ["inove_guo_two_sided", "inove_bingham_two_sided"])


def shipped(name: str) -> Model:
    return load_model(CONFIG / "dampers" / f"{name}.yaml")


def printed_force(name: str, x: float, v: float, u: float) -> float:
    """(1.6) or (1.10) with the set of the direction: the force in equilibrium."""
    i = int(v > 0.0 and ("two_sided" in name or "complete" in name))
    passive = K_0[i] * x + C_0[i] * v
    if "bingham" in name:
        return passive + SIGMA[i] * u ** BETA[i] * np.sign(v)
    return passive + F_C[i] * u * np.tanh(K_1[i] * x + C_1[i] * v)


def printed_response_time(name: str, u: float) -> float:
    """(1.21), Table 1.4 or the nominal value [s]; 0: static."""
    if name in ("inove_guo_static", "inove_bingham"):
        return 0.0
    if "quadratic" in name:
        return 0.3643 * u**2 + 0.1124 * u + 0.002
    if "table" in name or "complete" in name:
        return float(np.interp(u, *TABLE_1_4))
    return 0.0365


@EACH
def test_force_is_the_printed_law(name: str) -> None:
    """At ten widths of the change of direction and beyond, where the smooth step is a step."""
    model = shipped(name)
    for v in (-0.15, -0.01, 0.01, 0.08):
        for x in (-0.01, 0.0, 0.006):
            for u in DUTIES:
                found = predict(model, one_sample(x, v, u))[0]
                assert found == pytest.approx(printed_force(name, x, v, u), abs=1e-6)


@EACH
def test_response_time_is_the_printed_one(name: str) -> None:
    model, slot = shipped(name), CATALOGUE.slots["response"]
    for u in DUTIES:
        rates, force = damper_rate(model, np.zeros(CATALOGUE.n_states), 0.0, 0.1, 0.0, u)
        asked = printed_force(name, 0.0, 0.1, u) - printed_force(name, 0.0, 0.1, 1e-300)
        if printed_response_time(name, u) == 0.0:
            assert not model.has_response
            assert force == pytest.approx(printed_force(name, 0.0, 0.1, u), abs=1e-6)
        else:
            assert asked / rates[slot] == pytest.approx(printed_response_time(name, u), rel=1e-6)


def test_the_polynomial_is_not_the_table() -> None:
    """(1.21) departs from Table 1.4 by up to 5.4 ms, and is not its best quadratic either."""
    duties, table = (np.array(row) for row in TABLE_1_4)
    printed = np.array([printed_response_time("inove_guo_tau_quadratic", u) for u in duties])
    best = np.polyval(np.polyfit(duties, table, 2), duties)
    assert np.abs(printed - table).max() == pytest.approx(5.4e-3, abs=0.05e-3)
    assert np.std(best - table) < 0.7 * np.sqrt(np.mean((printed - table) ** 2))


def test_the_model_of_guo_is_a_special_case() -> None:
    """(1.9) is (1.10) at one duty, with stiffness and damping in the proportion of k1 and c1."""
    a_1, a_2, a_3, ratio, u = 6.0, 65.0, 500.0, 0.4, 0.2  # ratio: V_0 / X_0
    effects = {
        "passive": {"k0": a_2 * ratio, "c0": a_2},
        "guo_yield": {"f_c": a_1 / u, "k1": a_3 * ratio, "c1": a_3},
    }
    for x, v in ((0.004, 0.001), (-0.006, 0.002), (0.002, -0.1)):
        lean = v + ratio * x
        found = predict(Model("guo 2006", effects, SMALL), one_sample(x, v, u))[0]
        assert found == pytest.approx(a_2 * lean + a_1 * np.tanh(a_3 * lean), rel=1e-9)


@TWO_SIDED
def test_the_change_of_direction_converges_to_the_printed_jump(name: str) -> None:
    """Half the width squares the distance: it decays as exp(-2 |v| / v_0)."""
    for v in (-4e-4, 4e-4):
        exact = printed_force(name, 0.008, v, 0.2)
        errors = [abs(static_force(name, width, 0.008, v) - exact) for width in (4e-4, 2e-4, 1e-4)]
        assert errors[1] < 0.25 * errors[0]
        assert errors[2] < 0.05 * errors[1]


@TWO_SIDED
def test_the_stiffness_jumps_at_zero_velocity(name: str) -> None:
    """What the printed law does at a reversal without field: (k0_r - k0_c) x."""
    above, below = (static_force(name, 1e-9, 0.008, v, u=0.0) for v in (1e-7, -1e-7))
    assert above - below == pytest.approx((K_0[1] - K_0[0]) * 0.008, abs=1e-4)


def static_force(name: str, width: float, x: float, v: float, u: float = 0.2) -> float:
    """Force in equilibrium with another width of the change of direction."""
    model = shipped(name)
    for effect, values in list(model.effects.items()):
        if "v_0" in values:
            model = model.with_effect(effect, {**values, "v_0": width})
    return float(predict(model, one_sample(x, v, u))[0])


def test_a_stiffness_with_a_direction_is_no_spring() -> None:
    """Around an extended mean position the printed law gives energy: (k0_c - k0_r) x_m times the stroke."""
    model = shipped("inove_guo_two_sided").without_effect("guo_yield_by_direction")
    t = np.linspace(0.0, 1.0, 20001)
    swing, mean = 0.004, 0.006
    x, v = mean + swing * np.sin(2 * np.pi * t), 2 * np.pi * swing * np.cos(2 * np.pi * t)
    force = predict(model, motion(t[1], x, v, np.zeros(t.size)))
    viscous = 0.5 * sum(C_0) * np.mean(v**2)
    work = float(np.sum(0.5 * (force * v)[1:] + 0.5 * (force * v)[:-1]) * t[1])
    assert work - viscous == pytest.approx((K_0[1] - K_0[0]) * mean * 2 * swing, rel=0.02)


@pytest.mark.parametrize("name", ["inove_guo_complete", "inove_bingham_complete"])
def test_the_integrator_follows_it_on_an_imposed_motion(name: str) -> None:
    inputs = imposed(SMALL, 0.6)
    exact = damper_force(shipped(name), inputs, Sine(SMALL).derivative)
    assert np.abs(predict(shipped(name), inputs) - exact).max() < 5e-4 * span(exact)


@pytest.mark.parametrize("name", ["inove_guo_complete", "inove_bingham_complete"])
def test_the_integrator_follows_it_in_the_car(name: str) -> None:
    model = in_the_car(shipped(name))
    t = np.arange(81) * DT
    road = 0.004 * np.sin(2.0 * np.pi * 2.0 * t) + 0.0005 * np.sin(2.0 * np.pi * 9.0 * t)
    duty = np.where(np.mod(t + 1e-9, 0.2) < 0.1, 0.25, 0.05)
    states, force = vehicle_run(model, DT, road, duty)
    run = simulate(model, DT, road, duty)
    assert np.abs(run["damper_force"] - force).max() < 2e-3 * span(force)
    assert np.abs(run["deflection"] - states[:, 0]).max() < 1e-3 * span(states[:, 0])


def in_the_car(damper: Model) -> Model:
    car = load_model(CONFIG / "vehicles" / "inove_quarter_car.yaml")
    effects = {**damper.effects, "quarter_car": car.effects["quarter_car"]}
    return Model(damper.name, effects, damper.scales)


@EACH
def test_linear_forms_take_one_set_and_one_constant_only(name: str) -> None:
    """The thesis designs observers and controllers with (1.22) alone; what cannot be held is named."""
    model = in_the_car(shipped(name))
    if name == "inove_guo":
        form = linearise(model)
        assert form.B[4] == pytest.approx(F_C[0] / 0.0365, rel=1e-9)
        assert form.A[4, 4] == pytest.approx(-1.0 / 0.0365, rel=1e-9)
        return
    culprit = {
        "inove_guo_two_sided": "passive_by_direction, guo_yield_by_direction",
        "inove_bingham_two_sided": "passive_by_direction, bingham_yield_by_direction",
        "inove_bingham_dynamic": "bingham_yield",
    }.get(name, "response_table" if printed_response_time(name, 0.2) else "nothing")
    culprit = "response_quadratic" if "quadratic" in name else culprit
    with pytest.raises((InputError, NotThisForm), match=culprit):
        linearise(model)


def test_series_elements_see_the_stiffness_of_the_direction() -> None:
    """A mount in series: the force is the printed law at the damper's own deflection and velocity.

    Where the mount's motion turns the direction round, the direction of the measured motion counts: this
    is what is left.
    """
    model = shipped("inove_guo_two_sided").without_effect("guo_yield_by_direction")
    model = model.without_effect("response").with_effect("mount_compliance")
    q, omega = model.value("mount_compliance", "q"), 2 * np.pi * 3.0
    t = np.linspace(0.0, 1.0, 4001)
    x, v = 0.008 * np.sin(omega * t), 0.008 * omega * np.cos(omega * t)
    force = predict(model, motion(t[1], x, v, np.zeros(t.size)))
    inner = x - q * force
    speed = np.gradient(inner, t)
    i = (speed > 0.0).astype(int)
    left = (force - np.take(K_0, i) * inner - np.take(C_0, i) * speed)[t > 0.4]
    assert _rms(left) < 0.006 * span(force)
    assert np.median(np.abs(left)) < 1e-5 * span(force)


def _rms(y: Array) -> float:
    return float(np.sqrt(np.mean(y**2)))
