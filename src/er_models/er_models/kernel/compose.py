"""Writes the source of one kernel module for a whole catalogue.

Effects a model does not use are switched off by a mask, so one compilation serves every model and every
combination the lab tries. The module's name is a hash of all sources, so a changed equation can never
meet a stale compilation.
"""

from __future__ import annotations

import hashlib
import inspect
from collections.abc import Callable
from pathlib import Path

from er_models.catalogue import Catalogue
from er_models.effect import HOOKS, Effect

_ARGUMENTS = "on, p, w, x, v, a, u, t, theta, rate, drive"


def _call(catalogue: Catalogue, effect: Effect, hook: str) -> str:
    """Source of a call of a hook with its arguments taken from the flat vectors."""
    arguments = []
    for name in inspect.signature(effect.hooks[hook]).parameters:
        if name == "w":
            arguments.append(f"w[{catalogue.slots[effect.name]}]")
        elif name in effect.names:
            arguments.append(f"p[{catalogue.column(effect.name, name)}]")
        else:
            arguments.append(name)
    return f"{effect.name}__{hook}({', '.join(arguments)})"


def group(catalogue: Catalogue, hook: str) -> int:
    """Place in the mask that says whether any effect beyond the core uses a hook."""
    return len(catalogue.effects) + tuple(HOOKS).index(hook)


def _masked(catalogue: Catalogue, hook: str, lines_of: Callable[[Effect], list[str]]) -> list[str]:
    """Masked lines of every effect that has the hook.

    Effects beyond the core stand behind one mask for all of them: a model that uses none of them pays
    for one branch, not for thirty.
    """
    core, more = [], []
    for i, effect in enumerate(catalogue.effects):
        if hook in effect.hooks:
            lines = lines_of(effect)
            block = [f"if on[{i}]:", *("    " + line for line in lines)] if lines else []
            (core if effect.stage == "core" else more).extend(block)
    if more:
        core += [f"if on[{group(catalogue, hook)}]:", *("    " + line for line in more)]
    return ["    " + line for line in core]


def _relax(catalogue: Catalogue, effect: Effect) -> str:
    """Line that sets rate and drive of an effect's state."""
    slot = catalogue.slots[effect.name]
    return f"rate[{slot}], drive[{slot}] = {_call(catalogue, effect, 'relax')}"


def _lines(catalogue: Catalogue, hook: str, pattern: str) -> list[str]:
    """Lines of a hook that computes; `pattern` holds {call}.

    Where the hook maps a signal that the effect's own state follows, the state's equation comes first:
    it is driven by the signal before the mapping.
    """

    def lines(effect: Effect) -> list[str]:
        first = _maps_input(effect) == hook
        return ([_relax(catalogue, effect)] if first else []) + [pattern.format(call=_call(catalogue, effect, hook))]

    return _masked(catalogue, hook, lines)


def _maps_input(effect: Effect) -> str | None:
    """First hook by which an effect with a state maps a signal on its way in, if any."""
    if effect.has_state:
        for hook in ("duty", "shift_deflection", "shift_velocity"):
            if hook in effect.hooks:
                return hook
    return None


def _late_relax(catalogue: Catalogue) -> list[str]:
    """State equations of all effects that see the finished signals."""
    return _masked(
        catalogue,
        "relax",
        lambda effect: [] if _maps_input(effect) else [_relax(catalogue, effect)],
    )


