"""Viscoelastic (Maxwell) branch: F_m' = k_m v - F_m / t_m."""

from er_models.effect import Effect, Param, Signature


def relax(k_m: float, t_m: float, v: float) -> tuple[float, float]:
    """Rate [1/s] and drive [N/s] of the force in the branch."""
    return 1.0 / t_m, k_m * v


def force(w: float) -> float:
    """Force in the branch [N]."""
    return w


EFFECT = Effect(
    name="viscoelastic_branch",
    stage="force",
    title="Viscoelastic branch (Maxwell)",
    physics="Compressible fluid and rubber act as a spring in series with a damper: stiff "
    "when fast, soft when slow.",
    parameters=(
        Param("k_m", "N/m", 0.0, 10.0, 0.0, (0.3,), "stiffness of the branch"),
        Param("t_m", "s", 0.002, 1.0, None, (0.02, 0.1), "relaxation time"),
    ),
    hooks={"relax": relax, "force": force},
    signature=Signature(
        mark="residual loops that open with frequency",
        plane="force-deflection",
        experiment="sweep of constant velocity at zero duty",
        rivals=("bouc_wen_hysteresis", "mount_compliance", "fluid_inertia"),
        needs=("slow", "reversals"),
    ),
    source="Maxwell body; Zener 1948; Spencer et al. 1997",
)
