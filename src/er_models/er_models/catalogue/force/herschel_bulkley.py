"""Post-yield flow under field after Herschel and Bulkley: c_h u sgn(v) |v / v_r|^n, smooth at rest."""

from er_models.effect import Effect, Param, Signature


def target(c_h: float, n: float, v_0: float, v_r: float, u: float, v: float) -> float:
    """Extra yield force that the field asks for at the velocity v [N]."""
    return float(c_h * u * (v / v_r) * ((v * v + v_0 * v_0) / (v_r * v_r)) ** (0.5 * (n - 1.0)))


EFFECT = Effect(
    name="herschel_bulkley",
    stage="force",
    title="Shear thinning under field (Herschel-Bulkley)",
    physics="Once the chains have yielded the fluid under field still resists more the faster it flows, "
    "but less than in proportion.",
    parameters=(
        Param("c_h", "N/duty", 0.0, 5.0, 0.0, (0.1,), "force per duty at the reference velocity"),
        Param("n", "1", 0.1, 1.5, None, (0.5,), "flow index"),
        Param("v_0", "m/s", 1e-4, 0.1, None, (0.01,), "width of the smooth sign", fitted=False),
        Param("v_r", "m/s", 0.01, 10.0, None, (1.0,), "reference velocity", fitted=False),
    ),
    hooks={"target": target},
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
