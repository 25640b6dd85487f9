"""Each hidden effect vanishes at zero, acts where it should, shows as much as promised."""

from __future__ import annotations

import numpy as np
import pytest
from scipy.integrate import solve_ivp, trapezoid
from scipy.interpolate import CubicSpline

from test.blind import calibrate, plant, refit
from test.blind.catalogue import BY_NAME, VEHICLE
from test.blind.integrate import LEAD_SAMPLES, SAMPLE, STEP, SUBSTEPS
from test.blind.jit import Array
from test.blind.measure import COLUMNS
from test.blind.short import complete, hidden_alone, short_motion
from test.blind.slots import KS, KT, MS, MU, OF, OFER, OVS, OVU, OZS, OZU

pytestmark = pytest.mark.slow

NAMES = tuple(BY_NAME)
SHOWN = tuple(name for name in NAMES if BY_NAME[name].shown_by_force)
ACTS_ON_SIGNAL_ONLY = {
    "force_delay",
    "outside:mains_hum",
    "outside:random_walk_drift",
    "outside:field_crosstalk",
    *(e.name for e in BY_NAME.values() if "shown" in e.acts),
}


def test_base_is_off_by_at_most_12_percent_and_differs() -> None:
    bases = np.array([plant.draw_base(np.random.default_rng(seed)) for seed in range(50)])
    off = np.abs(bases / plant.NOMINAL - 1.0)
    assert off.max() <= 0.12
    assert (off.max(axis=0) > 0.09).all()


@pytest.mark.parametrize("rig", ["car", "damper"])
@pytest.mark.parametrize("seed", [1, 2])
def test_motion_stays_in_the_rig_s_range(rig: plant.Rig, seed: int) -> None:
    motions, base = short_motion(seed, rig)
    for record in calibrate.clean_records(motions, plant.NO_EFFECT, base, 6.0):
        velocity = np.abs(record["deflection_velocity"]).max()
        assert 0.04 < velocity < 0.17
        assert 0.0015 < np.abs(record["deflection"]).max() < 0.0125
    if rig == "damper":
        assert not np.any(record["unsprung_acceleration"])
        derived = np.gradient(record["deflection_velocity"], record["t"])
        np.testing.assert_allclose(derived[1:-1], record["sprung_acceleration"][1:-1], atol=0.15)


def test_complete_model_leaves_nothing() -> None:
    motions, base = short_motion(1, "damper")
    left = refit.refit(calibrate.clean_records(motions, plant.NO_EFFECT, base, 6.0))
    assert left.rms < 0.002
    np.testing.assert_allclose(left.parameters[:6], base, rtol=0.01)


@pytest.mark.parametrize("name", NAMES)
def test_zero_strength_is_the_base_model_exactly(name: str) -> None:
    motions, base = short_motion(1)
    one, _ = hidden_alone(name, 1)
    row = one.row.copy()
    row[0] = 0.0
    table = calibrate.table_of([calibrate.Hidden(one.effect, row, 0.0, 0.0)])
    records = calibrate.clean_records(motions, table, base, 6.0)
    for record, reference in zip(records, complete(1), strict=True):
        for column in COLUMNS:
            np.testing.assert_array_equal(record[column], reference[column])


@pytest.mark.parametrize("name", NAMES)
def test_effect_changes_what_it_should(name: str) -> None:
    pairs = list(zip(hidden_alone(name, 1)[1], complete(1), strict=True))
    changed = {c for c in COLUMNS for new, old in pairs if np.any(new[c] != old[c])}
    if name == "accelerometer_bias":
        assert changed == {"sprung_acceleration", "unsprung_acceleration"}
    elif name in ACTS_ON_SIGNAL_ONLY:
        assert len(changed) == 1
    else:
        assert {"damper_force", "deflection", "sprung_acceleration"} <= changed
    assert not changed & {"t", "road", "duty"}


@pytest.mark.parametrize("seed", [1, 3])
@pytest.mark.parametrize("name", SHOWN)
def test_excess_is_10_to_600_percent(name: str, seed: int) -> None:
    one, records = hidden_alone(name, seed)
    left = refit.refit(list(records), offset=name != "preload").rms
    assert 0.10 <= refit.excess(left, 0.15) <= 6.0
    assert refit.excess(left, 0.15) == pytest.approx(one.rise)


