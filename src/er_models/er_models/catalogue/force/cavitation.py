"""Cavitation: beyond F_v a void of the stroke w opens, and holds the force there until it is closed again.

The stroke back closes it, or it fills by itself: with r = 0 all of it is lost motion, with r far above the
frequencies of the motion nothing is, and the force is only cut off. What follows the piston meets the losses of the
fluid beyond c_0 by a share s_y: all of them where it comes through the field, none through a foot valve. The pressure
falls as that of a gas that is there when the void closes: slowly where n_g = 1, at once where vapour condenses.
"""

from er_models.effect import CONTACT, INSTANT, LEAST_DAMPING, Effect, Param, Signature


def relax(
    F_v: float, r: float, s_y: float, c_0: float, v: float, f_h: float, w: float
) -> tuple[float, float]:
    """Rate [1/s] at which the void fills by itself; drive [m/s]: the stroke less what follows at vapour pressure."""
    flow = c_0 * v + s_y * (f_h - c_0 * v)
    excess = flow - F_v if F_v > 0.0 else F_v - flow
    opens = w > 0.0 or (excess > 0.0 and (f_h > F_v if F_v > 0.0 else f_h < F_v))
    return (r, excess / (c_0 + LEAST_DAMPING)) if opens else (INSTANT, 0.0)


def limit(F_v: float, w_s: float, n_g: float, f_h: float, f_d: float, w: float) -> float:
    """Force [N]: with a void w the fluid pushes with F_v instead of f_h; springs and friction act as ever."""
    return f_d + (F_v - f_h) * (1.0 - (1.0 + w / (n_g * w_s)) ** -n_g) if w > 0.0 else f_d


EFFECT = Effect(
    name="cavitation",
    stage="force",
    title="Cavitation",
    physics="A fast stroke draws one chamber to vapour pressure: the force cannot grow, "
    "and stays until the stroke back has closed the void, or the fluid has filled it.",
    parameters=(
        Param(
            "F_v",
            "N",
            -1e6,
            1e6,
            float("inf"),
            (0.5, 0.8, 0.3, 0.15, -0.5, -0.8, -0.3, -0.15),
            "force at vapour pressure; negative in compression",
            step=CONTACT,
        ),
        Param(
            "r",
            "1/s",
            0.0,
            2000.0,
            None,
            (50.0,),
            "rate at which the void fills by itself",
            step=CONTACT,
        ),
        Param(
            "w_s",
            "m",
            1e-4,
            0.1,
            None,
            (2e-3,),
            "void over which the force is cut off",
            step=CONTACT,
        ),
        Param(
            "s_y",
            "1",
            0.0,
            1.0,
            1.0,
            (1.0,),
            "share of the losses in the way of what follows",
            step=CONTACT,
            optional=True,
        ),
        Param(
            "n_g",
            "1",
            1.0,
            30.0,
            1.0,
            (1.0,),
            "exponent of the void's pressure: gas 1, vapour more",
            step=CONTACT,
            optional=True,
        ),
    ),
    hooks={"relax": relax, "limit": limit},
    initial="zero",
    signature=Signature(
        mark="force is cut off on one side, and comes back late",
        plane="force-velocity",
        experiment="fast large sine at high duty",
        rivals=("asymmetric_damping",),
        needs=("fast_extension", "fast_compression", "fast_high_duty"),
    ),
    source="Dixon 2007, ch. 5; Duym 2000",
)
