"""Lag of the velocity channel: the true velocity is v + T_v a."""

from er_models.effect import Effect, Param, Signature


def shift_velocity(T_v: float, v: float, a: float) -> float:
    """Velocity before the filter [m/s]."""
    return v + T_v * a


EFFECT = Effect(
    name="velocity_lag",
    stage="sensing",
    title="Lag of the velocity channel",
    physics="A velocity made by differentiation and filtering lags the true one; deflection "
    "and accelerometers expose it.",
    parameters=(Param("T_v", "s", -0.02, 0.05, 0.0, (0.003,), "time constant of the filter"),),
    hooks={"shift_velocity": shift_velocity},
    signature=Signature(
        mark="force reverses before the measured velocity does",
        plane="force-velocity",
        experiment="fast sine",
        rivals=("mount_compliance", "force_delay"),
        needs=("reversals",),
    ),
    source="first-order differentiating filter",
)
