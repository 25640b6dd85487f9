"""Fluid inertia: m_f a."""

from er_models.effect import Effect, Param, Signature


def force(m_f: float, a: float) -> float:
    """Inertia force [N]."""
    return m_f * a


EFFECT = Effect(
    name="fluid_inertia",
    stage="force",
    title="Inertia of fluid and piston",
    physics="The oil in the gap moves much faster than the piston: it acts as an added mass "
    "(inertance).",
    parameters=(Param("m_f", "kg", 0.0, 10.0, 0.0, (0.05,), "inertance"),),
    hooks={"force": force},
    signature=Signature(
        mark="residual follows the acceleration, grows with the square of frequency",
        plane="force-acceleration",
        experiment="fast small sine or sweep at zero duty",
        rivals=("force_delay", "force_lag", "viscoelastic_branch"),
        needs=("reversals", "low_duty"),
    ),
    source="Smith 2002 (inertance); Dixon 2007",
)
