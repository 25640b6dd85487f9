"""Post-yield flow under field after Herschel and Bulkley: c_h u sgn(v) |v / v_r|^n."""

from math import copysign

from er_models.effect import Effect, Param, Signature


def force(c_h: float, n: float, v_r: float, u: float, v: float) -> float:
    """Extra force under field at the velocity v [N]."""
    return copysign(c_h * u * (abs(v) / v_r) ** n, v)


EFFECT = Effect(
    name="herschel_bulkley",
    stage="force",
    title="Shear thinning under field (Herschel-Bulkley)",
    physics="Once the chains have yielded the fluid under field still resists more the faster it flows, "
    "but less than in proportion.",
    parameters=(
        Param("c_h", "N/duty", 0.0, 5.0, 0.0, (0.1,), "force per duty at the reference velocity"),
        Param("n", "1", 0.1, 1.5, None, (0.5,), "flow index"),
        Param("v_r", "m/s", 0.01, 10.0, None, (1.0,), "reference velocity", fitted=False),
    ),
    hooks={"force": force},
    signature=Signature(
        mark="slope of force-velocity after yield falls with velocity and grows with the duty",
        plane="force-velocity",
        experiment="large sine at several duties",
        rivals=("field_viscosity", "shear_thinning"),
    ),
    source="Herschel and Bulkley 1926; Lee and Wereley 1999, Herschel-Bulkley dampers under field",
    dissipative=True,
    generalises=("field_viscosity",),
)
