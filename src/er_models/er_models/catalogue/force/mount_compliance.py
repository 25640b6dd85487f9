"""Mount compliance: a spring 1 / q in series with the damper.

Its balance holds the passive and the yield force; what other effects add passes the mount without stretching it.
"""

from er_models.effect import INSTANT, LEAST_COMPLIANCE, LEAST_TIME, Effect, Param, Signature


def relax(q: float, k_0: float, c_0: float, x: float, v: float, f_y: float) -> tuple[float, float]:
    """Rate [1/s] and drive [m/s] of the stretch of the mount, from the balance of forces in series."""
    damping = max(c_0, LEAST_TIME / max(q, LEAST_COMPLIANCE))
    return (
        ((1.0 / q + k_0) / damping, v + (k_0 * x + f_y) / damping) if q > 0.0 else (INSTANT, 0.0)
    )


def shift_deflection(x: float, w: float) -> float:
    """Deflection of the damper itself [m]."""
    return x - w


def shift_velocity(
    q: float, k_0: float, c_0: float, x: float, v: float, f_y: float, w: float
) -> float:
    """Velocity of the damper itself [m/s]; x is its own deflection."""
    damping = max(c_0, LEAST_TIME / max(q, LEAST_COMPLIANCE))
    return (w / q - k_0 * x - f_y) / damping if q > 0.0 else v


EFFECT = Effect(
    name="mount_compliance",
    stage="force",
    title="Mount (bushing) compliance",
    physics="Rubber mounts are a spring in series: at first a fast motion stretches the mount "
    "instead of the damper.",
    parameters=(Param("q", "m/N", 0.0, 2.0, 0.0, (0.02, 0.1), "compliance of the mount"),),
    hooks={"relax": relax, "shift_deflection": shift_deflection, "shift_velocity": shift_velocity},
    signature=Signature(
        mark="force lags the velocity, more where the damper is hard",
        plane="force-velocity",
        experiment="fast sine at several duties",
        rivals=("freeplay", "velocity_lag", "viscoelastic_branch", "force_lag"),
        needs=("reversals", "high_duty"),
    ),
    source="Dixon 2007, ch. 4; Duym 2000",
)
