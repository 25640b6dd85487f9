"""Zero of the deflection sensor: x + x_0."""

from er_models.effect import Effect, Param, Signature


def shift_deflection(x_0: float, x: float) -> float:
    """Deflection from the true middle [m]."""
    return x + x_0


EFFECT = Effect(
    name="deflection_zero",
    stage="sensing",
    title="Zero of the deflection sensor",
    physics="The sensor's zero is not the middle of the damper.",
    parameters=(Param("x_0", "m", -2.0, 2.0, 0.0, (0.05, -0.05), "offset to add"),),
    hooks={"shift_deflection": shift_deflection},
    signature=Signature(
        mark="yield forces lean: reversal happens earlier in one direction",
        plane="force-velocity",
        experiment="small sine about several mean deflections",
        rivals=("preload", "gas_spring"),
        needs=("slow", "high_duty"),
    ),
    source="model of the measurement chain",
)
