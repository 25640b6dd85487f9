"""Error of the sprung mass: m_s (1 + e)."""

from er_models.effect import Effect, Param, Signature


def sprung_mass(e: float, m_s: float) -> float:
    """Mass that the model does not know of [kg]."""
    return e * m_s


EFFECT = Effect(
    name="sprung_mass_error",
    stage="vehicle",
    title="Error of the sprung mass",
    physics="Load, fuel or people: the body is heavier or lighter than the model says. It rides at the "
    "same height here, because deflections count from rest.",
    parameters=(Param("e", "1", -0.5, 2.0, 0.0, (0.2,), "added mass over the known sprung mass"),),
    hooks={"sprung_mass": sprung_mass},
    signature=Signature(
        mark="the body's acceleration is out of scale with the forces of spring and damper",
        plane="frequency",
        experiment="sweep of the road through the resonance of the body",
        rivals=("spring_nonlinearity", "accelerometer_bias"),
    ),
    source="thesis (2.1); Rozyn and Zhang 2010 (estimation of the sprung mass)",
)
