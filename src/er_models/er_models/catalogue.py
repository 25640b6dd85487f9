"""The one list of all effects, in the order in which they act within their stage."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Mapping
from dataclasses import dataclass, field
from typing import Any

from er_models.effect import Effect
from er_models.effects.actuation import (
    amplifier_lag,
    dead_time,
    duty_dead_band,
    duty_gain,
    field_exponent,
    field_saturation,
    rise_fall_asymmetry,
    varying_time_constant,
)
from er_models.effects.core import (
    bingham_yield,
    bingham_yield_by_direction,
    guo_yield,
    guo_yield_by_direction,
    passive,
    passive_by_direction,
    response,
    response_quadratic,
    response_table,
)
from er_models.effects.fault import duct_deformation, electrical_fault, oil_leakage
from er_models.effects.force import (
    asymmetric_damping,
    bouc_wen_hysteresis,
    cavitation,
    coulomb_friction,
    end_stop,
    field_stiffness,
    field_viscosity,
    fluid_inertia,
    freeplay,
    gas_spring,
    herschel_bulkley,
    mount_compliance,
    piston_play,
    position_dependent_damping,
    preload,
    quadratic_damping,
    shear_thinning,
    stribeck_friction,
    viscoelastic_branch,
)
from er_models.effects.heat import effectiveness_fade, self_heating
from er_models.effects.sensing import (
    deflection_zero,
    force_delay,
    force_gain,
    force_lag,
    velocity_gain,
    velocity_lag,
)
from er_models.effects.vehicle import (
    accelerometer_bias,
    guide_friction,
    quarter_car,
    spring_nonlinearity,
    sprung_mass_error,
    tyre_damping,
    tyre_lift_off,
)
from er_models.errors import UnknownName

_MODULES = (
    passive, guo_yield, bingham_yield, response,
    passive_by_direction, guo_yield_by_direction, bingham_yield_by_direction,
    response_quadratic, response_table,
    deflection_zero, velocity_gain, velocity_lag,
    dead_time, amplifier_lag, duty_gain, duty_dead_band, field_exponent, field_saturation,
    varying_time_constant, rise_fall_asymmetry,
    self_heating, effectiveness_fade,
    electrical_fault, oil_leakage, duct_deformation,
    mount_compliance, freeplay, piston_play,
    preload, gas_spring, coulomb_friction, stribeck_friction, quadratic_damping,
    asymmetric_damping, shear_thinning, position_dependent_damping, end_stop,
    bouc_wen_hysteresis, viscoelastic_branch, fluid_inertia, field_viscosity, field_stiffness,
    herschel_bulkley, cavitation, force_lag, force_gain, force_delay,
    quarter_car, sprung_mass_error, spring_nonlinearity, guide_friction, tyre_damping, tyre_lift_off,
    accelerometer_bias,
)  # fmt: skip


@dataclass(frozen=True, slots=True)
class Origin:
    """The file a user's own effect comes from: its name and the SHA-256 of its content."""

    file: str
    digest: str


@dataclass(frozen=True, eq=False)
class Catalogue:
    """An ordered set of effects and the layout of their parameters and states in flat vectors.

    origins: by name, where the effects come from that a user added; made: function and arguments by which another
    process makes it, None: it cannot; formed: the slot of the duty u_f whose chains
    have formed; rest: the last slot, where the kernel searches the force f_r of a damper in series with something.
    """

    effects: tuple[Effect, ...]
    origins: Mapping[str, Origin] = field(default_factory=dict)
    made: tuple[Callable[..., Catalogue], tuple[Any, ...]] | None = None

    offsets: dict[str, int] = field(init=False, compare=False)
    slots: dict[str, int] = field(init=False, compare=False)
    size: int = field(init=False, compare=False)
    formed: int = field(init=False, compare=False)
    rest: int = field(init=False, compare=False)
    n_states: int = field(init=False, compare=False)

    def __post_init__(self) -> None:
        offsets: dict[str, int] = {}
        slots: dict[str, int] = {}
        at = slot = 0
        for effect in self.effects:
            if effect.name in offsets:
                raise ValueError(f"effect '{effect.name}' is listed twice")
            offsets[effect.name] = at
            at += len(effect.parameters)
            if effect.has_state:
                slots[effect.name] = slot
                slot += 1
        object.__setattr__(self, "offsets", offsets)
        object.__setattr__(self, "slots", slots)
        object.__setattr__(self, "size", at)
        object.__setattr__(self, "formed", slot)
        object.__setattr__(self, "rest", slot + 1)
        object.__setattr__(self, "n_states", slot + 2)

    def __reduce__(self) -> tuple[Callable[..., Catalogue], tuple[Any, ...]]:
        if self.made is None:
            raise TypeError("effects that come from no file cannot be sent to another process")
        return self.made

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all effects."""
        return tuple(e.name for e in self.effects)

    def __getitem__(self, name: str) -> Effect:
        for effect in self.effects:
            if effect.name == name:
                return effect
        raise UnknownName("effect", name, self.names)

    def index(self, name: str) -> int:
        """Position of an effect; `UnknownName` if there is none."""
        return self.effects.index(self[name])

    def column(self, name: str, parameter: str) -> int:
        """Place of a parameter in the flat parameter vector."""
        effect = self[name]
        if parameter not in effect.names:
            raise UnknownName(f"parameter of {name}", parameter, effect.names)
        return self.offsets[name] + effect.names.index(parameter)

    def candidates(self) -> tuple[Effect, ...]:
        """Effects that the diagnosis of a damper tries: no core terms, no faults, none of the car, none unknowable."""
        left_out = ("core", "fault", "vehicle")
        return tuple(e for e in self.effects if e.stage not in left_out and e.knowable)

    def unknowable(self) -> tuple[Effect, ...]:
        """Effects that the channels of a damper cannot show, whatever the record."""
        return tuple(e for e in self.effects if not e.knowable)

    def extended(
        self,
        more: Iterable[Effect],
        origins: Mapping[str, Origin] | None = None,
        made: tuple[Callable[..., Catalogue], tuple[Any, ...]] | None = None,
    ) -> Catalogue:
        """This catalogue with a user's own effects at its end."""
        return Catalogue(self.effects + tuple(more), {**self.origins, **(origins or {})}, made)


def shipped() -> Catalogue:
    """The catalogue without any effect of a user's own."""
    return CATALOGUE


CATALOGUE = Catalogue(tuple(module.EFFECT for module in _MODULES), made=(shipped, ()))
