"""Writes the source of one kernel module for a whole catalogue.

Effects a model does not use are switched off by a mask, so one compilation serves every model and
every combination the lab tries.
"""

from __future__ import annotations

import hashlib
import inspect
import re
from collections.abc import Callable, Mapping
from functools import lru_cache
from importlib import import_module
from pathlib import Path
from types import CodeType, ModuleType
from typing import Any

import numpy as np

from er_models.catalogue import Catalogue
from er_models.effect import INSTANT, Effect, arguments
from er_models.kernel.inline import inlined
from er_models.kernel.layout import CAUGHT, HEAT, SLIDES, ZERO
from er_models.kernel.mask import FIELD, LAG, TERMS, TURN, of_hook, of_run, stands_alone
from er_models.kernel.order import relaxes_at

OF_FIELD = {"y": "u", "f_y": "u_f", "tau_scale": "u_f_scale"}
"""What the equations of the response see where the duty whose chains have formed follows the duty."""
PARTS = (
    "rows", "search", "states", "inputs", "imposed", "beginning", "following", "sensors", "vehicle", "car",
)  # fmt: skip
_OURS = re.compile(r"^from (er_models\.\S+) import", re.MULTILINE)
_MARK = "# --- below this line: compiled with the composed equations ---\n"


def _call(
    catalogue: Catalogue, effect: Effect, hook: str, pattern: str, signals: Mapping[str, str] = {}
) -> list[str]:
    """Source of a hook in its place, with its arguments taken from the flat vectors; pattern holds {call}.

    signals: what stands for a signal here, where that is not the signal itself.
    """
    names = {}
    for name in arguments(effect.hooks[hook]):
        if name == "w":
            names[name] = f"s[W, {catalogue.slots[effect.name]}]"
        elif name in effect.names:
            names[name] = f"p[{catalogue.column(effect.name, name)}]"
        else:
            names[name] = signals.get(name, name)
    written = inlined(effect.hooks[hook], f"{effect.name}_{hook}", names)
    lines, call = written or ([], f"{effect.name}__{hook}({', '.join(names.values())})")
    lines = [*lines, pattern.format(call=call)]
    lines[0] += f"  # {effect.name}"
    return lines


def _masked(
    catalogue: Catalogue,
    hook: str,
    lines_of: Callable[[Effect], list[str]],
    places: str = "alone, more",
) -> list[str]:
    """Masked lines of every effect that has the hook: the one that stands alone, then the others behind one mask."""
    alone: list[str] = []
    more: list[str] = []
    for i, effect in enumerate(catalogue.effects):
        lines = lines_of(effect) if hook in effect.hooks else []
        if lines:
            block = [f"if on[{i}]:", *("    " + line for line in lines)]
            (alone if stands_alone(catalogue, effect, hook) else more).extend(block)
    if more:
        more = [f"if on[{of_hook(catalogue, hook)}]:", *("    " + line for line in more)]
    lines = alone * ("alone" in places) + more * ("more" in places)
    return ["    " + line for line in lines]


def _run(
    catalogue: Catalogue, run: str, lines: list[str], otherwise: list[str] | None = None
) -> list[str]:
    """Lines of a run of hooks behind one mask for them all, and what stands in their place without it."""
    if not lines:
        return otherwise or []
    body = [f"    if on[{of_run(catalogue, run)}]:", *("    " + line for line in lines)]
    return (
        body if otherwise is None else [*body, "    else:", *("    " + line for line in otherwise)]
    )


def _relax(
    catalogue: Catalogue, effect: Effect, slot: int = -1, signals: Mapping[str, str] = {}
) -> list[str]:
    """Lines that bring an effect's state to the end of the step, or another that follows its equation."""
    slot = catalogue.slots[effect.name] if slot < 0 else slot
    return [
        *_call(catalogue, effect, "relax", f"s[R, {slot}], s[G, {slot}] = {{call}}", signals),
        f"s[W, {slot}] = follow(s, first + {slot}, h, how)",
        *_bound(catalogue, effect, slot),
    ]


