"""What is demanded of a user's own effect before it joins the catalogue.

Names and bounds as the catalogue's contract has them, hooks that can be compiled, finite values, and
parameters that switch the effect off where they say so.
"""

from __future__ import annotations

import math
import re
from collections.abc import Callable, Iterator, Mapping
from pathlib import Path
from types import FunctionType
from typing import Any

import numpy as np
from numba.core.errors import NumbaError
from numba.core.types import Number, Tuple, UniTuple, float64

from er_models.effect import SIGNALS, Effect, Param, arguments
from er_models.errors import InputError
from er_models.kernel.fast import njit
from er_models.kernel.hooks import with_compiled_names
from er_models.kernel.order import OF_STATE, signals_of
from er_models.scales import Scales

SCALES = Scales(force=20.0, deflection=0.010, velocity=0.15, duty=0.3)
"""The damper on which values are tried; bounds and starts are multiples of its scales."""
STAGES = ("force", "actuation", "heat", "sensing", "vehicle")
POINTS = 64
"""Random points at which every hook is tried, besides rest."""
_NAME = re.compile(r"[a-zA-Z]\w*")
_MAPPED = {
    "duty": "u", "shift_deflection": "x", "shift_velocity": "v", "flow_deflection": "x",
    "flow_velocity": "v", "limit": "f_d", "sense": "f_m",
    "tyre_limit": "f_t", "sprung_reading": "a_s", "unsprung_reading": "a_us",
}  # fmt: skip
"""Signal that a hook which maps leaves as it is where the effect does nothing."""
_SCALING = ("stiffness_scale", "viscous_scale", "yield_scale", "tau_scale")
BESIDE = {"bound": "relax", "give": "bound"}
"""Hooks that do nothing without another one."""
_POSITIVE = ("u", "u_f", "t", "k_0", "c_0", "tau_y", "m_s", "m_us", *_SCALING)
"""Signals that are never negative."""


def check(path: Path, effect: Effect, names: tuple[str, ...]) -> None:
    """Refuse an effect that cannot be used; names: of all effects there will be."""
    _check_words(path, effect, names)
    for q in effect.parameters:
        _check_parameter(path, effect, q)
    used = {name for hook in effect.hooks for name in arguments(effect.hooks[hook])}
    idle = [q.name for q in effect.parameters if q.name not in used]
    if idle:
        raise InputError(path, f"{effect.name}.{idle[0]}", "a parameter of some hook", "no use")
    for hook in effect.hooks:
        _check_signals(path, effect, hook)
        _check_values(path, effect, hook, _compiled(path, effect, hook))


def _check_words(path: Path, effect: Effect, names: tuple[str, ...]) -> None:
    """Name, stage, rivals, and a value at which it vanishes."""
    if not _NAME.fullmatch(effect.name):
        raise InputError(path, "name", "letters, digits and _", repr(effect.name))
    if effect.stage not in STAGES:
        raise InputError(
            path, f"{effect.name}.stage", f"one of {', '.join(STAGES)}", repr(effect.stage)
        )
    strange = [r for r in effect.signature.rivals if r not in names or r == effect.name]
    if strange:
        raise InputError(path, f"{effect.name}.rivals", "names of other effects", repr(strange[0]))
    if not effect.hooks:
        raise InputError(path, f"{effect.name}.hooks", "at least one", "none")
    if all(q.neutral is None for q in effect.parameters):
        expected = "a parameter with a neutral value, at which the effect vanishes"
        raise InputError(path, f"{effect.name}.parameters", expected, "none")


def _check_parameter(path: Path, effect: Effect, q: Param) -> None:
    """Name, unit, bounds, neutral value and starts of a parameter."""
    where = f"{effect.name}.{q.name}"
    if not _NAME.fullmatch(q.name) or q.name in SIGNALS or q.name == "w":
        raise InputError(path, where, "a name that no signal has", repr(q.name))
    try:
        SCALES.of(q.unit)
    except InputError as error:
        raise InputError(path, f"{where}.unit", error.expected, repr(q.unit)) from error
    if not q.low < q.high:
        raise InputError(path, where, "a lower bound below the upper", f"{q.low:g}, {q.high:g}")
    if not q.starts or not all(q.low <= start <= q.high for start in q.starts):
        raise InputError(path, f"{where}.starts", f"values in {q.low:g} to {q.high:g}", q.starts)
    if q.neutral is not None and not (q.low <= q.neutral <= q.high or q.neutral == math.inf):
        expected = f"{q.low:g} to {q.high:g}, inf or None"
        raise InputError(path, f"{where}.neutral", expected, q.neutral)


