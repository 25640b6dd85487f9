"""Pre-sliding hysteresis (Dahl; Bouc-Wen with n = 1): z' = v - |v| z / z_y."""

from er_models.effect import Effect, Param, Signature


def relax(z_y: float, v: float) -> tuple[float, float]:
    """Rate [1/s] and drive [m/s] of the elastic deflection z of the contact."""
    return abs(v) / z_y, v


def force(F_h: float, F_u: float, z_y: float, u_f: float, w: float) -> float:
    """Hysteretic force [N]."""
    return (F_h + F_u * u_f) * w / z_y


EFFECT = Effect(
    name="bouc_wen_hysteresis",
    stage="force",
    title="Pre-sliding hysteresis (Dahl, Bouc-Wen)",
    physics="Before seals slide, or chains yield, they bend elastically: the force follows "
    "the path, not the velocity. What the chains add follows the field with the response time of the yield force.",
    parameters=(
        Param("F_h", "N", 0.0, 3.0, 0.0, (0.1,), "level without field"),
        Param("F_u", "N/duty", -3.0, 10.0, 0.0, (0.0, 0.3), "level per duty"),
        Param("z_y", "m", 0.002, 1.0, None, (0.05, 0.2), "elastic deflection"),
    ),
    hooks={"relax": relax, "force": force},
    signature=Signature(
        mark="residual loops in force-deflection that do not shrink with frequency",
        plane="force-deflection",
        experiment="small sine, a few times the elastic deflection",
        rivals=("coulomb_friction", "stribeck_friction", "viscoelastic_branch"),
        needs=("slow", "reversals"),
    ),
    source="Dahl 1968; Bouc 1967; Wen 1976; Spencer et al. 1997",
)
