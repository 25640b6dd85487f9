"""The one list of all effects, in the order in which they act within their stage."""

from __future__ import annotations

from collections.abc import Callable, Iterable, Iterator, Mapping
from dataclasses import dataclass, field
from importlib import import_module
from typing import Any

from er_models.effect import Effect
from er_models.errors import UnknownName

_LISTED = (
    "core.passive",
    "core.guo_yield",
    "core.bingham_yield",
    "core.response",
    "core.passive_by_direction",
    "core.guo_yield_by_direction",
    "core.bingham_yield_by_direction",
    "core.response_quadratic",
    "core.response_table",
    "sensing.deflection_zero",
    "sensing.velocity_gain",
    "sensing.velocity_lag",
    "actuation.dead_time",
    "actuation.amplifier_lag",
    "actuation.duty_gain",
    "actuation.duty_dead_band",
    "actuation.remanence",
    "actuation.field_exponent",
    "actuation.field_saturation",
    "actuation.varying_time_constant",
    "actuation.rise_fall_asymmetry",
    "heat.self_heating",
    "heat.temperature_thinning",
    "heat.effectiveness_fade",
    "fault.electrical_fault",
    "fault.oil_leakage",
    "fault.duct_deformation",
    "force.mount_compliance",
    "force.freeplay",
    "force.piston_play",
    "force.preload",
    "force.field_preload",
    "force.gas_spring",
    "force.coulomb_friction",
    "force.stribeck_friction",
    "force.directional_friction",
    "force.field_friction",
    "force.load_friction",
    "force.friction_with_play",
    "force.quadratic_damping",
    "force.asymmetric_damping",
    "force.blow_off_valve",
    "force.shear_thinning",
    "force.position_dependent_damping",
    "force.end_stop",
    "force.bouc_wen_hysteresis",
    "force.viscoelastic_branch",
    "force.fluid_inertia",
    "force.field_viscosity",
    "force.field_stiffness",
    "force.herschel_bulkley",
    "force.piston_leakage",
    "force.cavitation",
    "heat.force_fade",
    "sensing.force_lag",
    "sensing.force_gain",
    "sensing.force_delay",
    "vehicle.quarter_car",
    "vehicle.sprung_mass_error",
    "vehicle.spring_nonlinearity",
    "vehicle.guide_friction",
    "vehicle.tyre_damping",
    "vehicle.tyre_lift_off",
    "vehicle.accelerometer_bias",
)
"""Stage and name of each."""


@dataclass(frozen=True, slots=True)
class Origin:
    """The file a user's own effect comes from: its name and the SHA-256 of its content."""

    file: str
    digest: str


@dataclass(frozen=True, eq=False, repr=False)
class Catalogue:
    """Effects in order, by name in brackets, and the layout of their parameters and states in flat vectors.

    origins: by name, where the effects come from that a user added; made: function and arguments by which another
    process makes it, None: it cannot; formed: the slot of the duty u_f whose chains
    have formed; lagged: that of what a measured term sees lagged; rest: the last slot, where the kernel searches the
    force f_r of a damper in series with something.
    """

    effects: tuple[Effect, ...]
    origins: Mapping[str, Origin] = field(default_factory=dict)
    made: tuple[Callable[..., Catalogue], tuple[Any, ...]] | None = None

    offsets: dict[str, int] = field(init=False, compare=False)
    slots: dict[str, int] = field(init=False, compare=False)
    size: int = field(init=False, compare=False)
    formed: int = field(init=False, compare=False)
    lagged: int = field(init=False, compare=False)
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
        object.__setattr__(self, "lagged", slot + 1)
        object.__setattr__(self, "rest", slot + 2)
        object.__setattr__(self, "n_states", slot + 3)

    def __reduce__(self) -> tuple[Callable[..., Catalogue], tuple[Any, ...]]:
        if self.made is None:
            raise TypeError("effects that come from no file cannot be sent to another process")
        return self.made

    @property
    def names(self) -> tuple[str, ...]:
        """Names of all effects."""
        return tuple(e.name for e in self.effects)

    def __repr__(self) -> str:
        return f"<catalogue of {len(self)} effects>"

    def __iter__(self) -> Iterator[Effect]:
        return iter(self.effects)

    def __len__(self) -> int:
        return len(self.effects)

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


CATALOGUE = Catalogue(
    tuple(import_module(f"er_models.catalogue.{name}").EFFECT for name in _LISTED),
    made=(shipped, ()),
)
