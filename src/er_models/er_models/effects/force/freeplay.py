"""Freeplay: the joint carries no force within a gap of +-b (play operator, smooth)."""

from er_models.effect import Effect, Param, Signature


def relax(b: float, v: float, w: float) -> tuple[float, float]:
    """Rate [1/s] and drive [m/s] of the position in the gap: w' = v inside, 0 at its outer edge."""
    outward = (abs(w) / b) ** 7 if b > 0.0 and v * w > 0.0 else 0.0
    return (outward * abs(v) / b, v) if b > 0.0 else (1e9, 0.0)


def shift_deflection(x: float, w: float) -> float:
    """Deflection of the damper itself [m]."""
    return x - w


def shift_velocity(b: float, v: float, w: float) -> float:
    """Velocity of the damper itself [m/s], v - w': it stands still while the gap is crossed."""
    engaged = min(abs(w) / b, 1.0) ** 8 if b > 0.0 and v * w > 0.0 else 0.0
    return v * engaged if b > 0.0 else v


def limit(b: float, v: float, w: float, f_d: float) -> float:
    """Force that the joint carries [N]; the damper's velocity v has the sign of the joint's."""
    engaged = min(abs(w) / b, 1.0) ** 8 if b > 0.0 and v * w > 0.0 else 0.0
    return f_d * engaged if b > 0.0 else f_d


EFFECT = Effect(
    name="freeplay",
    stage="force",
    title="Freeplay (backlash)",
    physics="A worn joint must first cross its gap at every reversal before the damper works.",
    parameters=(
        Param("b", "m", 0.0, 0.3, 0.0, (0.01, 0.03), "half the gap"),
    ),
    hooks={
        "relax": relax,
        "shift_deflection": shift_deflection,
        "shift_velocity": shift_velocity,
        "limit": limit,
    },
    signature=Signature(
        mark="force stays near zero after each reversal for a fixed distance",
        plane="force-deflection",
        experiment="slow sine of small stroke at constant duty",
        rivals=("mount_compliance", "bouc_wen_hysteresis"),
    ),
    source="Nordin and Gutman 2002, backlash survey",
)
