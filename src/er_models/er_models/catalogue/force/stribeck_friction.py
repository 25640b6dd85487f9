"""Stribeck friction: (F_c + F_s exp(-|v| / v_s)) tanh(v / v_0), breakaway above the sliding level."""

from math import exp, tanh

from er_models.effect import Effect, Param, Signature


def force(F_c: float, F_s: float, v_s: float, v_0: float, v: float) -> float:
    """Friction force [N]."""
    return (F_c + F_s * exp(-abs(v) / v_s)) * tanh(v / v_0)


EFFECT = Effect(
    name="stribeck_friction",
    stage="force",
    title="Stribeck friction",
    physics="At low velocity the seal sticks harder than it slides: friction falls with "
    "velocity before viscosity takes over.",
    parameters=(
        Param("F_c", "N", 0.0, 2.0, 0.0, (0.02,), "sliding friction"),
        Param("F_s", "N", 0.0, 2.0, 0.0, (0.08,), "breakaway above sliding"),
        Param("v_s", "m/s", 0.01, 0.4, None, (0.08,), "Stribeck velocity"),
        Param("v_0", "m/s", 0.002, 0.15, None, (0.02,), "width of the reversal"),
    ),
    hooks={"force": force},
    signature=Signature(
        mark="residual jumps with the sign of the velocity and peaks near zero velocity",
        plane="force-velocity",
        experiment="slow sine, most samples below three Stribeck velocities, zero duty",
        rivals=("coulomb_friction", "bouc_wen_hysteresis"),
        needs=("slow", "reversals", "fast_extension", "fast_compression"),
    ),
    source="Stribeck 1902; Armstrong-Helouvry, Dupont and Canudas de Wit 1994",
    dissipative=True,
)
