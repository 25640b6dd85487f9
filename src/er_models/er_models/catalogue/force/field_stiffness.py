"""Field-dependent stiffness: k_u u_f x, with the chains that have formed; far out no more than k_u u_f / b_u."""

from math import sqrt

from er_models.effect import Effect, Param, Signature


def force(k_u: float, b_u: float, u_f: float, x: float) -> float:
    """Extra elastic force under field [N]."""
    return k_u * u_f * x / sqrt(1.0 + (b_u * x) ** 2)


EFFECT = Effect(
    name="field_stiffness",
    stage="force",
    title="Field-dependent stiffness",
    physics="Chains resist elastically before they yield: the damper stiffens under field, as slowly as "
    "they form: with the response time of the yield force. Stretched far they break, and the force levels off.",
    parameters=(
        Param("k_u", "N/m/duty", -10.0, 20.0, 0.0, (0.2,), "stiffness per duty"),
        Param("b_u", "1/m", 0.0, 5.0, 0.0, (0.5,), "one over where it levels off", optional=True),
    ),
    hooks={"force": force},
    signature=Signature(
        mark="slope of force-deflection grows with the duty",
        plane="force-deflection",
        experiment="large slow sine at several duties",
        rivals=("field_viscosity", "gas_spring"),
    ),
    source="Choi and Han 2003; pre-yield modulus of the electrorheological fluid. Horvath and Szalai 2015: the "
    "structure of the chains, which carries the modulus, forms in the response time of the shear stress. Parthasarathy "
    "and Klingenberg 1996: the modulus falls with the strain",
)
