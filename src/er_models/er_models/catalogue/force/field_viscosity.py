"""Field-dependent viscosity: c_u u_f v, with the chains that have formed."""

from er_models.effect import Effect, Param, Signature


def force(c_u: float, u_f: float, v: float) -> float:
    """Extra viscous force under field [N]."""
    return c_u * u_f * v


EFFECT = Effect(
    name="field_viscosity",
    stage="force",
    title="Field-dependent viscosity",
    physics="The chains thicken the fluid: its plastic viscosity grows with the field, as slowly as they "
    "form: with the response time of the yield force.",
    parameters=(Param("c_u", "N s/m/duty", -2.0, 20.0, 0.0, (0.2,), "damping per duty"),),
    hooks={"force": force},
    signature=Signature(
        mark="slope of force-velocity after yield grows with the duty",
        plane="force-velocity",
        experiment="large sine with a square wave of duty",
        rivals=("quadratic_damping", "field_stiffness"),
    ),
    source="Bingham plastic viscosity under field; Choi et al. 1998. Spencer et al. 1997: yield force and viscous "
    "damping both grow with one first-order lag of the command; Horvath and Szalai 2015: the structure of the chains "
    "forms in the response time of the shear stress",
    fluid=True,
)
