"""Field-dependent viscosity: c_u u v."""

from er_models.effect import Effect, Param, Signature


def force(c_u: float, u: float, v: float) -> float:
    """Extra viscous force under field [N]."""
    return c_u * u * v


EFFECT = Effect(
    name="field_viscosity",
    stage="force",
    title="Field-dependent viscosity",
    physics="The chains thicken the fluid: its plastic viscosity grows with the field.",
    parameters=(Param("c_u", "N s/m/duty", -2.0, 20.0, 0.0, (0.2,), "damping per duty"),),
    hooks={"force": force},
    signature=Signature(
        mark="slope of force-velocity after yield grows with the duty",
        plane="force-velocity",
        experiment="large sine with a square wave of duty",
        rivals=("quadratic_damping", "field_stiffness"),
    ),
    source="Bingham plastic viscosity under field; Choi et al. 1998",
)
