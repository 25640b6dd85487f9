"""Every law of the true dampers, worked by hand."""

import numpy as np
import pytest

from test.rough import device as d
from test.rough.device import BASE, run
from test.rough.truths import table

pytestmark = pytest.mark.slow

H = 1e-4


def base(**values):
    return np.array([{"u_m": 1.0, "beta": 1.0, "v_0": 1.0, **values}.get(n, 0.0) for n in BASE])


def force(v, u=0.0, *, x=0.0, rows=None, lead=0, n=None, **values):
    """Force along a motion at velocity v(t), or a constant one; x where it begins."""
    t = np.arange(n or 10001) * H
    speed = np.full(t.size, float(v)) if np.isscalar(v) else v
    way = x + np.concatenate([[0.0], np.cumsum(0.5 * (speed[1:] + speed[:-1]) * H)])
    duty = np.full(t.size, float(u)) if np.isscalar(u) else u
    return run(way, speed, np.gradient(speed, H), duty, H, lead, base(**values), table(rows or {}))


STATIC = {
    # row, deflection, velocity, force
    "coulomb": (d.COULOMB, (10.0, 4.0), 0.0, 3.0, 6.0),  # 10 * 3 / 5
    "stribeck": (d.STRIBECK, (8.0, 0.1, 1e-9, 0.5), 0.0, 0.1, 8.0),  # 8 (1/2 + 1/2)
    "direction": (d.DIRECTION, (10.0, 0.4, 1e-9), 0.0, -0.2, -6.0),  # 10 (1 - 0.4)
    "orifice": (d.ORIFICE, (2.0, 4.0), 0.0, 3.0, 30.0),  # 2 * 3 * 5
    "check": (d.CHECK, (2.0, 3.0), 0.0, -4.0, 4.0),  # 2 (5 - 3)
    "taper": (d.TAPER, (6.0, 0.1), 0.1, 2.0, 12.0),  # full at the end of the stroke
    "stop": (d.STOP, (100.0, 0.02, 0.01), -0.03, 0.0, -2.0),  # 100 * 0.01 * (1 + 1)
    "gas": (d.GAS, (8.0, 0.1, 1.0), 0.1, 0.0, -4.0),  # 8 (1 - 1 - 1/2)
    "offset": (d.OFFSET, (-3.0,), 0.0, 0.5, -3.0),
    "cogging": (d.COGGING, (5.0, 0.04), 0.01, 0.0, 5.0),  # a quarter of the pitch
}


@pytest.mark.parametrize("name", STATIC)
def test_a_law_without_memory(name):
    law, row, x, v, expected = STATIC[name]
    assert force(v, x=x, rows={law: row}, n=2)[0] == pytest.approx(expected, abs=1e-6)


def test_friction_that_grows_with_the_load_of_the_spring():
    # 0.2 * |1000 N/m * -0.01 m| beside the spring itself
    found = force(1.0, x=-0.01, rows={d.LOADED: (0.2, 1e-9)}, n=2, k0=1000.0)[0]
    assert found == pytest.approx(-10.0 + 2.0)


def test_the_base_of_every_device():
    assert force(0.2, x=0.01, n=2, k0=300.0, c0=50.0)[0] == pytest.approx(13.0)
    assert force(1e-3, n=2, F_c=10.0, v_0=1e-3)[0] == pytest.approx(10.0 * np.tanh(1.0))
    # 20 N/duty, a quarter of a largest duty of 1/2 with the power 2: 20 * 1/2 * 1/16
    held = force(1.0, 0.125, n=2, f_c=20.0, c1=1e3, tau=0.01, beta=2.0, u_m=0.5)[0]
    assert held == pytest.approx(0.625)