def _bound(catalogue: Catalogue, effect: Effect, slot: int) -> list[str]:
    """Lines that keep an effect's state within its bound, where it has one.

    What springs back against a force that follows from it takes one implicit stage. Under friction a first-order hold
    has two answers, one of which lets the joint slip before it presses.
    """
    if "bound" not in effect.hooks:
        return []
    if "give" not in effect.hooks:
        clipped = f"s[W, {slot}] = min(max(s[W, {slot}], -({{call}})), {{call}})"
        return _call(catalogue, effect, "bound", clipped)
    how = "max(how, STAGE)" if "f_r" in arguments(effect.hooks["relax"]) else "how"
    pressed = f"s[W, {slot}] = pressed(s, first + {slot}, h, {how}, limit, {{call}})"
    return [
        *_call(catalogue, effect, "bound", "limit = {call}"),
        *_call(catalogue, effect, "give", pressed),
    ]


def _lines(
    catalogue: Catalogue,
    hook: str,
    pattern: str,
    signals: Mapping[str, str] = {},
    places: str = "alone, more",
) -> list[str]:
    """Lines of a hook that computes, as `_masked` gives them; `pattern` holds {call}.

    Where the hook maps a signal that the effect's own state follows, the state's equation comes
    first: it is driven by the signal before the mapping.
    """

    def lines(effect: Effect) -> list[str]:
        first = _relax(catalogue, effect) if relaxes_at(effect) == hook else []
        return [*first, *_call(catalogue, effect, hook, pattern, signals)]

    return _masked(catalogue, hook, lines, places)


def _states(catalogue: Catalogue, place: str) -> list[str]:
    """States that are brought forward at a place between the hooks."""
    return _masked(
        catalogue, "relax", lambda e: _relax(catalogue, e) if relaxes_at(e) == place else []
    )


def _damper(catalogue: Catalogue) -> list[str]:
    """Source of `damper`: the whole damper at the end of a step, in the order of `kernel.order`."""
    slot = catalogue.slots["response"]
    passive = catalogue.offsets["passive"]
    body = ["def damper(on, p, s, h, how, x, v, a, u, t, theta):"]
    body += [
        "    first = 0 * s.shape[0]  # a bare number is a type to Numba: each would be a compilation"
    ]
    body += [f"    k_0 = p[{passive}]", f"    c_0 = p[{passive + 1}]", f"    f_y = s[W, {slot}]"]
    body += [f"    f_r = s[W, {catalogue.rest}]"]
    body += ["    yield_scale = 1.0", "    viscous_scale = 1.0", "    stiffness_scale = 1.0"]
    body += ["    y = 0.0"]
    body += _early(catalogue)
    body += _yield(catalogue)
    body += _response(catalogue)
    body += ["    f_d = f_y", "    u_f = u", *_act(catalogue)]
    return [*body, *_end(catalogue), "    return f_d, f_m, u"]


def _field(catalogue: Catalogue) -> list[str]:
    """The duty whose chains have formed: the lag of the yield force once more, on the duty."""
    slot = catalogue.formed
    lines = ["    u_f_scale = 1.0", *_foreseen(catalogue, slot, "u_f", "u")]
    lines += _lines(catalogue, "tau_scale", "u_f_scale *= {call}", OF_FIELD)
    lag = _relax(catalogue, catalogue["response"], slot, OF_FIELD)
    lines += [*("    " + line for line in lag), f"    u_f = s[W, {slot}]"]
    return _run(catalogue, FIELD, lines)


def _foreseen(catalogue: Catalogue, slot: int, signal: str, goal: str) -> list[str]:
    """Where a lag will be, as far as its own pace hangs on that."""
    return _run(catalogue, TURN, [f"    {signal} = foreseen(s, first + {slot}, h, how, {goal})"])


def _response(catalogue: Catalogue) -> list[str]:
    """The pace of the yield force, and its lag."""
    slot, time = catalogue.slots["response"], ("response_time", "tau_y += {call}")
    pace = _lines(catalogue, "tau_scale", "tau_scale *= {call}")
    pace += _lines(catalogue, *time, places="more")
    lag = ["    " + line for line in _relax(catalogue, catalogue["response"])]
    lines = ["    tau_scale = 1.0", "    tau_y = 0.0", *_foreseen(catalogue, slot, "f_y", "y")]
    lines += [*_lines(catalogue, *time, places="alone"), *_run(catalogue, "pace", pace)]
    lines += _run(catalogue, LAG, lag, [f"    s[W, {slot}] = y"])
    return [*lines, f"    f_y = s[W, {slot}]"]


