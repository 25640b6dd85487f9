"""Thinning over the measured temperature: exp(-b theta) for viscosity and yield force."""

from math import exp

from er_models.effect import Effect, Param, Signature


def viscous_scale(b_v: float, theta: float) -> float:
    """Factor on the viscosity [1]."""
    return exp(-b_v * theta)


def yield_scale(b_y: float, theta: float) -> float:
    """Factor on the yield force [1]."""
    return exp(-b_y * theta)


EFFECT = Effect(
    name="temperature_thinning",
    stage="heat",
    title="Thinning over the measured temperature",
    physics="Warm fluid is thinner, and its chains yield earlier or later. Where a temperature is recorded the force "
    "follows it, whatever warms the damper: its own work, the sun or an oven.",
    parameters=(
        Param("b_v", "1/K", -0.1, 0.2, 0.0, (0.01,), "loss of viscosity per kelvin"),
        Param("b_y", "1/K", -0.1, 0.2, 0.0, (0.01, -0.005), "loss of yield force per kelvin"),
    ),
    hooks={"viscous_scale": viscous_scale, "yield_scale": yield_scale},
    signature=Signature(
        mark="damping and yield force follow the measured temperature",
        plane="force-velocity",
        experiment="the same sine cold and warm, several duties, the temperature recorded",
        rivals=("self_heating", "effectiveness_fade", "force_fade"),
        needs=("warming",),
    ),
    source="Reynolds 1886 (exponential law of viscosity); Batterbee and Sims 2009 (temperature of MR dampers)",
)
