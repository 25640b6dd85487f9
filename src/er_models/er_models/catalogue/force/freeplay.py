"""Freeplay: a joint with a gap of +-b, in series with the damper, that carries no force until it closes.

Closed it is rigid, or gives way by q times the force.
"""

from er_models.effect import CONTACT, LEAST_COMPLIANCE, LEAST_DAMPING, Effect, Param, Signature


def relax(k_0: float, c_0: float, x: float, v: float, f_r: float) -> tuple[float, float]:
    """Rate [1/s] and drive [m/s] of the position in the open gap: the damper moves free of force."""
    return k_0 / (c_0 + LEAST_DAMPING), v + (k_0 * x + f_r) / (c_0 + LEAST_DAMPING)


def bound(b: float) -> float:
    """Position where the gap is closed [m]."""
    return b


def give(q: float, c_0: float) -> float:
    """Rate at which the closed joint springs back against the damper [1/s]."""
    return 1.0 / ((q + LEAST_COMPLIANCE) * (c_0 + LEAST_DAMPING))


def shift_deflection(x: float, w: float) -> float:
    """Deflection of the damper itself [m]."""
    return x - w


def shift_velocity(
    b: float, q: float, k_0: float, c_0: float, x: float, v: float, f_r: float, w: float
) -> float:
    """Velocity of the damper itself [m/s]: that of the joint when closed and rigid, else as its force moves it."""
    push = (max(w - b, 0.0) + min(w + b, 0.0)) / (q + LEAST_COMPLIANCE)
    return v if q <= 0.0 and abs(w) >= b else (push - k_0 * x - f_r) / (c_0 + LEAST_DAMPING)


EFFECT = Effect(
    name="freeplay",
    stage="force",
    title="Freeplay (backlash)",
    physics="A worn joint must cross its gap each time the force changes its sign, before the damper works "
    "again; meanwhile the damper is free and relaxes.",
    parameters=(
        Param("b", "m", 0.0, 0.3, 0.0, (0.01, 0.03), "half the gap", step=CONTACT),
        Param(
            "q",
            "m/N",
            0.0,
            2.0,
            0.0,
            (1e-3,),
            "compliance of the closed joint",
            step=1e-3,  # of so stiff a spring less is lost in the rounding of its travel
            optional=True,
        ),
    ),
    generalises=("mount_compliance",),
    damped=1e-3,  # without damping it would cross its gap at any speed
    hooks={
        "relax": relax,
        "bound": bound,
        "give": give,
        "shift_deflection": shift_deflection,
        "shift_velocity": shift_velocity,
    },
    signature=Signature(
        mark="force stays near zero after each reversal for a fixed distance",
        plane="force-deflection",
        experiment="slow sine of small stroke at constant duty",
        rivals=("mount_compliance", "bouc_wen_hysteresis"),
        needs=("slow", "reversals"),
    ),
    source="Nordin and Gutman 2002, backlash survey",
)
