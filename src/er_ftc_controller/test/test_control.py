"""The whole controller: modes, reasons, times, no bumps, and nothing but numbers whatever comes in."""

from __future__ import annotations

import math
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from er_ftc_controller.control import Command, Faults, Ftc, Mode, Rules, Sample, State
from er_ftc_controller.force_loop import ForceLoop
from er_ftc_controller.gains import load_gains
from er_models.errors import InputError
from er_models.files import load_model
from er_models.forms.loss import Factors
from er_models.static_damper import static_damper
from hypothesis import given, settings
from hypothesis import strategies as st

from er_ftc_controller import control, lpv

CONFIG = Path(__file__).resolve().parents[3] / "config"
DT = 0.005
SAFE = 0.1


@pytest.fixture(scope="module")
def p() -> Ftc:
    car = load_model(CONFIG / "vehicles" / "inove_quarter_car.yaml")
    damper, duties = static_damper(car), (0.0, 0.3)
    law = lpv.controller(load_gains(CONFIG / "gains" / "lpv_ftc.yaml", car), damper, duties, 1.0)
    loop = ForceLoop(damper, car.value("response", "tau"), duties)
    return Ftc(law, loop, Rules(SAFE, (0.05, 5.0)))


def motion(t: float) -> Sample:
    """A ride that keeps the controller busy."""
    w = 2.0 * math.pi * 4.0
    return Sample(0.003 * math.sin(w * t), 0.003 * w * math.cos(w * t))


def ride(
    p: Ftc, state: State, begin: float, seconds: float, *, silent: bool = False
) -> tuple[State, list[Command]]:
    """The state and all commands of some seconds, with samples or without."""
    said = []
    for k in range(round(seconds / DT)):
        t = begin + k * DT
        state, command = control.step(p, state, t, None if silent else motion(t))
        said.append(command)
    return state, said


def leak(t: float, f2: float = 0.6, **changed: object) -> Faults:
    """An estimate of a leak."""
    return Faults(t, 1.0, f2, 1.0, certain=True, usable=True)._replace(**changed)  # type: ignore[arg-type]


@pytest.mark.parametrize("wrong", [{"ahead": -0.001}, {"ahead": math.inf}, {"ahead": math.nan}])
def test_a_motion_is_not_led_back_or_on_without_end(wrong: dict[str, float]) -> None:
    with pytest.raises(InputError, match="ahead"):
        Rules(SAFE, (0.05, 5.0), **wrong)  # type: ignore[arg-type]


def test_it_is_safe_until_samples_come_and_then_controls(p: Ftc) -> None:
    state = control.start(p)
    assert state.command.mode is Mode.SAFE
    assert (state.command.duty, state.command.reason) == (SAFE, "no sample yet")
    state, silent = ride(p, state, 0.0, 0.1, silent=True)
    assert {(c.mode, c.duty) for c in silent} == {(Mode.SAFE, SAFE)}
    state, said = ride(p, state, 0.1, 1.0)
    assert {c.mode for c in said} == {Mode.NOMINAL}
    assert "no usable fault estimate" in said[-1].reason
    assert len({c.duty for c in said}) > 20


def test_the_safe_duty_is_there_50_ms_after_the_inputs_die_and_no_step_is_larger_than_the_ramp(
    p: Ftc,
) -> None:
    state, said = ride(p, control.start(p), 0.0, 1.003)
    begin = 1.005
    state, silent = ride(p, state, begin, 0.2, silent=True)
    duties = [said[-1].duty, *(c.duty for c in silent)]
    last = begin - DT
    safe_at = begin + DT * next(i for i, c in enumerate(silent) if c.duty == SAFE)
    assert safe_at - last <= 0.05 + 1e-9
    moved = [i for i in range(1, len(duties)) if duties[i] != duties[i - 1]]
    assert (moved[-1] - moved[0] + 1) * DT <= p.rules.ramp + DT + 1e-9
    assert silent[-1].mode is Mode.SAFE
    assert "no usable sample" in silent[-1].reason
    steepest = abs(duties[0] - SAFE) * DT / p.rules.ramp
    assert np.abs(np.diff(duties)).max() <= steepest + 1e-9


def test_it_recovers_within_its_time_without_a_bump(p: Ftc) -> None:
    state, _ = ride(p, control.start(p), 0.0, 0.5)
    state, _ = ride(p, state, 0.5, 0.5, silent=True)
    state, said = ride(p, state, 1.0, 0.5)
    duties = np.array([SAFE, *(c.duty for c in said)])
    shares = np.minimum(DT * np.arange(1, duties.size) / p.rules.recovery, 1.0)
    reach = max(SAFE, p.loop.duties[1] - SAFE)
    assert (np.abs(duties[1:] - SAFE) <= reach * shares + 1e-9).all()
    assert said[0].mode is Mode.NOMINAL
    assert state.share == 1.0


