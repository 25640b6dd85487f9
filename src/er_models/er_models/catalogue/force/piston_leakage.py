"""Leakage across the piston: beside what the fluid carries a bleed passes v_l sqrt(F / F_r).

The force F drives the flow of both ways, v = v_l sqrt(F / F_r) + v F / f_h, where f_h is what the fluid would carry
without the bleed.
"""

from math import sqrt

from er_models.effect import LEAST_COMPLIANCE, Effect, Param, Signature


def limit(v_l: float, F_r: float, v: float, f_h: float, f_d: float) -> float:
    """Force [N] with the bleed open: next to no velocity needs next to no force."""
    bleed = v_l / sqrt(F_r) + LEAST_COMPLIANCE
    size = max(abs(f_h), LEAST_COMPLIANCE)
    root = 2.0 * abs(v) / (bleed + sqrt(bleed * bleed + 4.0 * v * v / size))
    return f_d + (root * root / size - 1.0) * f_h if v_l > 0.0 else f_d


EFFECT = Effect(
    name="piston_leakage",
    stage="force",
    title="Leakage across the piston (bleed)",
    physics="Fluid passes the piston beside valve and field: a bleed orifice, a gap at the ring, a bypass. At low "
    "velocity all of it goes there and the force grows with the square of the velocity; the faster the stroke, the "
    "less the bleed takes away. The yield force no longer stands at creeping velocity.",
    parameters=(
        Param("v_l", "m/s", 0.0, 1.0, 0.0, (0.05, 0.2), "velocity that the bleed passes at F_r"),
        Param("F_r", "N", 0.5, 2.0, None, (1.0,), "force at which it does", fitted=False),
    ),
    hooks={"limit": limit},
    dissipative=True,
    signature=Signature(
        mark="force is missing at low velocity, a parabola in place of the yield force's step",
        plane="force-velocity",
        experiment="slow sines of large stroke at several duties",
        rivals=("shear_thinning", "cavitation", "freeplay", "quadratic_damping"),
        needs=("slow", "fast_extension", "fast_compression"),
    ),
    source="Dixon 2007, The Shock Absorber Handbook, ch. 6 (bleed orifice beside the valve); Bitman, Choi and Wereley "
    "2005 (leakage in field-controlled dampers)",
)
