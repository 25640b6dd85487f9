"""Deformation of the duct f_3: viscosity and yield force keep the share f, the gas its stiffness."""

from er_models.effect import Effect, Signature
from er_models.fault_profile import PARAMETERS, left

EFFECT = Effect(
    name="duct_deformation",
    stage="fault",
    title="Deformation of the duct (f3)",
    physics="High pressure deforms the spirals of the annular duct: a shorter path, so less viscous and less "
    "controllable force. The gas is not affected. The yield force follows with the response time of the fluid.",
    parameters=PARAMETERS,
    hooks={"viscous_scale": left, "yield_scale": left},
    signature=Signature(
        mark="damping and yield force shrink by one factor from some instant on, the stiffness does not",
        plane="time",
        experiment="a known duty before and after the fault, and a slow motion without field",
        rivals=("self_heating",),
    ),
    source="thesis 6.2.3, (6.8)",
)
