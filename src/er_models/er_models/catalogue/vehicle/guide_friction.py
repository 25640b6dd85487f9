"""Friction of the wheel's guide: F_g tanh(v / v_0) between the masses, beside the damper."""

from math import tanh

from er_models.effect import Effect, Param, Signature


def spring_force(F_g: float, v_0: float, v: float) -> float:
    """Friction force between body and wheel [N]."""
    return F_g * tanh(v / v_0)


EFFECT = Effect(
    name="guide_friction",
    stage="vehicle",
    title="Friction of the wheel's guide",
    physics="The joints and bushings that guide the wheel on the body rub. The rig of the thesis is a "
    "whole car of one fifth on four road actuators: its body runs on no rail, so what rubs lies between "
    "the masses, in parallel with spring and damper. The load cell of the damper does not see it, the "
    "accelerometers do. (A rig whose body slides on a rail rubs against the ground instead, with the "
    "absolute velocity of the body.)",
    parameters=(
        Param("F_g", "N", 0.0, 2.0, 0.0, (0.05,), "sliding friction"),
        Param("v_0", "m/s", 0.002, 0.15, None, (0.02,), "width of the reversal"),
    ),
    hooks={"spring_force": spring_force},
    signature=Signature(
        mark="the body's acceleration jumps where the damper reverses; the measured damper force does not",
        plane="acceleration-velocity",
        experiment="small slow sine of the road at zero duty",
        rivals=("coulomb_friction", "spring_nonlinearity"),
    ),
    source="thesis section 1.3 (rig); Deubel and Prokop 2022, J. Vib. Control (friction of suspensions); "
    "Lozia and Zdanowicz 2016",
    dissipative=True,
)
