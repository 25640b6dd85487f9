"""Response time that depends on the duty: tau (1 + g u + h u^2), the quadratic of (1.21)."""

from er_models.effect import Effect, Param, Signature


def tau_scale(g: float, h: float, u: float) -> float:
    """Factor on the response time [1]."""
    return max(1.0 + g * u + h * u * u, 0.02)


EFFECT = Effect(
    name="varying_time_constant",
    stage="actuation",
    title="Varying time constant",
    physics="Denser chains take longer to form: the response time grows with the duty.",
    parameters=(
        Param("g", "1/duty", -1.0, 50.0, 0.0, (1.0,), "relative growth of tau per duty at duty 0"),
        Param("h", "1/duty2", -10.0, 50.0, 0.0, (1.0,), "the same per square of the duty"),
    ),
    hooks={"tau_scale": tau_scale},
    signature=Signature(
        mark="lag of the force after steps grows with the height of the step",
        plane="time",
        experiment="square waves of duty of different height",
        rivals=("rise_fall_asymmetry", "amplifier_lag"),
        needs=("duty_rises", "duty_falls", "duty_levels"),
    ),
    source="thesis (1.21), Table 1.4",
)