def test_a_valve_opens_at_its_force_and_bends_to_its_slope():
    # bleed 100 N s/m; opens at 20 N and then passes as much again: 30 N s/m would be 30 N, now (0.3 + 0.2) / 0.02
    assert d.valve(0.1, 100.0, 20.0, 1.0, 1e-9) == pytest.approx(10.0)
    assert d.valve(0.3, 100.0, 20.0, 1.0, 1e-9) == pytest.approx(25.0)
    row = {d.KNEE: (1.0, 20.0, 10.0, 1e-9, 2.0)}
    assert force(0.3, rows=row, n=2, c0=100.0)[0] == pytest.approx(25.0)
    # in compression at 10 N to a third of the slope: 10 + (30 - 10) / 3
    assert force(-0.3, rows=row, n=2, c0=100.0)[0] == pytest.approx(-50.0 / 3.0)


def test_a_thinning_fluid_has_lost_half_of_its_share_at_its_velocity():
    assert force(0.2, rows={d.THIN: (0.6, 0.2, 1.5)}, n=2, c0=10.0)[0] == pytest.approx(1.4)


def test_friction_bends_over_its_path():
    assert d.bent(0.0, 1e-3 * np.log(2.0), 1e-3) == pytest.approx(0.5e-3)
    rows = {d.DAHL: (10.0, 1e-3, 0.0, -0.5)}
    out = force(0.01, rows=rows)
    assert out[0] == pytest.approx(-5.0)  # where it rests
    assert out[10000] == pytest.approx(10.0 * (1.0 - 1.5 * np.exp(-10.0)))  # after 10 mm
    more = force(0.01, 0.5, rows={d.DAHL: (10.0, 1e-3, 2.0, 0.0)})[10000]
    assert more == pytest.approx(20.0, rel=1e-3)  # its level grows with the field


def test_a_branch_relaxes():
    # 500 N/m for 0.1 s at 0.2 m/s: 10 (1 - exp(-2)) after 0.2 s; with half of it in the second, four times as slow
    assert force(0.2, rows={d.MAXWELL: (500.0, 0.1, 0.0)})[2000] == pytest.approx(
        10.0 * (1.0 - np.exp(-2.0))
    )
    half = force(0.2, rows={d.MAXWELL: (500.0, 0.1, 0.5)})[2000]
    assert half == pytest.approx(5.0 * (1.0 - np.exp(-2.0)) + 20.0 * (1.0 - np.exp(-0.5)))


def test_a_mount_gives_way_and_hardens():
    # 100 N s/m behind 1e-3 m/N relax in 0.1 s
    soft = force(0.2, rows={d.MOUNT: (1e-3, 1e9)}, c0=100.0)
    assert soft[1000] == pytest.approx(20.0 * (1.0 - np.exp(-1.0)), rel=1e-3)
    assert d.joint(0.02, table({d.MOUNT: (1e-3, 0.02)})) == pytest.approx(40.0)  # 20 (1 + 1)


def test_play_must_be_crossed():
    out = force(0.1, rows={d.PLAY: (0.02, 1e5)}, c0=50.0)
    assert np.abs(out[:1990]).max() < 1e-3  # 20 mm at 0.1 m/s
    assert out[4000] == pytest.approx(5.0, rel=1e-3)


def test_mass_and_void():
    t = np.arange(10001) * H
    assert force(2.0 * t, rows={d.INERTIA: (3.0,)})[5000] == pytest.approx(6.0)
    # fluid of 20 N at most 12 N; when the stroke comes back the void must close first
    v = np.where(t < 0.5, 0.2, -0.2)
    out = force(v, rows={d.VOID: (0.4, 20.0, 1e-5)}, c0=100.0)
    assert out[4000] == pytest.approx(12.0, rel=1e-3)
    assert out[5500] == pytest.approx(
        12.0, rel=1e-2
    )  # 40 mm opened at 0.08 m/s, closing at 0.32 m/s
    assert out[7000] == pytest.approx(-20.0, rel=1e-3)


YIELDS = {"f_c": 20.0, "c1": 1e3, "tau": 0.05}


