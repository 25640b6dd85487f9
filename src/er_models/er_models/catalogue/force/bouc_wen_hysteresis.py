"""Pre-sliding hysteresis: a bristle z that is a spring up to e z_y and slides beyond.

With e = 0 it is Dahl's, and Bouc-Wen's with n = 1: z' = v - |v| z / z_y. A larger n slides later and all at once, as a
larger e does; with e = 1 it is a spring with a slider (Jenkins; Masing).
"""

from er_models.effect import CONTACT, Effect, Param, Signature

FORGETS = 1e-12
"""Share of the deflection that a spring without a slider forgets: so little that what moves on for ever slides."""


def relax(z_y: float, v: float) -> tuple[float, float]:
    """Rate [1/s] and drive [m/s] of the elastic deflection of the contact."""
    return FORGETS * abs(v) / z_y, v


def bound(z_y: float, e: float) -> float:
    """Deflection from which it slides [m]."""
    return e * z_y


def give(z_y: float, e: float, v: float) -> float:
    """Rate at which it slides beyond [1/s]."""
    return abs(v) / ((1.0 - e) * z_y)


def force(F_h: float, F_u: float, z_y: float, u_f: float, w: float) -> float:
    """Hysteretic force [N]."""
    return (F_h + F_u * u_f) * w / z_y


ELASTIC = Param(
    "e", "1", 0.0, 0.98, 0.0, (0.0,), "elastic share of the deflection before it slides", step=CONTACT, optional=True
)  # fmt: skip
"""None is Dahl's bristle, which slides from the first instant on; all is a spring with a slider (Jenkins, Masing)."""

EFFECT = Effect(
    name="bouc_wen_hysteresis",
    stage="force",
    title="Pre-sliding hysteresis (Dahl, Bouc-Wen)",
    physics="Before seals slide, or chains yield, they bend elastically: the force follows "
    "the path, not the velocity. What the chains add follows the field with the response time of the yield force.",
    parameters=(
        Param("F_h", "N", 0.0, 3.0, 0.0, (0.1,), "level without field"),
        Param("F_u", "N/duty", -3.0, 10.0, 0.0, (0.0, 0.3), "level per duty"),
        Param("z_y", "m", 0.002, 1.0, None, (0.05, 0.2), "elastic deflection", step=CONTACT),
        ELASTIC,
    ),
    hooks={"relax": relax, "bound": bound, "give": give, "force": force},
    signature=Signature(
        mark="residual loops in force-deflection that do not shrink with frequency",
        plane="force-deflection",
        experiment="small sine, a few times the elastic deflection",
        rivals=("coulomb_friction", "stribeck_friction", "viscoelastic_branch"),
        needs=("slow", "reversals"),
    ),
    source="Dahl 1968; Bouc 1967; Wen 1976; Spencer et al. 1997; Jenkins 1962",
)
