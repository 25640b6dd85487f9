"""Friction that grows with the load: k_f |x - x_c| tanh(v / v_0)."""

from math import tanh

from er_models.effect import Effect, Param, Signature


def force(k_f: float, x_c: float, v_0: float, x: float, v: float) -> float:
    """Friction force [N]."""
    return k_f * abs(x - x_c) * tanh(v / v_0)


EFFECT = Effect(
    name="load_friction",
    stage="force",
    title="Friction that grows with the load",
    physics="The spring presses the surfaces together that rub: wedges of a friction damper, leaves of a spring, the "
    "guide of a strut under side load. The friction is in proportion to the spring's force, which vanishes at a "
    "deflection x_c; with a preload that lies beyond the stroke.",
    parameters=(
        Param("k_f", "N/m", 0.0, 5.0, 0.0, (0.1,), "friction per deflection"),
        Param("x_c", "m", -2.0, 2.0, None, (0.0, 1.0, -1.0), "deflection without load"),
        Param("v_0", "m/s", 0.002, 0.15, None, (0.02,), "width of the reversal"),
    ),
    hooks={"force": force},
    signature=Signature(
        mark="residual jumps with the sign of the velocity, higher the further the deflection from one place",
        plane="force-deflection",
        experiment="slow sines of small stroke about several deflections at zero duty",
        rivals=("coulomb_friction", "position_dependent_damping", "bouc_wen_hysteresis"),
        needs=("slow", "reversals", "far_extension", "far_compression"),
    ),
    source="Amontons 1699 (friction in proportion to the load); Deubel and Prokop 2022, J. Vib. Control (struts under "
    "side load); Fancher et al. 1980 (leaf springs)",
    dissipative=True,
)
