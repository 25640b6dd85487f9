"""Which names of the catalogue are right for what is hidden: the one place where names are added.

A truth whose names are all unknown to the catalogue lies outside it: right is then that something unknown remains.
"""

from __future__ import annotations

RIGHT: dict[str, tuple[str, ...]] = {
    "coulomb": ("coulomb_friction",),
    "stribeck": ("stribeck_friction",),
    "dahl": ("bouc_wen_hysteresis",),
    "dahl_field": ("bouc_wen_hysteresis", "field_friction"),
    "direction": ("directional_friction", "preload"),
    "loaded": ("load_friction",),
    "orifice": ("quadratic_damping",),
    "check": ("asymmetric_damping",),
    "knee": ("blow_off_valve",),
    "thin": ("shear_thinning",),
    "taper": ("position_dependent_damping",),
    "stop": ("end_stop",),
    "gas": ("gas_spring",),
    "offset": ("preload",),
    "maxwell": ("viscoelastic_branch",),
    "mount": ("mount_compliance",),
    "play": ("freeplay",),
    "brake_play": ("friction_with_play",),
    "inertia": ("fluid_inertia",),
    "void": ("cavitation",),
    "thicken": ("field_viscosity",),
    "stiffen": ("field_stiffness",),
    # bent down it is a saturation in the first order
    "mixed": ("field_exponent", "field_saturation"),
    "saturate": ("field_saturation",),
    "late": ("dead_time",),
    "amplifier": ("amplifier_lag",),
    "threshold": ("duty_dead_band",),
    "switching": ("rise_fall_asymmetry",),
    "slowing": ("varying_time_constant",),
    "remanent": ("remanence",),
    "pressed": ("field_preload",),
    "heat": ("self_heating",),
    "fade": ("effectiveness_fade",),
    "wear": ("force_fade",),
    "cogging": (),
    "zero": ("deflection_zero", "preload"),
    "force_late": ("force_delay",),
    "force_slow": ("force_lag",),
}
"""Truth -> names, each of which is right."""

BESIDE: dict[str, tuple[str, ...]] = {
    "direction": ("coulomb_friction",),  # friction and an offset are the same two levels
    "knee": ("asymmetric_damping",),  # its two sides differ
    "brake_play": ("freeplay", "bouc_wen_hysteresis"),  # what it is made of
}
"""Names that are true of the same damper, but alone not the answer: never wrong."""
