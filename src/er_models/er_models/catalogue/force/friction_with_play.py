"""Elastic friction with play in series: a bristle z behind a play of +-b, which slides as in `bouc_wen_hysteresis`.

The state w is the bristle and the play together: within +-b it moves with the damper and carries nothing.
"""

from er_models.catalogue.force.bouc_wen_hysteresis import ELASTIC, give
from er_models.effect import CONTACT, Effect, Param, Signature


def relax(v: float) -> tuple[float, float]:
    """Rate [1/s] and drive [m/s] of the way through the play."""
    return 0.0, v


def bound(b: float, z_y: float, e: float) -> float:
    """Position from which the bristle behind the play slides [m]."""
    return b + e * z_y


def force(F_h: float, F_u: float, z_y: float, b: float, g: float, u_f: float, w: float) -> float:
    """Friction force of the bent bristle [N]."""
    bent = (1.0 + g) * max(w - b, 0.0) + (1.0 - g) * min(w + b, 0.0)
    return (F_h + F_u * u_f) * bent / z_y


EFFECT = Effect(
    name="friction_with_play",
    stage="force",
    title="Elastic friction with play in series",
    physics="The pads of a friction brake, or a loose seal in its groove, first cross their play with the motion. Then "
    "they bend elastically, and slide. After a reversal the force falls, stays near zero for the play and builds up "
    "on the other side, whatever the velocity. The level may grow with the duty. A band or a shoe that winds itself on "
    "grips harder one way: with 1 + g in extension and 1 - g in compression.",
    parameters=(
        Param("F_h", "N", 0.0, 3.0, 0.0, (0.2,), "level without field"),
        Param("F_u", "N/duty", -3.0, 10.0, 0.0, (0.0, 0.2), "level per duty"),
        Param("z_y", "m", 0.002, 1.0, None, (0.03, 0.12), "elastic deflection", step=CONTACT),
        ELASTIC,
        Param("b", "m", 0.0, 0.5, None, (0.03, 0.12), "half the play", step=CONTACT),
        Param(
            "g", "1", -0.9, 0.9, 0.0, (0.0,), "how much more it grips in extension", optional=True
        ),
    ),
    hooks={"relax": relax, "bound": bound, "give": give, "force": force},
    signature=Signature(
        mark="loops in force-deflection of one height at every frequency, with a shelf near zero after each reversal",
        plane="force-deflection",
        experiment="slow sines of several strokes, the smallest below the play",
        rivals=("bouc_wen_hysteresis", "freeplay", "coulomb_friction"),
        needs=("slow", "reversals"),
    ),
    source="Dahl 1968 (bristle); Nordin and Gutman 2002 (play in series with an elastic element); Ferri 1995 (friction "
    "brakes and joints)",
)