def _act(catalogue: Catalogue) -> list[str]:
    """What acts beside the yield force: the field that has formed, states, and forces."""
    fluid = ["    f_h = f_y + viscous_scale * c_0 * v"]
    lines = _field(catalogue) + _states(catalogue, "states") + fluid + _forces(catalogue)
    return _run(catalogue, "act", lines, fluid + _forces(catalogue, "alone"))


def _forces(catalogue: Catalogue, places: str = "alone, more") -> list[str]:
    """What adds to the damper force; what the fluid carries adds to that as well."""

    def lines(effect: Effect) -> list[str]:
        if not effect.fluid:
            return _call(catalogue, effect, "force", "f_d += {call}")
        added = _call(catalogue, effect, "force", "f_i = {call}")
        return [*added, "f_d += f_i", "f_h += f_i"]

    return _masked(catalogue, "force", lines, places)


def _terms(catalogue: Catalogue) -> list[str]:
    """What measured terms add; the lag of what one of them sees lagged is brought forward first."""
    at, slot = f"first + {catalogue.size}", catalogue.lagged
    seen = f"x, v, a, u, u_f, f_y, theta, f_d, s[W, {slot}]"
    lines = [
        f"if p[{at} + 1] >= 0.0:",
        f"    s[R, {slot}] = p[{at} + 2]",
        f"    s[G, {slot}] = p[{at} + 2] * signal(p[{at} + 1], {seen})",
        f"    s[W, {slot}] = follow(s, first + {slot}, h, how)",
        f"f_d += measured(p, {at}, {seen})",
    ]
    return _run(catalogue, TERMS, ["    " + line for line in lines])


def _early(catalogue: Catalogue) -> list[str]:
    """The duty, the passive terms, the scale of the yield force and the motion, before anything uses them."""
    lines = _lines(catalogue, "duty", "u = {call}")
    lines += _lines(catalogue, "passive_stiffness", "k_0 += {call}")
    lines += _lines(catalogue, "passive_damping", "c_0 += {call}")
    lines += _lines(catalogue, "yield_scale", "yield_scale *= {call}")
    lines += _lines(catalogue, "shift_deflection", "x = {call}")
    lines += _lines(catalogue, "shift_velocity", "v = {call}")
    keep = ["    x_d, v_d = x, v"]
    lines += keep + _lines(catalogue, "flow_deflection", "x = {call}")
    return _run(catalogue, "early", lines + _lines(catalogue, "flow_velocity", "v = {call}"), keep)


def _yield(catalogue: Catalogue) -> list[str]:
    """The yield force that the field asks for, and the scales of viscosity and stiffness."""
    target = ("target", "y += {call}")
    done = ["    y *= yield_scale", "    x, v = x_d, v_d"]
    lines = _lines(catalogue, *target, places="more") + done
    for name in ("viscous_scale", "stiffness_scale"):
        lines += _lines(catalogue, name, f"{name} *= {{call}}")
    return _lines(catalogue, *target, places="alone") + _run(catalogue, "yield", lines, done)


def _end(catalogue: Catalogue) -> list[str]:
    """What follows once the force is there: measured terms, limits, what is driven by it, its sensor, and the rest."""
    lines = (
        _terms(catalogue) + _lines(catalogue, "limit", "f_d = {call}") + _states(catalogue, "late")
    )
    lines += ["    f_m = f_d", *_lines(catalogue, "sense", "f_m = {call}")]
    lines += [f"    s[SPEED, {catalogue.rest}] = v"]
    lines += [f"    s[W, {catalogue.rest}] = f_d - k_0 * x - c_0 * v"]
    return ["    f_m = f_d", *_run(catalogue, "end", lines)]


def _delay(catalogue: Catalogue, hook: str) -> list[str]:
    """Source of `input_delay` or `output_delay`: the sum of the delays that are on [s]."""
    body = [f"def {hook}(on, p):", "    delay = 0.0"]
    return [*body, *_lines(catalogue, hook, "delay += {call}"), "    return delay"]


