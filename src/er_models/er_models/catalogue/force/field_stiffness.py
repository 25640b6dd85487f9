"""Field-dependent stiffness: k_u u_f x, with the chains that have formed."""

from er_models.effect import Effect, Param, Signature


def force(k_u: float, u_f: float, x: float) -> float:
    """Extra elastic force under field [N]."""
    return k_u * u_f * x


EFFECT = Effect(
    name="field_stiffness",
    stage="force",
    title="Field-dependent stiffness",
    physics="Chains resist elastically before they yield: the damper stiffens under field, as slowly as "
    "they form: with the response time of the yield force.",
    parameters=(Param("k_u", "N/m/duty", -10.0, 20.0, 0.0, (0.2,), "stiffness per duty"),),
    hooks={"force": force},
    signature=Signature(
        mark="slope of force-deflection grows with the duty",
        plane="force-deflection",
        experiment="large slow sine at several duties",
        rivals=("field_viscosity", "gas_spring"),
    ),
    source="Choi and Han 2003; pre-yield modulus of the electrorheological fluid. Horvath and Szalai 2015: the "
    "structure of the chains, which carries the modulus, forms in the response time of the shear stress",
)
