"""Fading effectiveness: the yield force falls by s towards (1 - s) with time."""

from math import exp

from er_models.effect import Effect, Param, Signature


def yield_scale(s: float, t_f: float, t: float) -> float:
    """Factor on the yield force [1]."""
    return 1.0 - s * (1.0 - exp(-t / t_f))


EFFECT = Effect(
    name="effectiveness_fade",
    stage="heat",
    title="Fading effectiveness (sedimentation, ageing)",
    physics="Particles settle or the fluid ages: the field effect weakens with time, whatever "
    "the motion.",
    parameters=(
        Param("s", "1", -0.5, 1.0, 0.0, (0.15,), "share that fades"),
        Param("t_f", "s", 2.0, 5000.0, None, (15.0, 60.0), "time constant of the fade"),
    ),
    hooks={"yield_scale": yield_scale},
    signature=Signature(
        mark="yield force shrinks with time at equal duty",
        plane="time",
        experiment="the same run at the beginning and at the end, rest between",
        rivals=("self_heating", "force_fade"),
        needs=("minutes",),
    ),
    source="sedimentation of electrorheological suspensions; thesis 6.2.2 (loss of effectiveness)",
)
