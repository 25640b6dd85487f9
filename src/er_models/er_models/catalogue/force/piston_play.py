"""Damped play of the piston: c_p w' carries the yield force until the play +-b is used up."""

from er_models.effect import SWITCH, Effect, Param, Signature


def relax(c_p: float, f_y: float) -> tuple[float, float]:
    """Rate [1/s] and drive [m/s] of the piston in its play: the fluid squeezed out resists."""
    return 0.0, f_y / c_p


def bound(b: float) -> float:
    """Position where the play is used up [m]."""
    return b


def flow_deflection(x: float, w: float) -> float:
    """Deflection that moves fluid through the field [m]."""
    return x - w


def flow_velocity(b: float, c_p: float, v: float, f_y: float, w: float) -> float:
    """Velocity that moves fluid through the field [m/s]: all of it once the play is used up."""
    return v if abs(w) >= b else v - f_y / c_p


EFFECT = Effect(
    name="piston_play",
    stage="force",
    title="Damped play of the piston",
    physics="A ring or a piston that floats on its rod crosses its play after each reversal. The fluid "
    "squeezed out of the play resists in proportion to the velocity; only then must the fluid pass "
    "the field. Seals rub all the time.",
    parameters=(
        Param("b", "m", 0.0, 0.3, 0.0, (0.01, 0.03), "half the play", step=SWITCH),
        Param(
            "c_p",
            "N s/m",
            0.05,
            50.0,
            None,
            (3.0, 0.5),
            "damping while the play is crossed",
            step=SWITCH,
        ),
    ),
    hooks={
        "relax": relax,
        "bound": bound,
        "flow_deflection": flow_deflection,
        "flow_velocity": flow_velocity,
    },
    signature=Signature(
        mark="after each reversal a step that grows with the velocity and not with the duty, "
        "for a fixed distance",
        plane="force-deflection",
        experiment="slow and fast sine of small stroke at high duty",
        rivals=("freeplay", "mount_compliance", "bouc_wen_hysteresis"),
        needs=("slow", "reversals", "high_duty"),
    ),
    source="Nordin and Gutman 2002, backlash survey: gap with damping, in series with the yield force",
)
