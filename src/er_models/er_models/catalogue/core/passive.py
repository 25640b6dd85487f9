"""Passive force: gas compliance and Newtonian viscosity, the linear part of (1.8) and (1.12)."""

from er_models.effect import Effect, Param, Signature


def force(
    k0: float, c0: float, x: float, v: float, stiffness_scale: float, viscous_scale: float
) -> float:
    """Passive force [N]."""
    return stiffness_scale * k0 * x + viscous_scale * c0 * v


EFFECT = Effect(
    name="passive",
    stage="core",
    title="Passive stiffness and viscosity",
    physics="The gas chamber acts as a spring, the fluid without field as a viscous damper.",
    parameters=(
        Param("k0", "N/m", -2.0, 20.0, 0.0, (0.1,), "effective stiffness of the gas chamber"),
        Param("c0", "N s/m", 0.0, 20.0, 0.0, (0.5,), "viscous damping without field"),
    ),
    hooks={"force": force},
    signature=Signature(
        mark="an ellipse in force-deflection, a line in force-velocity",
        plane="force-velocity",
        experiment="sine at zero duty",
    ),
    source="thesis (1.3), (1.13); Choi and Han 2003",
)
