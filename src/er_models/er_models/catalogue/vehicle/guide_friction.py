"""Friction of the wheel's guide between the masses, beside the damper: F_g tanh(v / v_0) where r is 0.

Bushings and ball joints give before they slide, and the friction rises slowly: F_g (2 / pi) arctan(v / v_0) at 1.
"""

from math import atan, pi, tanh

from er_models.effect import Effect, Param, Signature


def spring_force(F_g: float, v_0: float, r: float, v: float) -> float:
    """Friction force between body and wheel [N]."""
    sharp = tanh(v / v_0)
    slow = r * (2.0 / pi * atan(v / v_0) - sharp) if r != 0.0 else 0.0
    return F_g * (sharp + slow)


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
        Param("r", "1", 0.0, 1.0, 0.0, (0.5,), "how slowly it rises", optional=True),
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
