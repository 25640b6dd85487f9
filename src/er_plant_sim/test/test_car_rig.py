"""The rig of a whole car: four gates, four noises, one body."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from er_models.errors import InputError
from er_plant_sim.car_settings import CarParameters
from er_plant_sim.duty_gate import Command, Reason

from er_plant_sim import car_rig

CONFIG = Path(__file__).resolve().parents[3] / "config"


def parameters(**given: Any) -> CarParameters:
    files = {
        "car_file": str(CONFIG / "cars/inove_car.yaml"),
        "program_file": str(CONFIG / "experiments/iso_steps.yaml"),
    }
    return CarParameters(**{**files, "safe_duty": 0.1, **given})


def driven(p: CarParameters, ticks: int, **load: float) -> list[car_rig.CarState]:
    rig = car_rig.build(p)
    states = [car_rig.start(rig)]
    for _ in range(ticks):
        state, _ = car_rig.decide(rig, states[-1])
        states.append(car_rig.advance(rig, state, **load))
    return states


def test_the_rear_wheels_meet_the_road_later() -> None:
    """At 10.4 m/s the wheelbase of 0.52 m takes 0.05 s: ten ticks."""
    states = driven(parameters(speed=10.4, duty_source="program"), 60)
    road = np.array([[c.road for c in s.corners] for s in states])
    assert np.allclose(road[10:, 2:], road[:-10, :2], atol=1e-9)
    assert np.ptp(road[:, 0]) > 0


def test_tracks_share_what_is_asked() -> None:
    def heights(coherence: float) -> np.ndarray[Any, Any]:
        states = driven(parameters(coherence=coherence, duty_source="program"), 200)
        return np.array([[c.road for c in s.corners[:2]] for s in states])

    same, apart = heights(1.0), heights(0.0)
    assert np.array_equal(same[:, 0], same[:, 1])
    assert np.array_equal(same[:, 0], apart[:, 0])
    assert not np.allclose(apart[:, 0], apart[:, 1])


def test_each_corner_has_its_own_duty_and_noise() -> None:
    rig = car_rig.build(parameters(noise_force=0.5))
    state = car_rig.start(rig)
    state = car_rig.receive(rig, state, 2, Command(0.005, 1, 0.27, 1), valid=True)
    state, applied = car_rig.decide(rig, state)
    assert [a.reason for a in applied] == [Reason.NO_COMMAND] * 2 + [
        Reason.COMMAND,
        Reason.NO_COMMAND,
    ]
    assert [round(a.duty, 3) for a in applied] == [0.1, 0.1, 0.27, 0.1]
    forces = [m.force for m in car_rig.sense(rig, state)]
    assert len(set(forces)) == 4


def test_two_controllers_of_a_corner_end_in_its_safe_duty() -> None:
    rig = car_rig.build(parameters())
    state = car_rig.start(rig)
    for corner in range(4):
        state = car_rig.receive(rig, state, corner, Command(0.005, 1, 0.25, 1), valid=True)
    _, applied = car_rig.decide(rig, state, (False, True, False, False))
    assert [a.reason is Reason.CONFLICT for a in applied] == [False, True, False, False]


def test_it_dives_while_it_brakes() -> None:
    calm = driven(parameters(duty_source="program"), 100)
    braked = driven(parameters(duty_source="program"), 100, forward=-3.0)
    lower = [b.q[0] - c.q[0] for b, c in zip(braked[-1].corners, calm[-1].corners)]
    assert min(lower[2:]) > 0 > max(lower[:2])


def test_the_same_seed_is_the_same_run() -> None:
    p = parameters(seed=5)
    one, two = driven(p, 30)[-1], driven(p, 30)[-1]
    other = driven(replace(p, seed=6), 30)[-1]
    assert one.output.corners == two.output.corners
    assert one.output.corners != other.output.corners


@pytest.mark.parametrize(
    ("given", "key"),
    [
        ({"program_file": ""}, "program_file"),
        ({"rate_factor": 2.0}, "rate_factor"),
        ({"car_file": str(CONFIG / "vehicles/inove_quarter_car.yaml")}, "damper"),
        ({"safe_duty": 0.9}, "safe_duty"),
    ],
)
def test_what_cannot_run_is_refused(given: dict[str, Any], key: str) -> None:
    with pytest.raises(InputError, match=key):
        car_rig.build(parameters(**given))
