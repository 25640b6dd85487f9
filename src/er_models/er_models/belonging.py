r"""Whether a damper belongs to the car it is in.

Of a slow harmonic motion :math:`x = X \sin \omega t` about rest the damper shows a stiffness and a damping
(harmonic linearisation), and standing still a force:

.. math:: k = \frac{\oint F x}{\oint x^2}, \quad c = \frac{\oint F v}{\oint v^2}, \quad F_0 = F(0, 0)

With the car's mass and spring they give what any car can be judged by: static deflection
:math:`F_0 / (k_s + k)`, natural frequency :math:`\sqrt{(k_s + k) / m_s}` and damping ratio
:math:`c / 2 \sqrt{(k_s + k) m_s}`.

Source: Gillespie 1992, Fundamentals of Vehicle Dynamics, ch. 5, for what cars have.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from er_models.constants import g
from er_models.errors import InputError
from er_models.model import Model
from er_models.prediction import motion, predict

FREQUENCY = (0.4, 10.0)
"""Natural frequencies of the body on its springs [Hz]: a coach has 0.9, a race car 6, a car in 1:5 has 4."""
DAMPING = (0.08, 2.0)
"""Damping ratios: worn dampers have 0.1, a semi-active one at full field 1."""
CYCLES, PER_CYCLE = 3, 400
"""Cycles of the motion, the last of which is read, and its samples."""
OF_THE_DAMPER = ("core", "force", "actuation", "heat")
"""Stages of effects that count: no sensors, no faults, which a plant may well have."""


@dataclass(frozen=True)
class Ride:
    """How a car stands and swings; damping: ratio without and with the largest field.

    static, weight: deflections by the damper's force at rest, and by the weight of the body [m]; frequency [Hz].
    """

    static: float
    weight: float
    frequency: float
    damping: tuple[float, float]


def ride(model: Model) -> Ride:
    """How a vehicle model stands and swings about rest, at the deflections and velocities of its envelope."""
    car = model.effects["quarter_car"]
    m, k_s = car["m_s"], car["k_s"]
    effects = {e: v for e, v in model.effects.items() if model.catalogue[e].stage in OF_THE_DAMPER}
    damper = replace(model, effects=effects)
    omega = float(np.sqrt(k_s / m))
    full = model.rig.get("duty_max", model.scales.duty)
    soft, hard = (
        _harmonic(damper, omega, duty) for duty in (model.rig.get("duty_min", 0.0), full)
    )
    stiffness = k_s + soft[0]
    if not stiffness > 0.0:
        return Ride(float("inf"), m * g / k_s, 0.0, (0.0, 0.0))
    critical = 2.0 * float(np.sqrt(stiffness * m))
    return Ride(
        static=abs(_at_rest(damper)) / stiffness,
        weight=m * g / stiffness,
        frequency=float(np.sqrt(stiffness / m)) / (2.0 * np.pi),
        damping=(soft[1] / critical, hard[1] / critical),
    )


def check_belonging(model: Model) -> None:
    """Refuse a vehicle model whose damper is of another size.

    Raises:
        InputError: Static deflection, natural frequency or damping ratio is out of any car's range.
    """
    found = ride(model)
    low, high = found.damping
    still, heavy = (f"{_short(1e3 * y)} mm" for y in (found.static, found.weight))
    checks = (
        (found.static <= found.weight, f"static deflection {still}", f"up to {heavy}"),
        (
            FREQUENCY[0] <= found.frequency <= FREQUENCY[1],
            f"natural frequency {_short(found.frequency)} Hz",
            f"{_span(*FREQUENCY)} Hz",
        ),
        (
            high >= DAMPING[0] and low <= DAMPING[1],
            f"damping ratio {_span(low, high)}",
            _span(*DAMPING),
        ),
    )
    wrong = [f"{name} (allowed {most})" for good, name, most in checks if not good]
    if wrong:
        mass = model.effects["quarter_car"]["m_s"]
        size = f"one of {_short(model.scales.force)} N on a body of {_short(mass)} kg"
        raise InputError(
            model.name, "damper", "one that belongs to this car", f"{size}: {', '.join(wrong)}"
        )


def _span(low: float, high: float) -> str:
    """Two numbers, or one where they look alike."""
    return " to ".join(dict.fromkeys((_short(low), _short(high))))


def _short(value: float) -> str:
    """Three digits, without a power of ten."""
    return f"{float(f'{value:.3g}'):g}"


def _harmonic(damper: Model, omega: float, duty: float) -> tuple[float, float]:
    """Stiffness [N/m] and damping [N s/m] of a damper in a harmonic motion [rad/s] at a duty."""
    s = damper.scales
    size = min(s.deflection, s.velocity / omega)
    t = np.arange(CYCLES * PER_CYCLE) * (2.0 * np.pi / omega / PER_CYCLE)
    x, v = size * np.sin(omega * t), size * omega * np.cos(omega * t)
    force = predict(damper, motion(float(t[1]), x, v, np.full(t.size, duty), -(omega**2) * x))
    last = slice(-PER_CYCLE, None)
    stiffness, damping = (float(force[last] @ y[last] / (y[last] @ y[last])) for y in (x, v))
    return stiffness, damping


def _at_rest(damper: Model) -> float:
    """Force of a damper that stands still without a field [N]."""
    still = np.zeros(8)
    return float(predict(damper, motion(0.01, still, still, still))[-1])
