"""Gain of the force channel: g_F F_m."""

from er_models.effect import Effect, Param, Signature


def sense(g_F: float, f_m: float) -> float:
    """Reported force [N]."""
    return g_F * f_m


EFFECT = Effect(
    name="force_gain",
    stage="sensing",
    title="Gain of the force channel",
    physics="A load cell or its amplifier that is out of scale: it reports g_F times the true force.",
    parameters=(Param("g_F", "1", 0.2, 5.0, 1.0, (1.1,), "reported over true force"),),
    hooks={"sense": sense},
    signature=Signature(
        mark="every force is off by the same factor",
        plane="force-velocity",
        experiment="dead weight on the load cell",
        rivals=("passive", "guo_yield", "bingham_yield"),
    ),
    source="model of the measurement chain",
    knowable=False,
    unknowable_because="k0, c0 and the yield force (f_c or sigma) of the damper, all forces, take up a scale of "
    "the force exactly. Only a known force tells: a dead weight on the load cell.",
)