@pytest.mark.parametrize(
    "names",
    [
        (),
        ("coulomb_friction",),
        ("end_stop", "fluid_inertia"),
        ("freeplay",),
        ("mount_compliance", "fluid_inertia"),
        ("cavitation", "self_heating"),
    ],
)
def test_energy_balance_of_the_car(names: tuple[str, ...]) -> None:
    """Stored energy plus what the damper took equals the work of the road."""
    motions, base = short_motion(2)
    table = calibrate.table_of([hidden_alone(name, 2)[0] for name in names])
    fine = plant.trajectory(motions[0], table, base)[LEAD_SAMPLES * SUBSTEPS :]
    road = motions[0].drive[::2, 0][LEAD_SAMPLES * SUBSTEPS :]
    m_s, m_u, k_s, k_t = plant.CAR[[MS, MU, KS, KT]]
    stroke, tyre = fine[:, OZS] - fine[:, OZU], fine[:, OZU] - road
    stored = 0.5 * (m_s * fine[:, OVS] ** 2 + m_u * fine[:, OVU] ** 2)
    stored += 0.5 * (k_s * stroke**2 + k_t * tyre**2)
    taken = trapezoid(fine[:, OF] * (fine[:, OVS] - fine[:, OVU]), dx=STEP)
    given = trapezoid(-k_t * tyre * np.gradient(road, STEP), dx=STEP)
    assert taken > 0.0
    assert stored[-1] - stored[0] + taken == pytest.approx(given, rel=2e-3)


@pytest.mark.parametrize("seed", [1, 2])
def test_end_stop_is_really_touched(seed: int) -> None:
    one, records = hidden_alone("end_stop", seed)
    beyond = np.concatenate([np.abs(record["deflection"]) > one.row[1] for record in records])
    assert 0.01 < beyond.mean() < 0.2
    assert np.count_nonzero(np.diff(beyond.astype(int)) == 1) >= 3


def test_integration_agrees_with_an_adaptive_solver() -> None:
    motions, base = short_motion(1, "damper")
    motion = motions[0]
    fine = plant.trajectory(motion, plant.NO_EFFECT, base)
    half = CubicSpline(np.arange(motion.drive.shape[0]) * STEP / 2, motion.drive[:, :2])
    k1, c1, fc, tau = base[3], base[4], base[2], base[5]

    def rate(t: float, force: Array, u: float) -> Array:
        x, v = half(t)
        return np.asarray((fc * u * np.tanh(k1 * x + c1 * v) - force) / tau)

    changes = np.flatnonzero(np.diff(motion.duty)) + 1
    state, start = np.zeros(1), 0
    for stop in changes[:6]:
        held = float(motion.duty[start])
        span = (start * SAMPLE, stop * SAMPLE)
        found = solve_ivp(
            rate, span, state, "DOP853", args=(held,), rtol=1e-9, atol=1e-9, max_step=2e-3
        )
        state, start = found.y[:, -1], int(stop)
        assert fine[stop * SUBSTEPS, OFER] == pytest.approx(state[0], abs=1e-5)
    assert start > 200


@pytest.mark.parametrize("name", [effect.name for effect in VEHICLE])
def test_forces_of_the_car_move_its_masses(name: str) -> None:
    """Newton on both masses, with the force that the effect adds written out again."""
    one, records = hidden_alone(name, 1)
    a, b = one.row[:2]
    m_s, m_u, k_s = plant.CAR[[MS, MU, KS]]
    for r in records:
        x, v = r["deflection"], r["deflection_velocity"]
        spring, load = k_s * x, m_s * r["sprung_acceleration"]
        if name == "guide_friction":
            spring = spring + a * 2.0 / np.pi * np.arctan(v / b)
        elif name == "spring_nonlinearity":
            spring = spring + k_s * (np.sinh(a * x) / a - x)
        elif name == "sprung_mass_error":
            load = load * (1.0 + a)
        elif name == "accelerometer_bias":
            load = load - m_s * a
        np.testing.assert_allclose(load, -spring - r["damper_force"], atol=1e-9)
        if name == "tyre_lift_off":
            pull = -load - m_u * r["unsprung_acceleration"]
            weight = (m_s + m_u) * 9.81 / a
            assert pull.max() < weight
            assert pull.min() < -weight
