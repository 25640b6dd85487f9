"""Response time that is a quadratic in the duty (1.21): tau_0 + tau_1 u + tau_2 u^2."""

from er_models.effect import Effect, Param, Signature


def response_time(tau_0: float, tau_1: float, tau_2: float, u: float) -> float:
    """Response time at this duty [s]."""
    return max(tau_0 + tau_1 * u + tau_2 * u * u, 0.0)


EFFECT = Effect(
    name="response_quadratic",
    stage="core",
    title="Response time, quadratic in the duty",
    physics="Denser chains take longer to form. Takes the place of the constant response time; the lag "
    "itself is that of `response`.",
    parameters=(
        Param("tau_0", "s", 0.0, 1.0, 0.0, (0.005, 0.03), "response time at duty 0"),
        Param("tau_1", "s/duty", -1.0, 1.0, 0.0, (0.03, 0.0), "its growth per duty at duty 0"),
        Param(
            "tau_2", "s/duty2", -1.0, 1.0, 0.0, (0.03, 0.0), "its growth per square of the duty"
        ),
    ),
    hooks={"response_time": response_time},
    signature=Signature(
        mark="the lag of the force grows with the duty, faster at large duty",
        plane="time",
        experiment="large slow sine with square waves of duty of different height",
        rivals=("varying_time_constant", "response_table"),
    ),
    source="thesis (1.21), a fit of Table 1.4 from which it departs by up to 5.4 ms",
)
