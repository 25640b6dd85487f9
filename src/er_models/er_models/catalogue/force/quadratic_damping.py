"""Orifice damping: c_2 v |v|."""

from er_models.effect import Effect, Param, Signature


def force(c_2: float, v: float) -> float:
    """Turbulent orifice force [N]."""
    return c_2 * v * abs(v)


EFFECT = Effect(
    name="quadratic_damping",
    stage="force",
    title="Quadratic (orifice) damping",
    physics="Turbulent flow through an orifice costs pressure in proportion to the square of "
    "the flow.",
    parameters=(Param("c_2", "N s2/m2", 0.0, 10.0, 0.0, (0.1,), "orifice coefficient"),),
    hooks={"force": force},
    signature=Signature(
        mark="residual grows as the square of the velocity, odd in direction",
        plane="force-velocity",
        experiment="fast large sine at zero duty",
        rivals=("shear_thinning", "field_viscosity"),
    ),
    source="Bernoulli orifice law; Dixon 2007, ch. 5",
    dissipative=True,
    fluid=True,
)
