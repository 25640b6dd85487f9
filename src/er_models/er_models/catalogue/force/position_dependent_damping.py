"""Position-dependent damping: c_x x^2 v, towards the ends of the stroke no more than c_x v / b_x^2."""

from er_models.effect import Effect, Param, Signature


def force(c_x: float, b_x: float, x: float, v: float) -> float:
    """Extra damping away from the middle of the stroke [N]."""
    return c_x * x * x * v / (1.0 + (b_x * x) ** 2)


EFFECT = Effect(
    name="position_dependent_damping",
    stage="force",
    title="Position-dependent damping",
    physics="A tapered metering pin or bypass groove makes the damper harder (or softer) "
    "towards the ends of the stroke.",
    parameters=(
        Param("c_x", "N s/m3", -5.0, 20.0, 0.0, (0.2,), "damping per squared deflection"),
        Param("b_x", "1/m", 0.0, 5.0, 0.0, (0.5,), "one over where it levels off", optional=True),
    ),
    hooks={"force": force},
    signature=Signature(
        mark="residual grows with velocity only away from the middle of the stroke",
        plane="force-deflection",
        experiment="two sines of equal velocity and different stroke",
        rivals=("gas_spring", "field_viscosity"),
        needs=("far_extension", "far_compression", "fast_extension", "fast_compression"),
    ),
    source="Lee and Moon 2006, displacement-sensitive shock absorber; Dixon 2007",
    fluid=True,
)