def _evaluate(catalogue: Catalogue) -> list[str]:
    """Source of `evaluate`: the whole damper at one instant."""
    response = catalogue.index("response")
    slot = catalogue.slots["response"]
    passive = catalogue.offsets["passive"]
    body = [f"def evaluate({_ARGUMENTS}):"]
    body += _lines(catalogue, "duty", "u = {call}")
    body += [f"    k_0 = p[{passive}]", f"    c_0 = p[{passive + 1}]", "    y = 0.0", "    yield_scale = 1.0"]
    body += _lines(catalogue, "yield_scale", "yield_scale *= {call}")
    body += [f"    f_y = w[{slot}]", f"    if on[{group(catalogue, 'shift_velocity')}] and not on[{response}]:"]
    body += ["    " + line for line in _lines(catalogue, "target", "y += {call}")]
    body += ["        f_y = y * yield_scale", "        y = 0.0"]
    body += _lines(catalogue, "shift_deflection", "x = {call}")
    body += _lines(catalogue, "shift_velocity", "v = {call}")
    body += ["    viscous_scale = 1.0", "    stiffness_scale = 1.0", "    tau_scale = 1.0"]
    body += _lines(catalogue, "target", "y += {call}")
    body += ["    y *= yield_scale", f"    if not on[{response}]:", "        f_y = y"]
    body += _lines(catalogue, "viscous_scale", "viscous_scale *= {call}")
    body += _lines(catalogue, "stiffness_scale", "stiffness_scale *= {call}")
    body += _lines(catalogue, "tau_scale", "tau_scale *= {call}")
    body += ["    f_d = f_y"]
    body += _lines(catalogue, "force", "f_d += {call}")
    body += _lines(catalogue, "limit", "f_d = {call}")
    body += ["    f_m = f_d"]
    body += _late_relax(catalogue)
    body += _lines(catalogue, "sense", "f_m = {call}")
    body += ["    return f_d, f_m, u"]
    return body


def _delay(catalogue: Catalogue, hook: str) -> list[str]:
    """Source of `input_delay` or `output_delay`: the sum of the delays that are on [s]."""
    body = [f"def {hook}(on, p):", "    delay = 0.0"]
    return body + _lines(catalogue, hook, "delay += {call}") + ["    return delay"]


def _chassis(catalogue: Catalogue) -> list[str]:
    """Source of `chassis`: spring force, tyre force and both masses at one instant."""
    body = ["def chassis(on, p, x, v, z_t, v_t, v_s):", "    f_s = 0.0", "    f_t = 0.0"]
    body += ["    m_s = 0.0", "    m_us = 0.0"]
    body += _lines(catalogue, "spring_force", "f_s += {call}")
    body += _lines(catalogue, "tyre_force", "f_t += {call}")
    body += _lines(catalogue, "sprung_mass", "m_s += {call}")
    body += _lines(catalogue, "unsprung_mass", "m_us += {call}")
    return body + ["    return f_s, f_t, m_s, m_us"]


def _imports(catalogue: Catalogue) -> list[str]:
    """Source that fetches every hook of the catalogue and compiles it for inlining."""
    lines = []
    for effect in catalogue.effects:
        for hook in effect.hooks:
            lines.append(f"{effect.name}__{hook} = _compiled('{effect.name}', '{hook}')")
    return lines


def source(catalogue: Catalogue) -> str:
    """Complete source of the kernel module of a catalogue."""
    template = (Path(__file__).parent / "integrate.py").read_text(encoding="utf-8")
    _, integrators = template.split("# --- below this line: compiled with the composed equations ---\n")
    parts = [
        '"""Generated from the catalogue of effects; do not edit."""',
        "import math",
        "import numpy as np",
        "from numba import njit, prange",
        "from er_models.kernel.hooks import compiled as _compiled",
        *_imports(catalogue),
    ]
    for function in (_evaluate(catalogue), _chassis(catalogue), _delay(catalogue, "input_delay"),
                     _delay(catalogue, "output_delay")):  # fmt: skip
        parts += ["", "", "@njit(error_model='numpy')", *function]
    return "\n".join(parts) + "\n\n\n" + integrators


def fingerprint(catalogue: Catalogue) -> str:
    """Hash of everything the kernel is made of: equations, layout and integrators."""
    digest = hashlib.sha256(source(catalogue).encode())
    for effect in catalogue.effects:
        for function in effect.hooks.values():
            digest.update(inspect.getsource(function).encode())
    return digest.hexdigest()[:16]
