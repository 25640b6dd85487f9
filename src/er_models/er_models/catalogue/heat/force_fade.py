"""Fading force: the whole damper force falls by s towards (1 - s) with time."""

from math import exp

from er_models.effect import Effect, Param, Signature


def limit(s: float, t_f: float, t: float, f_d: float) -> float:
    """What is left of the damper force [N]: springs, viscosity, yield force and friction alike."""
    return f_d * (1.0 - s * (1.0 - exp(-t / t_f)))


EFFECT = Effect(
    name="force_fade",
    stage="heat",
    title="Fading force (loss of fluid, ageing)",
    physics="Fluid is lost, or takes up gas: springs, viscosity and yield force act on less of it, and the "
    "whole force weakens with time, whatever the motion and the duty.",
    parameters=(
        Param("s", "1", -0.5, 1.0, 0.0, (0.15,), "share that fades"),
        Param("t_f", "s", 2.0, 5000.0, None, (15.0, 60.0), "time constant of the fade"),
    ),
    hooks={"limit": limit},
    signature=Signature(
        mark="the whole force shrinks with time by one factor, with and without field",
        plane="time",
        experiment="a slow sine of large stroke at zero duty, at the beginning and at the end, rest between",
        rivals=("effectiveness_fade", "self_heating"),
        needs=("minutes",),
    ),
    source="Dixon 2007, ch. 5 (fade, aeration of the fluid); thesis (6.4): the whole force keeps one share",
)