def test_the_yield_force_follows_a_step_of_the_duty():
    u = np.where(np.arange(10001) * H < 0.1, 0.0, 0.5)
    plain = force(1.0, u, **YIELDS)
    assert plain[1500] == pytest.approx(10.0 * (1.0 - np.exp(-1.0)), rel=1e-3)
    late = force(1.0, u, rows={d.LATE: (0.02,)}, **YIELDS)
    np.testing.assert_allclose(late[1000:], plain[800:-200], atol=1e-9)
    slow = force(1.0, u, rows={d.SLOWING: (np.log(2.0), 0.5)}, **YIELDS)
    assert slow[2000] == pytest.approx(10.0 * (1.0 - np.exp(-1.0)), rel=1e-3)
    lagged = force(1.0, u, rows={d.AMPLIFIER: (0.01,)}, f_c=20.0, c1=1e3, tau=1e-6)
    assert lagged[1000 + 120] == pytest.approx(  # two poles of 10 and 2 ms
        10.0 * (1.0 - (10.0 * np.exp(-1.2) - 2.0 * np.exp(-6.0)) / 8.0), rel=0.01
    )


def test_a_fall_may_be_slower_than_a_rise():
    u = np.where(np.arange(10001) * H < 0.5, 0.5, 0.0)
    out = force(1.0, u, rows={d.SWITCHING: (np.log(2.0),)}, **YIELDS)
    assert out[6000] == pytest.approx(10.0 * np.exp(-1.0), rel=1e-3)


@pytest.mark.parametrize(
    ("law", "row", "u", "field"),
    [
        (d.THRESHOLD, (0.1, 1e-9), 0.4, 0.3),
        (d.MIXED, (0.5, 1.0), 0.4, 0.28),  # half of it, and half of its square
        (d.SATURATE, (2.0, 1.0), 0.5, 0.5 * (1.0 - np.exp(-1.0))),
    ],
)
def test_what_a_duty_makes_of_the_field(law, row, u, field):
    assert d.field(u, u, table({law: row}))[0] == pytest.approx(field)


def test_a_magnet_remembers():
    laws = table({d.REMANENT: (0.5, 0.3)})
    up, held = d.field(1.0, 0.0, laws)
    assert (up, held) == (pytest.approx(0.85), pytest.approx(0.7))
    assert d.field(0.0, held, laws) == (pytest.approx(0.15), pytest.approx(0.3))


def test_what_follows_the_chains_at_once():
    for row, x, v, expected in (
        ({d.PRESSED: (40.0,)}, 0.0, 0.0, 20.0),
        ({d.THICKEN: (6.0, 0.5)}, 0.0, 2.0, 4.5),  # 6 * 0.5 / (1 + 1/3) * 2
        ({d.STIFFEN: (200.0, 1.0)}, 1e-3, 0.0, 0.1),
    ):
        assert force(v, 0.5, x=x, rows=row, n=2, tau=0.01)[0] == pytest.approx(expected, rel=1e-6)


def test_heat_and_age_count_from_the_record():
    lead = 2000
    worn = force(1.0, rows={d.WEAR: (0.4, 0.5)}, lead=lead, c0=10.0)
    assert worn[lead] == 10.0
    assert worn[lead + 5000] == pytest.approx(8.0)  # half of the loss
    faded = force(1.0, 0.5, rows={d.FADE: (0.4, 0.5)}, lead=lead, **(YIELDS | {"tau": 1e-6}))
    assert faded[lead + 5000] == pytest.approx(8.0, rel=1e-3)
    hot = force(1.0, rows={d.HEAT: (1.0, 0.05, 5.0)}, lead=lead, c0=10.0)
    assert hot[lead] == 10.0
    # in the end F = 10 / (1 + F / 5): F^2 / 5 + F - 10 = 0
    assert hot[-1] == pytest.approx(2.5 * (np.sqrt(9.0) - 1.0), rel=1e-3)
