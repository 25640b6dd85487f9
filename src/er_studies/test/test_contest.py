"""Ours and its peers: the compiled loop, every peer by hand, roads of their own, and what the tables claim."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from er_models.constants import SAMPLE_TIME as DT
from er_models.model import Model
from er_models.simulation import simulate
from er_studies.control import contest
from er_studies.control.contest import FAULTS, SCORED, TUNED, Line, dominated_by
from er_studies.control.contest_command import _built
from er_studies.control.form_ride import Ridden, measured, ride_peer
from er_studies.control.peers import PEERS
from er_studies.control.peers.rule import duty
from er_studies.control.peers.sample import A_S, AHEAD, FULL, GATE, V_S, V, X
from er_studies.control.run import Setup, setup

CONFIG = Path(__file__).resolve().parents[3] / "config"


@pytest.fixture(scope="module")
def of() -> Setup:
    return setup(CONFIG)


@pytest.fixture(scope="module")
def car(of: Setup) -> Model:
    return of.model


def test_the_compiled_loop_is_the_car_of_the_integrator(car: Model) -> None:
    road = contest.bump(car, TUNED)
    found = ride_peer(Ridden(car), road.heights, 0, np.array([0.2]), 0)
    true = simulate(car, DT, road.heights, np.full(len(found), 0.2))
    for column, name in enumerate(
        ("deflection", "sprung_acceleration", "tyre_deflection", "damper_force")
    ):
        assert np.abs(found[:, column] - true[name]).max() < 5e-3 * np.ptp(true[name])


@pytest.mark.parametrize(
    ("name", "p", "seen", "expected"),
    [
        ("constant", (0.1,), {}, 0.1),
        ("skyhook", (0.2,), {V_S: 0.1, V: 0.05}, 0.2),
        ("skyhook", (0.2,), {V_S: 0.1, V: -0.05}, 0.0),
        ("linear_skyhook", (20.0,), {V_S: 0.1, GATE: 1.0}, 0.1),
        ("linear_skyhook", (20.0,), {V_S: 0.1, GATE: -1.0}, 0.0),
        ("sh_add", (0.2, 1.0), {V_S: 1.0, A_S: -1.0, V: 0.1}, 0.2),
        ("sh_add", (0.2, 1.0), {V_S: 0.1, A_S: -1.0, V: 0.1}, 0.0),
        ("pdd", (0.5, 1000.0, 50.0), {X: 0.001, V: 0.1, GATE: 1.0}, 0.5),
        ("pdd", (0.5, 1000.0, 50.0), {X: -0.01, V: 0.1, GATE: 1.0}, 0.25),
        ("pdd", (0.5, 1000.0, 50.0), {X: -0.1, V: 0.1, GATE: 1.0}, 0.0),
        ("clipped_lqr", (-100.0, 0.0, 0.0, 0.0, 0.0), {X: 0.02, GATE: 0.1}, 0.25),
    ],
)
def test_every_peer_by_hand(
    name: str, p: tuple[float, ...], seen: dict[int, float], expected: float
) -> None:
    s = np.zeros(10 + AHEAD)
    s[FULL] = 20.0
    for place, value in seen.items():
        s[place] = value
    assert duty(PEERS[name].number, np.array(p), s, 1.0) == pytest.approx(expected)


def test_preview_pays_for_the_predictive_controller(car: Model) -> None:
    knobs = {"deflection": 1e6, "tyre": 3e7}
    roads = [contest.iso(car, TUNED + k) for k in range(2)]
    riders = (contest.peer(car, name, knobs) for name in ("mpc", "mpc_preview"))
    blind, sees = (contest.scores(Ridden(car), roads, r).mean(axis=0) for r in riders)
    assert sees[0] < blind[0]
    assert sees[2] < 0.97 * blind[2]


def test_roads_for_tuning_are_not_those_that_are_scored(car: Model) -> None:
    one, other = contest.bump(car, TUNED), contest.bump(car, SCORED)
    assert not np.array_equal(one.heights, other.heights)
    assert contest.tuned(car, "constant", "bumps", 2) == contest.tuned(car, "constant", "bumps", 2)


def test_one_is_dominated_where_another_is_better_in_all_three() -> None:
    lines = [Line("ISO", "healthy", n, np.array(c)) for n, c in
             (("a", (-0.1, 0.0, 0.0, 0.5)), ("b", (-0.2, -0.1, -0.1, 0.9)), ("c", (-0.3, 0.1, 0.0, 0.0)))]  # fmt: skip
    assert [dominated_by(lines, line) for line in lines] == [["b"], [], []]


def test_ours_is_no_worse_than_passive_on_tones_and_far_better_on_bumps(
    of: Setup, car: Model
) -> None:
    ours = contest.ours(_built(of))
    roads = [contest.tone(car, hertz) for hertz in (1.0, 2.0, 4.0, 6.0, 8.0, 12.0)]
    bare = contest.scores(Ridden(car), roads, contest.passive)
    change = contest.scores(Ridden(car), roads, ours) / bare - 1.0
    assert change[:, :3].max() < 0.01
    assert (change[2, :3] < -0.2).all()
    bumps, leak = [contest.bump(car, SCORED + k) for k in range(4)], Ridden(car, FAULTS["leakage"])
    gain = contest.scores(leak, bumps, ours) / contest.scores(leak, bumps, contest.passive) - 1.0
    assert gain.mean(axis=0)[0] < -0.2
    assert (gain.mean(axis=0)[1:3] < -0.06).all()


@pytest.mark.parametrize("mass", [0.9, 1.3])
def test_another_load_leaves_it_stable_and_better_than_a_constant_duty(
    of: Setup, car: Model, mass: float
) -> None:
    heavy = replace(
        car,
        effects={**car.effects, "quarter_car": {**car.effects["quarter_car"], "m_s": mass * 2.27}},
    )
    rig = Ridden(heavy, FAULTS["leakage"], 0.3, 1)
    road, p = contest.iso(car, TUNED + 1), np.array([0.005])
    ours = measured(contest.ours(_built(of))(rig, road), heavy, road.begin)
    bare = measured(
        ride_peer(rig, road.heights, PEERS["constant"].number, p, road.seed), heavy, road.begin
    )
    assert math.isfinite(ours.sum())
    assert (ours[:3] < 1.01 * bare[:3]).all()