def _chassis(catalogue: Catalogue) -> list[str]:
    """Source of `chassis`: spring force, tyre force and masses at one instant."""
    body = ["def chassis(on, p, x, v, z_t, v_t, v_s):"]
    names = {
        "m_s": "sprung_mass",
        "m_us": "unsprung_mass",
        "f_s": "spring_force",
        "f_t": "tyre_force",
    }
    body += [f"    {short} = 0.0" for short in names]
    for short, hook in names.items():
        body += _lines(catalogue, hook, f"{short} += {{call}}")
    body += _lines(catalogue, "tyre_limit", "f_t = {call}")
    return [*body, "    return f_s, f_t, m_s, m_us"]


def _accelerometers(catalogue: Catalogue) -> list[str]:
    """Source of `accelerometers`: what is reported of the accelerations of both masses."""
    body = ["def accelerometers(on, p, a_s, a_us):"]
    body += _lines(catalogue, "sprung_reading", "a_s = {call}")
    body += _lines(catalogue, "unsprung_reading", "a_us = {call}")
    return [*body, "    return a_s, a_us"]


@lru_cache(maxsize=8)
def source(catalogue: Catalogue) -> str:
    """Complete source of the kernel module of a catalogue."""
    parts = [
        '"""Generated from the catalogue of effects; do not edit."""',
        "import math",
        "import numpy as np",
        "from er_models.kernel.elementary import exp, tanh",
        "from er_models.kernel.fast import entry, inline, inner, linked, once",
        "from er_models.kernel.hooks import compiled as _compiled",
        "from er_models.kernel.terms import measured, signal",
        f"INSTANT = {INSTANT!r}",
        f"ZERO, HEAT, CAUGHT, SLIDES = {ZERO}, {HEAT}, {CAUGHT}, {SLIDES}",
    ]
    composed = [_damper(catalogue), _chassis(catalogue), _accelerometers(catalogue)]
    composed += [_delay(catalogue, "input_delay"), _delay(catalogue, "output_delay")]
    text = "\n".join("\n".join(["", "", "@inline", *lines]) for lines in composed)
    parts += [
        f"{effect.name}__{hook} = _compiled('{effect.name}', '{hook}')"
        for effect in catalogue.effects
        for hook in effect.hooks
        if f"{effect.name}__{hook}(" in text
    ]
    texts = [(Path(__file__).parent / f"{name}.py").read_text(encoding="utf-8") for name in PARTS]
    templates = [text.split(_MARK)[1] for text in texts]
    return "\n".join([*parts, templates[0], text, "", *templates[1:]])


@lru_cache(maxsize=8)
def fingerprint(catalogue: Catalogue) -> str:
    """Hash of everything the equations are made of: a model of the same hash behaves the same.

    It names the kernel, too; where that is compiled, all sources of this package are looked at beside it.
    """
    text = source(catalogue)
    digest = hashlib.sha256(text.encode())
    for name in _OURS.findall(text):
        digest.update(Path(str(import_module(name).__file__)).read_bytes())
    for origin in catalogue.origins.values():
        digest.update(origin.digest.encode())
    for effect in catalogue.effects:
        for function in effect.hooks.values():
            digest.update(inspect.getsource(function).encode())
            digest.update(repr(_constants(function)).encode())
    return digest.hexdigest()[:16]


def _constants(function: Any, seen: frozenset[Any] = frozenset()) -> list[tuple[str, str]]:
    """Constants and helpers that a hook refers to: a change of theirs is a change of the equation."""
    found = []
    for name, value in _named(function):
        plain = getattr(value, "py_func", value)  # of what is compiled already
        if inspect.isfunction(plain) and plain not in seen:
            found.append((name, inspect.getsource(plain)))
            found += _constants(plain, seen | {plain})
        elif isinstance(value, int | float | tuple):
            found.append((name, repr(value)))
        elif isinstance(value, np.ndarray):
            found.append((name, value.tobytes().hex()))
    return found


def _named(function: Any) -> list[tuple[str, Any]]:
    """What the names in a function may stand for: globals of its module, and of the modules among these."""
    code: CodeType = function.__code__
    names, known = sorted(code.co_names), function.__globals__
    found = [(name, known[name]) for name in names if name in known]
    modules = [vars(value) for _, value in found if isinstance(value, ModuleType)]
    return found + [(name, inner[name]) for inner in modules for name in names if name in inner]