def _check_signals(path: Path, effect: Effect, hook: str) -> None:
    """A hook must be a plain function of what is known where it acts."""
    function, where = effect.hooks[hook], f"{effect.name}.{hook}"
    if not isinstance(function, FunctionType) or function.__closure__:
        raise InputError(path, where, "a plain function of the file", repr(function))
    known = (*effect.names, *signals_of(effect, hook))
    for name in arguments(effect.hooks[hook]):
        if name not in known:
            raise InputError(path, where, f"arguments among {', '.join(known)}", f"'{name}'")
    needed = BESIDE.get(hook, hook)
    if needed not in effect.hooks:
        raise InputError(path, where, f"a hook {needed} beside it", "none")


def _compiled(path: Path, effect: Effect, hook: str) -> Callable[..., Any]:
    """The hook compiled by itself; refuses what the compiler cannot read or what returns no number."""
    where, n = f"{effect.name}.{hook}", len(arguments(effect.hooks[hook]))
    function: Any = njit(error_model="numpy")(with_compiled_names(effect.hooks[hook]))
    try:
        function.compile((float64,) * n)
    except NumbaError as error:
        raise InputError(
            path, where, "a function that numba can compile", _reason(error)
        ) from error
    returned = function.nopython_signatures[0].return_type
    pair = isinstance(returned, UniTuple | Tuple) and len(returned) == 2
    if hook == "relax" and not pair:
        raise InputError(path, where, "a pair (rate, drive)", str(returned))
    if hook != "relax" and not isinstance(returned, Number):
        raise InputError(path, where, "one number", str(returned))
    compiled: Callable[..., Any] = function
    return compiled


def _reason(error: Exception) -> str:
    """What the compiler complains of, in one line."""
    lines = [line.strip() for line in str(error).splitlines()]
    told = [
        line for line in lines if line and not line.startswith(("Failed in", "During:", "File"))
    ]
    return told[0][:160] if told else type(error).__name__


def _check_values(path: Path, effect: Effect, hook: str, function: Callable[..., Any]) -> None:
    """Finite at the neutral values, and nothing where these alone decide."""
    where = f"{effect.name}.{hook}"
    for point in _points(effect):
        found = function(*(point[name] for name in arguments(effect.hooks[hook])))
        said = ", ".join(
            f"{k} = {point[k]:g}" for k in arguments(effect.hooks[hook]) if k in SIGNALS
        )
        if not np.isfinite(found).all() and hook != "bound":
            expected = f"a finite value at its neutral parameters{said and ' and ' + said}"
            raise InputError(path, where, expected, found)
        nothing = _nothing(hook, point)
        if effect.has_state or nothing is None or abs(found - nothing) <= 1e-9 * abs(nothing):
            continue
        expected = f"{nothing:g}, as without the effect, at its neutral parameters"
        raise InputError(path, where, expected + (said and f" and {said}"), f"{found:g}")


def _nothing(hook: str, point: Mapping[str, float]) -> float | None:
    """What a hook returns where its effect does nothing; None where that is no single value."""
    if hook in _MAPPED:
        return point[_MAPPED[hook]]
    if hook in _SCALING:
        return 1.0
    return None if hook in OF_STATE else 0.0


def _points(effect: Effect) -> Iterator[dict[str, float]]:
    """Neutral parameters with signals at rest, then at random within the envelope."""
    fixed = {
        q.name: (q.starts[0] if q.neutral is None else q.neutral) * SCALES.of(q.unit)
        for q in effect.parameters
    }
    random = np.random.default_rng(0)
    for i in range(POINTS + 1):
        point = {"w": 0.0}
        for name, signal in SIGNALS.items():
            share = random.uniform(0.01 if name in _POSITIVE else -1.0, 1.0)
            still = 1.0 if name in _SCALING or signal.unit == "kg" else 0.0
            point[name] = (share if i else still) * SCALES.of(signal.unit)
        point["w"] = random.uniform(-1.0, 1.0) if i else 0.0
        point["f_m"] = point["f_d"]
        yield point | fixed