def test_a_certain_loss_adapts_the_domain_with_its_factors_faded(p: Ftc) -> None:
    state, _ = ride(p, control.start(p), 0.0, 0.5)
    state = control.hear(p, state, leak(0.495))
    state, said = ride(p, state, 0.5, 0.3)
    assert said[0].mode is Mode.FAULT_TOLERANT
    leaks = np.array([1.0, *(c.left[1] for c in said)])
    assert leaks[-1] == pytest.approx(0.6)
    assert np.abs(np.diff(leaks)).max() <= p.rules.fade * DT + 1e-12
    well = leak(0.8, 1.0, certain=False)
    state = control.hear(p, state, well)
    state, said = ride(p, state, 0.8, 0.3)
    assert said[-1].mode is Mode.NOMINAL
    assert said[-1].left == control.HEALTHY


def test_what_is_not_certain_or_not_usable_or_old_changes_nothing_and_is_said(p: Ftc) -> None:
    state, _ = ride(p, control.start(p), 0.0, 0.1)
    for faults in (leak(0.1, certain=False), leak(0.1, math.nan), leak(0.1, 1.4)):
        after, said = ride(p, control.hear(p, state, faults), 0.1, 0.1)
        assert said[-1].left == control.HEALTHY
    held, _ = ride(p, control.hear(p, state, leak(0.1)), 0.1, 0.4)
    after, said = ride(p, control.hear(p, held, leak(0.5, usable=False)), 0.5, 0.05)
    assert "may not be used" in said[-1].reason
    after, said = ride(p, after, 0.55, 0.3)
    assert "old" in said[-1].reason
    assert said[-1].left[1] == pytest.approx(0.6)
    assert said[-1].mode is Mode.FAULT_TOLERANT


def test_the_nominal_law_never_adapts(p: Ftc) -> None:
    nominal = replace(p, rules=replace(p.rules, adapt=False))
    state = control.hear(nominal, control.start(nominal), leak(0.0))
    _, said = ride(nominal, state, 0.0, 0.3)
    assert {(c.mode, c.left) for c in said} == {(Mode.NOMINAL, control.HEALTHY)}


def test_nothing_left_to_control_is_safe(p: Ftc) -> None:
    state = control.hear(p, control.start(p), leak(0.0, 0.0))
    _, said = ride(p, state, 0.0, 1.0)
    assert said[-1].mode is Mode.SAFE
    assert "no force" in said[-1].reason
    assert said[-1].duty == SAFE


def test_time_that_jumps_starts_afresh_and_time_that_lags_changes_nothing(p: Ftc) -> None:
    state, said = ride(p, control.start(p), 100.0, 1.0)
    assert control.step(p, state, 100.99, motion(0.0))[0] is state
    for t in (50.0, 500.0):
        after, command = control.step(p, state, t, motion(t))
        assert command.duty == pytest.approx(SAFE)
        assert after.share == 0.0
        fresh, _ = lpv.step(p.law, lpv.start(p.law), motion(t)[0], motion(t)[:2], Factors())
        assert np.array_equal(after.control.x, fresh.x)
        _, said = ride(p, after, t + DT, 0.3)
        assert said[-1].mode is Mode.NOMINAL


ANY = st.floats(allow_nan=True, allow_infinity=True)


@settings(max_examples=150, deadline=None)
@given(st.lists(st.tuples(ANY, st.tuples(ANY, ANY, ANY, ANY, ANY), st.booleans()), max_size=12))
def test_nothing_that_comes_in_makes_it_raise_or_say_no_number(
    p: Ftc, told: list[tuple[float, tuple[float, ...], bool]]
) -> None:
    whole = replace(p, body=(2.27, 1396.0))
    state = control.start(whole)
    t = 0.0
    for anything, values, on_time in told:
        t = t + DT if on_time else anything
        state = control.hear(whole, state, Faults(*values[:4], certain=True, usable=True))
        state, command = control.step(whole, state, t, Sample(*values))
        state, command = control.step(whole, state, t + DT, motion(DT) if on_time else None)
        assert 0.0 <= command.duty <= 0.3
        assert all(math.isfinite(v) for v in (command.wanted, command.given, command.rho))
        assert math.isfinite(state.loop.force)
        if not math.isfinite(t):
            t = 0.0
