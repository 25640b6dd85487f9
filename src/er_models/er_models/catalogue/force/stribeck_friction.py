"""Stribeck friction: breakaway above the sliding level falls with velocity, as exp(-|v| / v_s) where s is 0 (Tustin).

Other laws differ in the shape s: exp(-(v / v_s)^2) at -1 (Gauss), 1 / (1 + (v / v_s)^2) at 1 (Hess and Soom).
"""

from math import exp, tanh

from er_models.effect import Effect, Param, Signature


def force(F_c: float, F_s: float, v_s: float, v_0: float, s: float, v: float) -> float:
    """Friction force [N]."""
    fall = (abs(v) / v_s) ** (1.0 + abs(s))
    above = (1.0 + s * fall) ** (-1.0 / s) if s > 1e-6 else exp(-fall)
    return (F_c + F_s * above) * tanh(v / v_0)


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
        Param("s", "1", -1.5, 1.5, 0.0, (0.5, -0.5), "shape of the fall", optional=True),
    ),
    hooks={"force": force},
    signature=Signature(
        mark="residual jumps with the sign of the velocity and peaks near zero velocity",
        plane="force-velocity",
        experiment="slow sine, most samples below three Stribeck velocities, zero duty",
        rivals=("coulomb_friction", "bouc_wen_hysteresis"),
        needs=("slow", "reversals", "fast_extension", "fast_compression"),
    ),
    source="Stribeck 1902; Hess and Soom 1990; Armstrong-Helouvry, Dupont and Canudas de Wit 1994, whose table 1 "
    "has the exponents",
    dissipative=True,
    within=(("F_s", 7.0, "F_c"),),
)
