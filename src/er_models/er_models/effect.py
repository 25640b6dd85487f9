"""What a physical effect is: one equation, its parameters, and how it shows itself.

An effect is a frozen record of plain scalar functions (hooks). The arguments of a hook are found by
name: parameters of the effect, the signals below, and ``w``, the effect's own state. The same functions
are compiled for simulation and fitting, traced for the documentation and differentiated for linearisation,
so each equation stands in one place.
"""

from __future__ import annotations

import inspect
import math
from collections.abc import Callable
from dataclasses import dataclass, field
from functools import cache
from typing import Literal, NamedTuple

Stage = Literal["core", "force", "actuation", "heat", "sensing", "fault", "vehicle"]


class Signal(NamedTuple):
    """What a hook may ask for: its unit, one of `er_models.scales`, and what it is.

    A duty has no unit, yet its natural scale is its own: it stands as ``duty``, as in the units of parameters.
    """

    unit: str
    text: str


SIGNALS: dict[str, Signal] = {
    "x": Signal("m", "deflection of the damper, extension positive"),
    "v": Signal("m/s", "deflection velocity"),
    "a": Signal("m/s2", "deflection acceleration"),
    "u": Signal("duty", "duty after the actuation effects"),
    "t": Signal("s", "time since the record began"),
    "theta": Signal("K", "measured temperature above the reference"),
    "stiffness_scale": Signal("1", "product of all stiffness scales"),
    "viscous_scale": Signal("1", "product of all viscosity scales"),
    "yield_scale": Signal("1", "product of all yield force scales"),
    "tau_scale": Signal("1", "product of all response time scales"),
    "k_0": Signal("N/m", "passive stiffness in force"),
    "c_0": Signal("N s/m", "passive damping in force"),
    "tau_y": Signal("s", "response time of the yield force, before its scales"),
    "y": Signal("N", "yield force the field asks for, before its lag"),
    "f_y": Signal("N", "yield force, after its lag"),
    "u_f": Signal("duty", "duty whose chains have formed: u after the response time of the fluid"),
    "f_h": Signal(
        "N", "force that the fluid carries by its pressure: viscous, yield and flow losses"
    ),
    "f_r": Signal(
        "N", "force of the damper beyond k_0 x + c_0 v, for what stands in series with it"
    ),
    "f_d": Signal("N", "damper force"),
    "f_m": Signal("N", "damper force after the sensors before this one"),
    "z_t": Signal("m", "tyre deflection, wheel minus road, extension positive"),
    "v_t": Signal("m/s", "tyre deflection velocity"),
    "v_s": Signal("m/s", "absolute velocity of the sprung mass"),
    "m_s": Signal("kg", "sprung mass, of the effects before this one"),
    "m_us": Signal("kg", "unsprung mass, of the effects before this one"),
    "f_t": Signal("N", "force between wheel and road, pull positive"),
    "a_s": Signal("m/s2", "acceleration of the sprung mass, after the sensors before this one"),
    "a_us": Signal("m/s2", "acceleration of the unsprung mass, after the sensors before this one"),
}

HOOKS: dict[str, str] = {
    "duty": "maps the duty on its way from the command to the fluid",
    "passive_stiffness": "adds to the passive stiffness that a series element sees",
    "passive_damping": "adds to the passive damping that a series element sees",
    "shift_deflection": "maps the measured deflection to that of the damper",
    "shift_velocity": "maps the measured velocity to that of the damper",
    "flow_deflection": "maps the deflection of the damper to that which the yield force sees",
    "flow_velocity": "maps the velocity of the damper to that which the yield force sees",
    "stiffness_scale": "multiplies the passive stiffness",
    "viscous_scale": "multiplies the passive damping",
    "yield_scale": "multiplies the yield force",
    "tau_scale": "multiplies the response time of the yield force; and of u_f, with u for y and u_f for f_y",
    "response_time": "adds to the response time of the yield force",
    "target": "adds to the yield force that the field asks for",
    "force": "adds to the damper force",
    "limit": "maps the damper force",
    "relax": "gives (rate, drive) of the own state: w' = drive - rate * w",
    "bound": "gives the largest magnitude of the own state; of what has a play, that comes first",
    "give": "gives the rate at which the own state springs back from beyond its bound, which is rigid without it",
    "sense": "maps the damper force to the measured one",
    "input_delay": "delays the duty",
    "output_delay": "delays the measured force against the motion",
    "spring_force": "adds to the force between the masses, beside the damper",
    "tyre_force": "adds to the force between wheel and road",
    "sprung_mass": "adds to the sprung mass",
    "unsprung_mass": "adds to the unsprung mass",
    "tyre_limit": "maps the force between wheel and road",
    "sprung_reading": "maps the acceleration of the sprung mass to the reported one",
    "unsprung_reading": "maps the acceleration of the unsprung mass to the reported one",
}

REGIONS = (
    "slow", "fast_extension", "fast_compression", "far_extension", "far_compression", "reversals",
    "low_duty", "small_duty", "high_duty", "duty_levels", "duty_rises", "duty_falls", "fast_high_duty", "far_high_duty",
    "minutes", "load_change", "warming",
)  # fmt: skip
"""Regions of motion, duty, time and temperature; the lab counts how much of each a record holds."""


@cache
def arguments(function: Callable[..., object]) -> tuple[str, ...]:
    """Names of a hook's arguments."""
    return tuple(inspect.signature(function).parameters)


