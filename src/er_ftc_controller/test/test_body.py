"""The body controller: its gain, its reading of the state, what it does to a car, and its core on messages."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
import yaml
from er_ftc_controller.body_gains import load_body_gain, load_weights, slowest
from er_ftc_controller.synthesis.body_lqr import body_gain
from er_models.car.body import Car
from er_models.car.files import load_car
from er_models.car.linear import linear_car
from er_models.car.simulation import car_at_rest, prepare_car, step_car
from er_models.errors import InputError

from er_ftc_controller import body

CONFIG = Path(__file__).resolve().parents[3] / "config"
DT, FINE = 0.005, 16


def the_car() -> Car:
    return load_car(CONFIG / "cars/inove_car.yaml")


def the_law() -> body.BodyLaw:
    car = the_car()
    gain, _ = load_body_gain(CONFIG / "gains/body_lqr.yaml", car)
    return body.law_of(car, gain, (0.0, 0.3), 0.02, 0.1)


def test_the_gain_is_that_of_its_weights_and_optimal() -> None:
    """Kleinman: the cost of a gain is a Lyapunov equation; no change of the gain makes it smaller."""
    car, weights = the_car(), load_weights(CONFIG / "weights/body_lqr.yaml")
    gain, _ = load_body_gain(CONFIG / "gains/body_lqr.yaml", car)
    assert np.allclose(gain, body_gain(car, weights), rtol=1e-6, atol=1e-6 * np.abs(gain).max())
    assert slowest(car, gain) < 0

    from scipy.linalg import solve_continuous_lyapunov

    form = linear_car(car)
    a = form.A - 0.5 * np.diag(np.repeat([0.0, 0.0, 1.0, 0.0], [4, 3, 4, 4]))
    size = np.array([weights.heave, weights.roll, weights.pitch])[:, None]

    def cost(k: Any) -> float:
        rows = np.vstack([
            (form.acceleration[0] - form.acceleration[1] @ k) / size, np.eye(15)[:4] / weights.deflection,
            np.eye(15)[7:11] / weights.tyre, k / weights.force,
        ])  # fmt: skip
        spread = solve_continuous_lyapunov(a - form.B @ k, -form.D @ form.D.T)
        return float(np.trace(rows @ spread @ rows.T))

    rng, best = np.random.default_rng(0), cost(gain)
    for _ in range(6):
        assert cost(gain * (1 + 0.05 * rng.standard_normal(gain.shape))) > best


def ride(law: body.BodyLaw | None, seconds: float, left: float = 0.0) -> dict[str, Any]:
    """The car on a twisted sine and in a turn; law None: no field."""
    plant, n = prepare_car(the_car(), DT), round(seconds / DT)
    t = np.arange(n * FINE + 1) * DT / FINE
    road = np.array(
        [
            0.002 * a * np.sin(2 * np.pi * 3.5 * t) * np.minimum(t, 1.0)
            for a in (1.0, -0.6, 0.8, -0.8)
        ]
    )
    states, duty, state = car_at_rest(plant, road[:, 0], np.zeros(4)), np.zeros(4), body.start()
    motions, duties, estimates = [], [], []
    for k in range(n):
        push = plant.car.push(np.zeros(1), np.array([left]))[0]
        states, out = step_car(
            plant, states, road[:, k * FINE + 1 : (k + 1) * FINE + 1], duty, push
        )
        values = [[getattr(c, name) for c in out.corners] for name in (
            "deflection", "deflection_velocity", "sprung_acceleration", "unsprung_acceleration"
        )]  # fmt: skip
        sample = body.BodySample((k + 1) * DT, *map(np.array, values))
        if law is not None:
            state, duty = body.step(law, state, sample)
            yielding = np.array([each.force for each in state.loops])
            estimates.append(body.read(law, sample, state.rates, yielding))
        true = np.array([s.q for s in states])
        motions.append(
            np.concatenate([true[:, 0], plant.car.motions @ true[:, 1], true[:, 2], true[:, 3]])
        )
        duties.append(duty)
    return {"state": np.array(motions), "read": np.array(estimates), "duty": np.array(duties)}


def test_it_reads_the_state_and_calms_the_body() -> None:
    free, held = ride(None, 3.0), ride(the_law(), 3.0)
    late = slice(200, None)
    error, size = (held["read"] - held["state"])[late], held["state"][late].std(axis=0)
    assert np.all(error[:, :4] == 0)
    assert (error[:, 4:].std(axis=0) < 0.25 * np.maximum(size[4:], size[4:].max() * 0.05)).all()
    roll = [ride_["state"][late][:, 5].std() for ride_ in (free, held)]
    assert roll[1] < 0.9 * roll[0]
    assert held["duty"].min() >= 0.0
    assert held["duty"].max() <= 0.3
    assert np.ptp(held["duty"]) > 0.2


def test_a_gap_starts_the_integrals_anew() -> None:
    law = the_law()
    sample = body.BodySample(1.0, *(np.full(4, v) for v in (1e-3, 0.01, 2.0, 3.0)))
    state, _ = body.step(law, body.start(), sample)
    state, _ = body.step(law, state, sample._replace(t=1.005))
    assert state.rates[0] > 0
    state, _ = body.step(law, state, sample._replace(t=1.5))
    assert not state.rates.any()


@pytest.mark.parametrize(
    ("change", "words"),
    [
        (lambda c: c | {"schema": "er_lpv_gains 1"}, "schema"),
        (lambda c: c | {"slowest_pole": -1.0}, "digest"),
    ],
)
def test_another_file_is_refused(change: Any, words: str, tmp_path: Path) -> None:
    content = yaml.safe_load((CONFIG / "gains/body_lqr.yaml").read_text(encoding="utf-8"))
    (tmp_path / "gain.yaml").write_text(yaml.safe_dump(change(content)), encoding="utf-8")
    with pytest.raises(InputError, match=words):
        load_body_gain(tmp_path / "gain.yaml", the_car())


def test_a_gain_of_another_car_is_refused() -> None:
    with pytest.raises(InputError, match=r"car\.fingerprint"):
        load_body_gain(CONFIG / "gains/body_lqr.yaml", replace(the_car(), mass=12.0))


def test_bad_weights_are_one_line(tmp_path: Path) -> None:
    (tmp_path / "w.yaml").write_text("heave: 0\nroll: 1\n", encoding="utf-8")
    with pytest.raises(InputError, match="heave"):
        load_weights(tmp_path / "w.yaml")


def test_the_core_answers_when_all_corners_are_there() -> None:
    pytest.importorskip("rclpy")
    from er_common.parameter_table import build
    from er_common.topics import PWM_COMMAND, below
    from er_ftc_controller.ros_body import BodyCore, BodyParameters
    from er_ros_common.builders import Tick, suspension_acceleration, suspension_deflection
    from er_ros_common.core import When

    files = {
        "car_file": str(CONFIG / "cars/inove_car.yaml"),
        "gains_file": str(CONFIG / "gains/body_lqr.yaml"),
    }
    core = BodyCore(
        build(BodyParameters, {**files, "u_max": 0.3, "safe_duty": 0.1, "max_age": 0.0}, {})
    )
    state, said = core.start(), []
    for k in range(1, 40):
        tick, when = Tick(k * 5_000_000, k), When(k * 5_000_000, None)
        for which, topic in enumerate(core.inputs):
            assert said == [] or which == 0
            a, b = np.sin(0.1 * k + which), np.cos(0.2 * k + which)
            make = suspension_acceleration if which < 4 else suspension_deflection
            scale = 1.0 if which < 4 else 1e-3
            state, said = core.on_message(state, topic, make(tick, scale * a, scale * b), when)
        assert [topic for topic, _ in said] == [
            below(PWM_COMMAND, c) for c in ("front_left", "front_right", "rear_left", "rear_right")
        ]
        assert all(m.seq == k and 0.0 <= m.duty <= 0.3 for _, m in said)
        said = []
    for topic in core.inputs[1:]:  # one corner stays away: no answer, then the safe duty
        make = suspension_acceleration if "acceleration" in topic.name else suspension_deflection
        state, said = core.on_message(
            state, topic, make(Tick(200_000_000, 40), 0.1, 0.1), When(200_000_000, None)
        )
        assert said == []
    state, said = core.on_time(state, When(20_000_000_000, None))
    assert [round(m.duty, 3) for _, m in said] == [0.1] * 4
    assert core.report(state).mode == "safe"
