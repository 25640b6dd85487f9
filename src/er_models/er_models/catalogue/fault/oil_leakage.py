"""Oil leakage f_2: stiffness, viscosity and yield force keep the share f."""

from er_models.effect import Effect, Signature
from er_models.fault_profile import PARAMETERS, left

EFFECT = Effect(
    name="oil_leakage",
    stage="fault",
    title="Oil leakage (f2)",
    physics="Fluid is missing in the chamber: gas spring, viscosity and yield stress act on less of it, so the "
    "whole force shrinks by one factor. The yield force follows with the response time of the fluid.",
    parameters=PARAMETERS,
    hooks={"stiffness_scale": left, "viscous_scale": left, "yield_scale": left},
    signature=Signature(
        mark="the whole force shrinks by one factor from some instant on, with and without field",
        plane="time",
        experiment="a known duty before and after the fault",
        rivals=("force_gain",),
    ),
    source="thesis (6.4); Hernandez-Alcantara et al. 2016",
)
