"""The simulated rig: same as the whole-record simulation, and effects can be hidden in it."""

from pathlib import Path

import numpy as np
import pytest
from er_models.files import load_model
from er_models.model import Model
from er_models.simulation import simulate
from er_plant_sim.noise import Errors, Noise
from er_plant_sim.simulator import (
    Measurement,
    advance,
    at_rest,
    damper_replaced,
    measure,
    simulator,
)

ROOT = Path(__file__).parents[3]
DT = 0.005
NOISE = Noise(Errors(0.025, 0.025, 2e-5, 1e-3, 0.15), seed=1)


@pytest.fixture(scope="module")
def vehicle() -> Model:
    return load_model(ROOT / "config/vehicles/inove_quarter_car.yaml")


def run(model: Model, noise: Noise, n: int = 400) -> list[Measurement]:
    """n ticks on a sine road with alternating duty."""
    sim = simulator(model, DT, noise)
    road, duty = inputs(n)
    state, seen = at_rest(sim, road[0], duty[0]), []
    for k in range(n):
        state = advance(sim, state, road[k + 1], duty[k])
        seen.append(measure(sim, state))
    return seen


def inputs(n: int) -> tuple[list[float], list[float]]:
    """Road heights [m] and duties of n ticks."""
    t = DT * np.arange(n + 1)
    road = 0.004 * (1.0 - np.cos(2.0 * np.pi * 4.0 * t))
    return road.tolist(), np.where(t % 0.4 < 0.2, 0.05, 0.25).tolist()


def test_ticks_without_noise_are_the_whole_record_simulation(vehicle: Model) -> None:
    seen = run(vehicle, Noise())
    road, duty = inputs(400)
    whole = simulate(vehicle, DT, np.array(road), np.array(duty))
    for channel in (
        "deflection",
        "deflection_velocity",
        "sprung_acceleration",
        "unsprung_acceleration",
    ):
        stepped = np.array([getattr(m, channel) for m in seen])
        assert np.array_equal(stepped, whole[channel][1:]), channel
    assert np.array_equal([m.force for m in seen], whole["damper_force"][1:])
    assert np.array_equal([m.road for m in seen], road[1:])
    assert [m.tick for m in seen] == list(range(1, 401))


def test_same_seed_same_ticks(vehicle: Model) -> None:
    assert run(vehicle, NOISE, 100) == run(vehicle, NOISE, 100)


def test_noise_is_on_the_sensors_not_in_the_motion(vehicle: Model) -> None:
    clean = np.array(run(vehicle, Noise()))
    noisy = np.array(run(vehicle, NOISE))
    difference = (noisy - clean).std(axis=0)
    assert difference[1] == 0.0
    assert np.allclose(difference[2:], NOISE.deviation, rtol=0.15)


def test_measuring_needs_a_tick(vehicle: Model) -> None:
    sim = simulator(vehicle, DT, NOISE)
    with pytest.raises(ValueError, match="first tick is 1"):
        measure(sim, at_rest(sim, 0.0, 0.0))


def test_a_hidden_effect_changes_the_force_and_nothing_of_the_car(vehicle: Model) -> None:
    damper = load_model(ROOT / "config/dampers/inove_guo.yaml").with_effect("coulomb_friction")
    hidden = damper_replaced(vehicle, damper)
    assert hidden.effects["quarter_car"] == vehicle.effects["quarter_car"]
    assert set(hidden.effects) - set(vehicle.effects) == {"coulomb_friction"}
    difference = np.array(run(hidden, Noise())) - np.array(run(vehicle, Noise()))
    assert np.abs(difference[:, 6]).max() > 0.1


def test_the_replaced_damper_loses_what_it_had(vehicle: Model) -> None:
    bingham = load_model(ROOT / "config/dampers/inove_bingham.yaml")
    assert set(damper_replaced(vehicle, bingham).effects) == {
        "passive",
        "bingham_yield",
        "quarter_car",
    }
