"""The order in which the composed damper works, and what follows from it.

    duty, passive_stiffness, passive_damping, yield_scale, shift_deflection, shift_velocity,
    flow_deflection, flow_velocity, target, viscous_scale, stiffness_scale, tau_scale,
    response_time, [response], [field], [states], force, limit, [late states], sense

The flow hooks map the motion for `target` alone; what follows sees the motion of the damper again.

At [field] the duty u_f whose chains have formed follows the duty by the equation and with the response time of
the yield force.

A state is brought to the end of the step at one of these places. A hook that reads it earlier sees
the trial of the search in `kernel.states`; the states for which this happens are the links of a
model. What sets the pace of the response sees the yield force that is foreseen at the end of the step.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import cache

from er_models.effect import Effect, arguments

ORDER = (
    "duty", "passive_stiffness", "passive_damping", "yield_scale", "shift_deflection",
    "shift_velocity", "flow_deflection", "flow_velocity", "target", "viscous_scale",
    "stiffness_scale", "tau_scale", "response_time", "response", "states", "force", "limit", "late",
    "sense",
)  # fmt: skip
_PACE = ("tau_scale", "response_time")
_MAPS = ("duty", "shift_deflection", "shift_velocity", "flow_deflection", "flow_velocity")
KNOWN_FROM = {
    **dict.fromkeys(("x", "v", "a", "u", "t", "theta"), "duty"),
    **dict.fromkeys(("k_0", "c_0", "f_y", "f_r"), "passive_stiffness"),
    **dict.fromkeys(("yield_scale", "viscous_scale", "stiffness_scale"), "yield_scale"),
    **dict.fromkeys(("tau_scale", "tau_y", "y"), "yield_scale"),
    **dict.fromkeys(("f_d", "u_f"), "states"),
    "f_h": "limit",
    "f_m": "sense",
}
"""Place of `ORDER` from which a hook may ask for a signal of the damper."""
OF_STATE = ("relax", "bound", "give")
"""Hooks that act where the state of their effect is brought forward."""
_CAR = ("x", "v", "z_t", "v_t", "v_s", "m_s", "m_us")
OUTSIDE: dict[str, tuple[str, ...]] = {
    "input_delay": (), "output_delay": (),
    "sprung_mass": _CAR, "unsprung_mass": _CAR, "spring_force": _CAR, "tyre_force": _CAR,
    "tyre_limit": (*_CAR, "f_t"),
    "sprung_reading": ("a_s", "a_us"), "unsprung_reading": ("a_s", "a_us"),
}  # fmt: skip
"""Signals of the hooks that do not act within the damper."""


def signals_of(effect: Effect, hook: str) -> tuple[str, ...]:
    """Signals that a hook of an effect may ask for, `w` among them where it has a state."""
    if hook in OUTSIDE:
        return OUTSIDE[hook]
    place = relaxes_at(effect) or "late" if hook in OF_STATE else hook
    known = tuple(name for name, start in KNOWN_FROM.items() if not _before(place, start))
    return (*known, "w") if effect.has_state else known


@cache
def relaxes_at(effect: Effect) -> str:
    """Place of `ORDER` at which an effect's state is brought forward; empty where it has none."""
    if not effect.has_state:
        return ""
    if effect.name == "response":
        return "response"
    for hook in _MAPS:
        if hook in effect.hooks:
            return hook
    driven = arguments(effect.hooks["relax"])
    if "f_h" in driven:
        return "limit" if "limit" in effect.hooks else "late"
    return "late" if "f_d" in driven else "states"


@cache
def feeds_back(effect: Effect) -> bool:
    """Whether an effect's own state is read before it is brought forward."""
    place = relaxes_at(effect)
    if not place:
        return False
    early = [hook for hook in effect.hooks if hook in ORDER and _before(hook, place)]
    return any("w" in arguments(effect.hooks[hook]) for hook in ("relax", *early))


def caught(effect: Effect) -> bool:
    """Whether a contact that gives way, or the friction behind a joint, may hold an effect's state anywhere."""
    return "give" in effect.hooks or "f_r" in arguments(effect.hooks["relax"])


def slides(effect: Effect) -> bool:
    """Whether friction may hold an effect's state anywhere and yet has no play: what drives it on makes it slide."""
    relax: Callable[..., tuple[float, float]] = effect.hooks["relax"]  # type: ignore[assignment]
    if not caught(effect) or "f_r" in arguments(relax):
        return False
    return relax(*[1.0] * len(arguments(relax)))[0] > 0.0


def reads_yield_early(effects: Iterable[Effect]) -> bool:
    """Whether any effect reads the yield force f_y before it is brought forward, but for what sets its pace."""
    return any(_reads_yield_early(effect) for effect in effects)


def reads(effects: Iterable[Effect], signal: str) -> bool:
    """Whether a hook of any effect reads a signal."""
    return any(
        signal in arguments(effect.hooks[hook]) for effect in effects for hook in effect.hooks
    )


def turns_with_the_yield(effects: Iterable[Effect]) -> bool:
    """Whether a response time depends on where the yield force is, and so that of u_f on where u_f is."""
    paces = [e.hooks[hook] for e in effects for hook in _PACE if hook in e.hooks]
    return any("f_y" in arguments(hook) for hook in paces)


@cache
def _reads_yield_early(effect: Effect) -> bool:
    """Whether one effect does."""
    for hook in effect.hooks:
        place = relaxes_at(effect) if hook == "relax" else hook
        if (
            place in ORDER
            and place not in _PACE
            and _before(place, "response")
            and "f_y" in arguments(effect.hooks[hook])
        ):
            return True
    return False


def _before(place: str, other: str) -> bool:
    return ORDER.index(place) < ORDER.index(other)
