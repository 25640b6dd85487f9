"""A running observer goes over to other gains: the estimate of the motion stays, whatever the order of the gains."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable
from dataclasses import replace
from pathlib import Path
from time import sleep

import numpy as np
import pytest
from er_models.errors import ErError, InputError
from er_models.files import load_model, save_model
from er_models.model import Model
from er_models.nearest import nearest
from er_observers.forms import form_of
from er_observers.gains import Gains
from er_observers.making import Making, beside
from er_observers.ros_observer import ObserverCore
from er_observers.running.ready import ready
from er_observers.running.runtime import Sample, gone_over, start, step
from er_observers.settings import ObserverParameters

FRICTION = {"F_c": 1.0, "v_0": 3e-3}


def with_c0(car: Model, scale: float) -> Model:
    values = {**car.effects["passive"], "c0": scale * car.value("passive", "c0")}
    return car.with_effect("passive", values)


def test_what_a_form_cannot_hold_is_left_out_and_named(car: Model) -> None:
    more = car.with_effect("coulomb_friction", FRICTION).with_effect("fluid_inertia")
    kept, left_out = nearest(more, form_of)
    assert left_out == ("coulomb_friction",)
    assert kept.effects == car.with_effect("fluid_inertia").effects
    assert nearest(car, form_of) == (car, ())
    with pytest.raises(ErError, match="quarter_car"):
        nearest(more.without_effect("quarter_car"), form_of)


def test_the_estimate_stays_where_the_gains_change(
    gains: Gains, car: Model, car_file: Path, drive: Callable[..., list[Sample]]
) -> None:
    """Of another order, for the same car: nothing moves but what the other gains make of the same motion."""
    other = ready(car_file.parents[1] / "gains/unified.yaml", car, "unified")
    samples = drive(800, 0.2)
    state = start(gains, samples[0])
    for sample in samples[1:600]:
        state, _ = step(gains, state, sample)
    over = gone_over(other, state)
    assert np.array_equal(over.x, state.x)
    assert (over.t, over.duty, over.P is None) == (state.t, state.duty, True)
    assert over.memory.size == other.layout.size != gains.layout.size
    _, stayed = step(gains, state, samples[600])
    over, went = step(other, over, samples[600])
    assert went.force == pytest.approx(stayed.force, abs=0.3)
    assert went.status is stayed.status
    # where it began afresh the start phase would have to find the motion again
    _, fresh = step(other, start(other, samples[599]), samples[600])
    assert abs(fresh.force - stayed.force) > 1.0


def test_gains_for_other_sensors_are_refused(
    gains: Gains, car_file: Path, gain_file: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    p = ObserverParameters(model_file=str(car_file), gains_file=str(gain_file))
    core, other = ObserverCore("nlpv_polytopic", p), replace(gains)
    object.__setattr__(other, "sees_deflection", True)
    monkeypatch.setattr("er_observers.ros_observer.ready", lambda *_: other)
    with pytest.raises(InputError, match="expected gains for the same sensors"):
        core.tuned(replace(p, gains_file="others.yaml"))
    assert core.tuned(replace(p, timeout=0.1)).gains is core.gains


def test_gains_that_nobody_waits_for_any_more_are_not_made(tmp_path: Path) -> None:
    file = str(tmp_path / "none.yaml")
    making = Making("unified", file, beside(file, "unified"), leave_out=True)
    making.stop()
    assert "ended with status" in making.failed


@pytest.mark.slow
def test_gains_for_another_model_bring_what_that_model_brings(
    gains: Gains, car: Model, tmp_path: Path
) -> None:
    """A damper that rubs, and is thicker than the model: the observer takes the thicker one."""
    none = str(tmp_path / "none.yaml")
    making = Making("unified", none, beside(none, "unified"), leave_out=True)
    while not making.look():
        sleep(0.05)
    assert "none.yaml" in making.failed
    file = tmp_path / "learnt.yaml"
    save_model(with_c0(car, 1.15).with_effect("coulomb_friction", FRICTION), file)
    out = beside(str(file), "nlpv_polytopic")
    making = Making("nlpv_polytopic", str(file), out, leave_out=True)
    while not making.look():
        sleep(0.05)
    assert not making.failed
    assert Path(out) == tmp_path / "learnt_nlpv_polytopic.yaml"
    kept, _ = nearest(load_model(file), form_of)
    other = ready(out, kept, "nlpv_polytopic")
    assert other.model == car.name
    assert other.form.F[1] == pytest.approx(1.15 * gains.form.F[1])
    lone = subprocess.run(
        [sys.executable, "-m", "er_observers.making", "unified", str(file), out],
        input=b"", capture_output=True, check=False,
    )  # fmt: skip
    assert lone.returncode, "without an owner it ends"
