"""Writes a formula as a file with an effect of the user's own, to begin the missing effect with."""

from __future__ import annotations

from er_models.scales import Scales

from er_model_lab.terms.formula import Block, Formula

MOST = 10.0
"""Bound of a coefficient, over the force scale, where its value is no larger."""


def own_effect(found: Formula, name: str, scales: Scales) -> str:
    """A Python file with the effect, as `--effects-from` reads it; the equation is the user's to change."""
    many = range(1, len(found.blocks) + 1)
    signals = found.signals
    arguments = [f"K_{k}" for k in many] + list(signals)
    terms = [f"K_{k} * {_text(b)}" for k, b in zip(many, found.blocks, strict=True)]
    constants = "\n".join(f"{s.upper()}_0 = {found.units[s]!r}" for s in signals)
    params = [_param(k, c / scales.force) for k, c in zip(many, found.coefficients, strict=True)]
    lagged, hooks = "", '{"force": force}'
    if found.lag:
        low, high = 0.1 * found.lag, 10.0 * found.lag
        params.append(
            f'Param("T", "s", {low:.4g}, {high:.4g}, None, ({found.lag:.4g},), "lag of the velocity")'
        )
        hooks = '{"relax": relax, "force": force}'
        lagged = '''def relax(T: float, v: float) -> tuple[float, float]:
    """Velocity w, lagged: w' = (v - w) / T."""
    return 1.0 / T, v / T


'''
    lines = "\n".join(f"        {p}," for p in params)
    sum_ = "\n        + ".join(terms)
    return f'''"""{name}: a formula for what was measured and not explained; say here what it is."""

import math

from er_models.effect import Effect, Param, Signature

# natural scales of the data [SI]
{constants}


{lagged}def force({", ".join(f"{a}: float" for a in arguments)}) -> float:
    """Force it adds [N]."""
    return (
        {sum_}
    )


EFFECT = Effect(
    name="my_{name}", stage="force", title="Formula of {name.replace("_", " ")}", physics="Why it is there.",
    # name, unit, lower and upper bound, neutral value, starts: multiples of the natural scale of the unit
    parameters=(
{lines}
    ),
    hooks={hooks},
    signature=Signature("how it shows", "force-velocity", "what shows it best"),
    source="found in the data",
)
'''


def _text(block: Block) -> str:
    """A block as Python, in the signals over their scales."""
    return " * ".join(p.text(f"({p.signal} / {p.signal.upper()}_0)") for p in block)


def _param(k: int, start: float) -> str:
    """Declaration of a coefficient, whose bounds hold its start."""
    most = max(MOST, 4.0 * abs(start))
    return f'Param("K_{k}", "N", {-most:.4g}, {most:.4g}, 0.0, ({start:.4g},), "coefficient")'