INSTANT = 1e9
"""Rate [1/s] by which `relax` says: equal to the equilibrium at once; the kernel takes it so."""
SHORTEST = 1.0 / INSTANT
"""Time constant [s] in place of a shorter one, whose rate is then that."""
LEAST_DAMPING = 1e-9
"""Added to a damping that divides [N s/m], against division by zero: nothing beside that of any damper."""
LEAST_COMPLIANCE = 1e-100
"""The same for a compliance [m/N]."""
LEAST_TIME = 1e-6
"""A mount springs back no faster than in this time [s]: beside a damper without damping it had no velocity to be at."""
SMOOTH, CONTACT, SWITCH = 3e-6, 1e-5, 1e-2
"""Steps of derivatives, as shares of a value: of a smooth equation, of one with a contact that
opens and closes, of one that jumps."""


@dataclass(frozen=True, slots=True)
class Param:
    """One parameter; low, high and starts are multiples of the natural scale of its unit.

    The natural scale comes from the data or the model (`er_models.scales`), so that the same declaration
    serves dampers that differ by a factor of 100 in force. step: share of the value over which a derivative
    is taken (`er_models.sensitivity`); longer where the value moves the instants of jumps. optional: a model file that
    does not name it means its neutral value; for what an effect was given after files with it were written.
    """

    name: str
    unit: str
    low: float
    high: float
    neutral: float | None
    starts: tuple[float, ...]
    meaning: str
    fitted: bool = True
    step: float = SMOOTH
    optional: bool = False

    @property
    def size(self) -> float:
        """Magnitude of typical values, in multiples of the natural scale."""
        return max([abs(s) for s in self.starts if math.isfinite(s)] + [1e-3])


@dataclass(frozen=True, slots=True)
class Signature:
    """How an effect shows itself and what would show it best.

    mark: what it does to the data, in words. plane: quantities over which that is seen, such as ``force-velocity``,
    ``force-duty`` or ``time``; the lab draws its evidence over deflection, duty, time or acceleration where it says so,
    else over the velocity, the card of an effect of the car over the velocity where it ends in it, else over the
    deflection. experiment: motion and duty that show it best, in words; the lab's plans do not follow it.
    rivals: effects that may be named in its place where it is the true one, for people to read. They point one way:
    a fault or an effect of the car can look like one of the damper without the damper's own page naming it.
    needs: regions (`REGIONS`) that a record must hold to show it; None where the signals of its hooks tell.
    """

    mark: str
    plane: str
    experiment: str
    rivals: tuple[str, ...] = ()
    needs: tuple[str, ...] | None = None


@dataclass(frozen=True, slots=True, eq=False)
class Effect:
    """A physical effect: equation hooks, parameters, signature and source.

    `hooks` maps a key of `HOOKS` to a scalar function. `initial` tells where its state begins: at rest
    (zero), for one that integrates or is slower than a second, or in equilibrium with the first sample.
    `dissipative`: without a state of its own, and its force takes energy whatever its parameters. `fluid`: its force is
    carried by the pressure of the fluid (f_h), so that it ends where the fluid cavitates.
    `generalises`: effects that are special cases of it; where both pass, it is named only if it gains far more.
    `within`: strengths that are at most so many times another one where the effect is what it is called, such as a
    breakaway and the sliding friction; beyond that it stands for something else.
    `damped`: the least passive damping that a fit gives the damper beside it, in multiples of the natural scale.
    `knowable`: whether the channels of a damper can show it at all. One that they cannot show is simulated, and a
    model may hold it, but it is neither fitted, planned for, added nor tried by the diagnosis; `unknowable_because`
    is what the user is told then, and empty else.
    """

    name: str
    stage: Stage
    title: str
    physics: str
    parameters: tuple[Param, ...]
    hooks: dict[str, Callable[..., object]]
    signature: Signature
    source: str
    dissipative: bool = False
    fluid: bool = False
    initial: Literal["equilibrium", "zero"] = "equilibrium"
    generalises: tuple[str, ...] = ()
    within: tuple[tuple[str, float, str], ...] = ()
    damped: float = 0.0
    knowable: bool = True
    unknowable_because: str = ""
    _names: tuple[str, ...] = field(init=False, default=())

    def __post_init__(self) -> None:
        names = tuple(p.name for p in self.parameters)
        object.__setattr__(self, "_names", names)
        for region in self.signature.needs or ():
            if region not in REGIONS:
                known = ", ".join(REGIONS)
                raise ValueError(f"{self.name}: unknown region '{region}', known: {known}")
        for strength, _, other in self.within:
            if not {strength, other} <= {*names}:
                raise ValueError(f"{self.name}.within: '{strength}', '{other}' are no parameters")
        for hook, function in self.hooks.items():
            if hook not in HOOKS:
                raise ValueError(f"{self.name}: unknown hook '{hook}', known: {', '.join(HOOKS)}")
            for argument in arguments(function):
                if argument not in names and argument not in SIGNALS and argument != "w":
                    raise ValueError(
                        f"{self.name}.{hook}: argument '{argument}' is no parameter or signal"
                    )

    @property
    def unsaid(self) -> dict[str, float]:
        """Neutral values of the optional parameters: what a model means that does not name them."""
        return {q.name: q.neutral for q in self.parameters if q.optional and q.neutral is not None}

    @property
    def has_state(self) -> bool:
        """Whether the effect carries a state of its own."""
        return "relax" in self.hooks

    @property
    def maps_motion(self) -> bool:
        """Whether it is a sensor's map from the measured motion to the true one."""
        maps = {"shift_deflection", "shift_velocity"}
        return self.stage == "sensing" and not maps.isdisjoint(self.hooks)

    @property
    def names(self) -> tuple[str, ...]:
        """Names of the parameters, in order."""
        return self._names

    def parameter(self, name: str) -> Param:
        """Parameter of that name; `KeyError` if there is none."""
        return self.parameters[self._names.index(name)]
