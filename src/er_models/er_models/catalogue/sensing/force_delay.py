"""Time offset of the force channel: F(t - d)."""

from er_models.effect import Effect, Param, Signature


def output_delay(d: float) -> float:
    """Delay of the measured force against the motion [s]."""
    return d


EFFECT = Effect(
    name="force_delay",
    stage="sensing",
    title="Time offset of the force channel",
    physics="Two data acquisition channels that do not share a clock: the force arrives late "
    "(or early).",
    parameters=(Param("d", "s", -0.1, 0.1, 0.0, (0.002,), "delay of the force"),),
    hooks={"output_delay": output_delay},
    signature=Signature(
        mark="residual follows the rate of the force",
        plane="time",
        experiment="fast sine",
        rivals=("force_lag", "fluid_inertia"),
        needs=("reversals",),
    ),
    source="model of the measurement chain; time-delay estimation, Knapp and Carter 1976",
)
