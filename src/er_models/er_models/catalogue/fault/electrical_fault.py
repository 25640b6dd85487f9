"""Electrical fault f_1: the field keeps the share f of its yield force."""

from er_models.effect import Effect, Signature
from er_models.fault_profile import PARAMETERS, left

EFFECT = Effect(
    name="electrical_fault",
    stage="fault",
    title="Electrical fault (f1)",
    physics="The amplifier or its wiring gives less than the duty asks for: the field loses part of its "
    "effect, stiffness and viscosity stay. The loss reaches the force with the response time of the fluid.",
    parameters=PARAMETERS,
    hooks={"yield_scale": left},
    signature=Signature(
        mark="yield force shrinks at equal duty from some instant on, the passive force does not",
        plane="time",
        experiment="a known duty before and after the fault",
        rivals=("duty_gain", "effectiveness_fade"),
    ),
    source="thesis (6.2); Morato, Sename and Dugard 2019",
)
