"""Remanence: a share s of the field is dragged along by the duty at a distance of r, and stays (play operator)."""

from er_models.effect import INSTANT, Effect, Param, Signature

NEARLY = 1.0 - 1e-9
"""Share of r from which on the field is dragged along: it stays dragged whatever is lost in rounding."""


def relax(r: float, u: float, w: float) -> tuple[float, float]:
    """Rate [1/s] and drive [1/s] of the share that stays, in duty: dragged at a distance of r, held within it."""
    dragged = abs(u - w) >= NEARLY * r
    return (INSTANT, INSTANT * (u - r if u > w else u + r)) if dragged else (0.0, 0.0)


def duty(s: float, u: float, w: float) -> float:
    """Duty that the yield force follows [1]."""
    return u + s * (w - u)


EFFECT = Effect(
    name="remanence",
    stage="actuation",
    title="Remanence (hysteresis of the field)",
    physics="Iron and particles stay magnetised, and electrodes charged: while the duty rises the field lags behind, "
    "while it falls there is more of it, and at zero duty some is left. Waiting does not help, only the "
    "opposite step.",
    parameters=(
        Param(
            "r", "duty", 5e-3, 0.35, None, (0.05, 0.2), "half the duty that turns the field round"
        ),
        Param("s", "1", 0.0, 1.0, 0.0, (0.5,), "share of the field that lags by it"),
    ),
    hooks={"relax": relax, "duty": duty},
    signature=Signature(
        mark="the yield force at one duty depends on whether the duty came from above or from below",
        plane="force-duty",
        experiment="stairs of the duty up and down again on a steady sine",
        rivals=("duty_dead_band", "field_exponent", "field_saturation"),
        needs=("duty_levels", "duty_rises", "duty_falls"),
    ),
    source="Jiles and Atherton 1986; Krasnosel'skii and Pokrovskii 1989 (play operator); An and Kwon 2003 (hysteresis "
    "of the current in MR actuators)",
)
