"""What the sensors report, derived from the sensing effects of a model.

A sensing effect says how the true motion follows from the measured one: x = shift_deflection(x_m),
v = shift_velocity(v_m, v_m'). Where that is a straight line it can be turned round, and the plant
can simulate the sensor without a second equation.
"""

from __future__ import annotations

import inspect

import numpy as np

from er_models.effect import Effect
from er_models.errors import InputError
from er_models.model import Array, Model

_HOOKS = {"shift_deflection": ("x",), "shift_velocity": ("v", "a")}


def reading(model: Model) -> Array:
    """Gain and offset of the deflection, gain, lag [s] and offset of the velocity, shape (5,).

    x = gain x_m + offset, v = gain v_m + lag v_m' + offset. Raises `InputError` for a sensor that
    cannot be simulated: no straight line, a lag below zero, or a force that is measured before it
    acts.
    """
    gain_x, offset_x = _line(model, "shift_deflection")
    gain_v, lag, offset_v = _line(model, "shift_velocity")
    if lag < 0.0:
        raise InputError(
            model.name, "velocity_lag", "a lag of 0 s or more to simulate", f"{lag:g} s"
        )
    return np.array([gain_x, offset_x, gain_v, lag, offset_v])


def delay(model: Model) -> float:
    """Delay of the measured force [s]; `InputError` when it is negative."""
    total = 0.0
    for effect in model.catalogue.effects:
        if effect.name in model.effects and "output_delay" in effect.hooks:
            total += float(_call(model, effect, "output_delay", {}))
    if total < 0.0:
        raise InputError(
            model.name, "force_delay", "a delay of 0 s or more to simulate", f"{total:g} s"
        )
    return total


def _line(model: Model, hook: str) -> list[float]:
    """Coefficients of all sensors' maps of a signal, one after another, and their offset."""
    signals = _HOOKS[hook]
    slopes, offset = np.eye(len(signals))[0], 0.0
    for effect in model.catalogue.effects:
        if effect.name not in model.effects or not effect.maps_motion or hook not in effect.hooks:
            continue
        start = _map(model, effect, hook, np.zeros(len(signals)))
        found = [_map(model, effect, hook, unit) - start for unit in np.eye(len(signals))]
        probe = np.array([1.7, -2.3])[: len(signals)]
        straight = start + float(np.dot(found, probe))
        if abs(_map(model, effect, hook, probe) - straight) > 1e-9 * (1.0 + abs(straight)):
            raise InputError(
                model.name, effect.name, "a sensor with a straight line to simulate", "a curve"
            )
        slopes = np.array([found[0] * slopes[0], *(found[0] * slopes[1:] + found[1:])])
        offset = found[0] * offset + start
    return [*(float(c) for c in slopes), offset]


def _map(model: Model, effect: Effect, hook: str, values: Array) -> float:
    """Value of a map at signals."""
    return _call(model, effect, hook, dict(zip(_HOOKS[hook], values, strict=True)))


def _call(model: Model, effect: Effect, hook: str, signals: dict[str, float]) -> float:
    """Value of a hook; `InputError` when it needs more than the signals given."""
    known = {**model.effects[effect.name], **signals}
    names = inspect.signature(effect.hooks[hook]).parameters
    missing = [name for name in names if name not in known]
    if missing:
        raise InputError(
            model.name, effect.name, "a sensor that needs no other signal", ", ".join(missing)
        )
    return float(effect.hooks[hook](**{name: known[name] for name in names}))  # type: ignore[arg-type]
