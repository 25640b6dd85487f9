r"""Load and asymmetry online: the sprung mass, and damping that differs by direction, found while driving, compiled.

With a body of theta times the believed mass, theta times the sprung acceleration is what the model's own row says,

.. math::  \theta\, y_1 = C_1 x

so an observer that is given theta y_1 for y_1 follows the true car: M(rho) is what it was, and with it every Lyapunov
function of the certificate; theta acts on measured signals only, whatever it does. What the wrong mass also does to
the relative velocity is the input (1/theta - 1) C_1 x, small beside the unsprung acceleration, and left to the gains.

A damping of c_0 (1 + a) in extension and c_0 (1 - a) in compression adds a c_0 |v| to the force. The state f_y takes
it in, exactly so with a drive beside that of the gate,

.. math::  f = f_y + a c_0 |v|: \quad \tau f' = -f + f_c \rho \tanh(\Gamma x) + a c_0 (|v| + \tau |v|')

Both show in the relative velocity. That of the observer obeys the model, that of the accelerometers (the integral of
their difference) knows neither. What the two disagree about, nu, is regressed on what they would make of it,

.. math::  S = \partial \hat v / \partial \theta : \quad C_{1x} S_x + C_{1v} S + C_{1f} S_f = y_1, \quad
           \tau S_f' = -S_f + \rho f_c s\, (k_1 S_x + c_1 S), \quad \nu = -(\theta - 1) S - a S_a

s the mean slope of the gate, and -C_{1v} |v| in place of y_1 for S_a. All pass a band around the body's resonance. Of
what happens between two samples the integral takes the bend that the model gives; it leaves out passages of the gate
under field, which it cannot follow.

Friction or hysteresis make something of nu as well, and so does what a fault takes from the damper: -C_{1v} v and
-C_{1f} F_er in place of y_1, the losses of damping and field. So theta is only used as far as the mass alone explains
nearly all of nu, but for a, and leaves little more of it than both losses together do. Near the body's resonance a
lighter damper moves the body much as a heavier body does: where neither explains clearly more, that is said. a is
even in the motion, which the rest is not, and needs less. They count as known after ten times the time constant of
the band, in motion. A car that stands keeps them, and learns anew when it moves again: loads change at rest.

Source: ours. Payload from accelerations: Rozyn and Zhang 2010; the shares are partial coefficients of determination.
"""

from __future__ import annotations

import math
from enum import IntEnum
from typing import NamedTuple

import numpy as np
from er_models.linear import LinearForm
from er_models.model import Array

from er_observers.forms import SENSORS
from er_observers.observers.compiled import compiled
from er_observers.observers.gate import gate_of

LOW, HIGH = 0.7, 1.4
"""Ratio of masses that is believed: a car's load, empty for loaded and the other way."""
BAND = (1.0 / 3.0, 3.0)
"""Band of the regression, in multiples of the body's undamped frequency."""
OPEN = 2.5
"""Gate inputs below which a passage under field is not followed between samples: tanh is 0.99 there."""
ENOUGH, FULL = 0.82, 0.9
"""Share of the disagreement that the mass explains: not used below the first, in full above the second.

Hidden effects of the catalogue reach 0.81 (field viscosity, where damping explains 0.95; hysteresis for a moment) and
0.71 (duty dead band). On a road that goes on between samples a tenth more mass reaches 0.7, a fifth 0.87.
"""
BETTER, AS_WELL = 1.08, 1.2
"""Sum of squares that the mass leaves over that which both losses leave: used in full below the first, not above the
second. A fifth more mass leaves 0.85 to 1.06 times as much on roads of ISO 8608, a leak of a fifth 1.25 to 1.4 times,
one of two fifths 1.6 to 2.1 times; on bumps 0.5 to 0.7, 0.7 to 0.9 and 1.4 to 1.9 times."""
CLEAR, SURE = 1.0, 0.9
"""The same ratio, above which a load and a loss are not told apart, and below which they are again."""
EVEN_ENOUGH, EVEN_FULL = 0.4, 0.6
"""The same for the asymmetry, of what the mass leaves: a fifth reaches 0.74, all else 0.06, or 0.35 for a moment."""
WIDEST = 0.4
"""Largest asymmetry that is believed."""
MEMORY = 20.0
"""Time in motion after which a lesson counts a third [s]."""
REST = 2.0
"""Time without motion after which the load may be another [s]: lessons begin anew, the ratio stays until they count."""
LEARNT = 10.0
"""Time in motion before lessons count, in time constants of the band; theta then follows with two of them."""
FOUND, SHIFT = 50.0, 0.1
"""Time in motion, in the same, after which a ratio in use is that of the load; it then moves by so much at most until
the car stands: what comes while it moves is no load."""
FAR = 3.0
"""Residual and S, in their rms so far, beyond which a sample counts less and less: a spike is no payload."""
FAINT = 0.1
"""Ratio off by so much must be seen above the noise of the accelerometers; else the car counts as standing."""

(RATIO, EVEN, SPEED, GATE, MX, MF, MV, DX, DF, DV, EX, EF, EV, FX, FF, FV) = range(16)
NU, MASS, DAMPING, BOTH, FIELD = range(16, 31, 3)
(
    POWER, MM, MN, NN, DD, DN, EE, EN, EM, HH, HN, DH, DE, HE, TIME, STILL, UNDECIDED, LOAD,
) = range(31, 49)  # fmt: skip
SIZE = 49
"""Numbers in the memory; NU, MASS, DAMPING, BOTH and FIELD are the places of passes of the band, three numbers each;
sums over mass M, nu N, damping D, asymmetry E and field H; UNDECIDED: whether a load and a loss are not told apart;
LOAD: ratio that was found since the car stood, 0 before that."""

(
    ON, C_1X, C_1V, C_1F, F_C, PER_TAU, K_1, C_1,
    APART_X, APART_V, APART_TYRE, LOW_EDGE, HIGH_EDGE, STANDING, STIFF_DUTY, YIELD,
) = range(16)  # fmt: skip
"""Places in the numbers (16,) of a model, with the symbols of the equations above: 1 where the regression is on; the
sprung acceleration by deflection [1/s2], velocity [1/s] and force [1/kg]; yield force at duty 1 [N], 1 / tau [1/s], the
gate's k_1 [1/m] and c_1 [s/m]; the relative acceleration by deflection [1/s2], velocity [1/s] and the tyre's deflection
[1/s2]; edges of the band [rad/s]; power of S over the sample time below which the car counts as standing [m2/s3]; duty
above which the open gate damps more than the rest of the damper; place of the yield force in the state."""
NUMBERS = YIELD + 1


class Verdict(IntEnum):
    """What is known of the sprung mass."""

    OFF = 0
    NOT_EXCITED = 1
    OTHER = 2
    ESTIMATED = 3
    UNDECIDED = 4


class Payload(NamedTuple):
    """Sprung mass over the believed one, and half the difference of damping by direction over its mean.

    ratio: in use; found: what the regression says; deviation: its standard deviation; share: how much of the
    disagreement a wrong mass explains. OTHER: nothing to explain, or something else does. UNDECIDED: a load and a loss
    of the damper explain it about as well. asymmetry: in use,
    positive where extension is damped more; asymmetry_found, asymmetry_deviation: what the regression says.
    """

    ratio: float
    found: float
    deviation: float
    share: float
    verdict: Verdict
    asymmetry: float = 0.0
    asymmetry_found: float = 0.0
    asymmetry_deviation: float = math.inf

    @property
    def text(self) -> str:
        """In words, with the number."""
        if self.verdict is Verdict.ESTIMATED:
            return f"estimated, {self.found:.3f} +- {self.deviation:.3f}"
        return self.verdict.name.lower().replace("_", " ")


def numbers_of(form: LinearForm, noise: float, *, on: bool = True) -> Array:
    """What the regression takes of a model (16,); all zero where it is off.

    Needs both accelerometers, no deflection sensor, and a yield force that only the gate drives. noise: of the
    accelerometers [m/s2].
    """
    at = int(np.argmax(np.abs(form.B)))
    lone = not np.any(np.delete(form.A[at], at)) and not form.C[0, 2]
    numbers = np.zeros(NUMBERS)
    if not (on and lone and form.C.shape[0] < len(SENSORS) and form.C[0, 0] < 0.0):
        return numbers
    numbers[ON] = 1.0
    numbers[C_1X], numbers[C_1V], numbers[C_1F] = form.C[0, 0], form.C[0, 1], form.C[0, at]
    numbers[F_C], numbers[PER_TAU] = -form.B[at] / form.A[at, at], -form.A[at, at]
    numbers[K_1], numbers[C_1] = form.Gamma[:2]
    numbers[YIELD] = at
    numbers[[APART_X, APART_V, APART_TYRE]] = (form.C[0] - form.C[1])[:3]
    low, high = (share * math.sqrt(-form.C[0, 0]) for share in BAND)
    numbers[LOW_EDGE], numbers[HIGH_EDGE] = low, high
    numbers[STANDING] = (noise / FAINT) ** 2 / low
    numbers[STIFF_DUTY] = numbers[C_1V] / (numbers[C_1F] * numbers[F_C] * numbers[C_1])
    return numbers


def begin() -> Array:
    """Memory (49,) before anything is known."""
    memory = np.zeros(SIZE)
    memory[RATIO], memory[SPEED] = 1.0, math.nan
    return memory


def interrupted(memory: Array) -> Array:
    """Memory (49,) where the next sample does not follow this one: what was learnt stays."""
    kept = memory.copy()
    kept[SPEED] = math.nan
    return kept


def seen(memory: Array, y: Array) -> Array:
    """Outputs (m,) as the model understands them: of a body of the believed mass under the same force."""
    return np.array([memory[RATIO] * y[0], *y[1:]])


def told(memory: Array, y: Array) -> Array:
    """Outputs (m,) as the accelerometers would tell them, from those the model makes: the inverse of `seen`."""
    return np.array([y[0] / memory[RATIO], *y[1:]])


def said(numbers: Array, memory: Array) -> Payload:
    """What a memory (49,) says."""
    ratio, even = float(memory[RATIO]), float(memory[EVEN])
    if not numbers[ON] or not memory[TIME] > 0.0:
        idle = Verdict.NOT_EXCITED if numbers[ON] else Verdict.OFF
        return Payload(ratio, 1.0, math.inf, 0.0, idle, even)
    error, share, weight, asymmetry, _, left, lost = judged(memory)
    deviations = [
        math.sqrt(left / (memory[TIME] * numbers[LOW_EDGE] * memory[at]))
        if memory[at] > 0.0
        else math.inf
        for at in (MM, EE)
    ]
    verdict = Verdict.ESTIMATED if weight * _told(left, lost) else Verdict.OTHER
    if memory[UNDECIDED] > 0.0:
        verdict = Verdict.UNDECIDED
    if memory[TIME] * numbers[LOW_EDGE] < LEARNT:
        verdict = Verdict.NOT_EXCITED
    return Payload(
        ratio, 1.0 + error, deviations[0], share, verdict, even, asymmetry, deviations[1]
    )


@compiled
def judged(memory: Array) -> tuple[float, float, float, float, float, float, float]:
    """Relative error of the mass, share of the disagreement it explains and how far that is used (0 to 1).

    And the asymmetry, how far it is used, the sum of squares that both leave, and what the losses leave in place of
    the mass.
    """
    mm, mn, nn, ee, en, em = memory[MM], memory[MN], memory[NN], memory[EE], memory[EN], memory[EM]
    whole = mm * ee - em * em
    if not (whole > 1e-6 * mm * ee and nn > 0.0):
        return 0.0, 0.0, 0.0, 0.0, 0.0, max(nn, 0.0), max(nn, 0.0)
    error, even = -(mn * ee - en * em) / whole, -(en * mm - mn * em) / whole
    left = max(nn + error * mn + even * en, 0.0)
    but_mass, but_even = nn - en * en / ee, nn - mn * mn / mm
    share, of_even = 0.0, 0.0
    if but_mass > 0.0:
        share = 1.0 - left / but_mass
    if but_even > 0.0:
        of_even = 1.0 - left / but_even
    lost = _left_by_losses(memory, but_mass)
    used = min(max((share - ENOUGH) / (FULL - ENOUGH), 0.0), 1.0)
    even_used = min(max((of_even - EVEN_ENOUGH) / (EVEN_FULL - EVEN_ENOUGH), 0.0), 1.0)
    return error, share, used, even, even_used, left, lost


@compiled
def _told(left: float, lost: float) -> float:
    """How far a mass is told from losses, 0 to 1, by the sums of squares they leave."""
    return float(
        min(max((AS_WELL * lost - left) / ((AS_WELL - BETTER) * lost + 1e-300), 0.0), 1.0)
    )


@compiled
def _left_by_losses(memory: Array, left: float) -> float:
    """Sum of squares that losses of damping and field leave of that which the asymmetry leaves."""
    per, of_d, of_h = 1.0 / memory[EE], memory[DE], memory[HE]
    dn = memory[DN] - of_d * memory[EN] * per
    hn = memory[HN] - of_h * memory[EN] * per
    dd = memory[DD] - of_d * of_d * per
    hh = memory[HH] - of_h * of_h * per
    dh = memory[DH] - of_d * of_h * per
    if dd > 0.0:
        left -= dn * dn / dd
        hn, hh = hn - dh * dn / dd, hh - dh * dh / dd
    if hh > 1e-6 * memory[HH]:
        left -= hn * hn / hh
    return float(max(left, 0.0))


@compiled
def _doubt(memory: Array) -> None:
    """Say, in place, whether a load and a loss explain most of the disagreement, and neither clearly more."""
    _, _, _, _, _, left, lost = judged(memory)
    but_mass = memory[NN] - memory[EN] * memory[EN] / memory[EE] if memory[EE] > 0.0 else 0.0
    said = memory[UNDECIDED] > 0.0
    least = but_mass * (1.0 - (ENOUGH - 0.1 if said else ENOUGH))
    explained = min(left, lost) < least
    memory[UNDECIDED] = 1.0 if explained and left > (SURE if said else CLEAR) * lost else 0.0


@compiled
def _respond(
    p: Array, memory: Array, at: int, y: float, drive: float, keep: float, dt: float
) -> float:
    """Bring a sensitivity (x, yield force, velocity) at its place dt [s] on; returns the change of the velocity.

    y: what disturbs the body's row [m/s2]; drive: what the gate's mean slope lets through; keep: of the yield force.
    """
    x, f, before = memory[at], keep * memory[at + 1], memory[at + 2]
    stiffness = p[C_1X] + p[C_1F] * drive * p[K_1]
    damping = p[C_1V] + p[C_1F] * drive * p[C_1]
    v = (y - stiffness * x - p[C_1F] * f) / (damping + dt * stiffness)
    x += dt * v
    memory[at], memory[at + 1], memory[at + 2] = x, f + drive * (p[K_1] * x + p[C_1] * v), v
    return float(v - before)


@compiled
def _pass(memory: Array, at: int, change: float, low: float, high: float) -> float:
    """A band pass of the sum of changes: leaky sum, its high pass, a low pass; low = 1 / (1 + w dt)."""
    total = low * (memory[at] + change)
    rise = low * (memory[at + 1] + total - memory[at])
    memory[at], memory[at + 1] = total, rise
    memory[at + 2] += high * (rise - memory[at + 2])
    return float(memory[at + 2])


@compiled
def even_drive(p: Array, memory: Array, v: float, now: float, before: float, dt: float) -> float:
    """What the asymmetry adds to rho times the gate, on the average of a sample.

    v: relative velocity at its beginning [m/s]; before, now: relative acceleration at its beginning and end [m/s2].
    """
    if p[ON] == 0.0 or memory[EVEN] == 0.0:
        return 0.0
    end = v + 0.5 * dt * (now + before)
    size, later = abs(v), abs(end)
    mean = 0.5 * (size + later)
    if v * end < 0.0:
        mean = 0.5 * (v * v + end * end) / (size + later)
    grown = (later - size) / (dt * p[PER_TAU])
    return float(memory[EVEN] * p[C_1V] / (p[C_1F] * p[F_C]) * (mean + grown))


@compiled
def learn(
    p: Array, memory: Array, a_0: float, b_0: float, a_1: float, b_1: float, v: float, s: float,
    f: float, rho: float, dt: float,
) -> None:  # fmt: skip
    """Take a sample into the memory (49,), in place, and move the ratio in use.

    p: of `numbers_of`; a, b: sprung and unsprung acceleration at its beginning and end [m/s2]; v: the observer's
    relative velocity [m/s], s: its gate's input and f: its yield force [N] at the end; rho: duty in force during it.
    """
    if p[ON] == 0.0:
        return
    s_0, t_0, t_1 = memory[GATE], gate_of(memory[GATE])[0], gate_of(s)[0]
    slope = (t_1 - t_0) / (s - s_0) if abs(s - s_0) > 1e-3 else 1.0 - t_1 * t_1
    keep = 1.0 / (1.0 + p[PER_TAU] * dt)
    drive = (1.0 - keep) * p[F_C] * rho * slope
    mass = _respond(p, memory, MX, a_1, drive, keep, dt)
    damping = _respond(p, memory, DX, -p[C_1V] * v, drive, keep, dt)
    even = _respond(p, memory, EX, -p[C_1V] * abs(v), drive, keep, dt)
    field = _respond(p, memory, FX, -p[C_1F] * f, drive, keep, dt)
    speed = v - (memory[RATIO] - 1.0) * memory[MV] - memory[EVEN] * memory[EV]
    change, rise = 0.5 * (a_0 - b_0 + a_1 - b_1), (a_1 - b_1 - a_0 + b_0) / dt
    bend = p[APART_X] * change + p[APART_V] * rise + p[APART_TYRE] * 0.5 * (b_0 + b_1)
    nu = speed - memory[SPEED] - dt * (change - dt * dt / 12.0 * bend)
    memory[SPEED], memory[GATE] = speed, s
    passes = s * s_0 < 0.0 or min(abs(s), abs(s_0)) < OPEN
    if (rho > p[STIFF_DUTY] and passes) or not math.isfinite(nu):
        nu = mass = damping = even = field = 0.0
    _weigh(p, memory, nu, mass, damping, even, field, dt)


@compiled
def _trust(square: float, usual: float) -> float:
    """How much a sample counts, from its square and what is usual."""
    return (FAR * FAR * usual / square) ** 2 if square > FAR * FAR * usual else 1.0


@compiled
def _weigh(
    p: Array, memory: Array, nu: float, mass: float, damping: float, even: float, field: float,
    dt: float,
) -> None:  # fmt: skip
    """Band, sums and the ratio in use, from the changes over a sample."""
    low, high = 1.0 / (1.0 + dt * p[LOW_EDGE]), dt * p[HIGH_EDGE] / (1.0 + dt * p[HIGH_EDGE])
    n, m = _pass(memory, NU, nu, low, high), _pass(memory, MASS, mass, low, high)
    d, b = _pass(memory, DAMPING, damping, low, high), _pass(memory, BOTH, even, low, high)
    h = _pass(memory, FIELD, field, low, high)
    memory[POWER] += (1.0 - low) * (m * m - memory[POWER])
    if memory[POWER] > p[STANDING] * dt:
        if memory[STILL] > REST:
            memory[MM:STILL] = memory[UNDECIDED] = memory[LOAD] = 0.0
        memory[STILL] = 0.0
        forget, counts = 1.0 - dt / MEMORY, dt
        if memory[TIME] * p[LOW_EDGE] > 0.5 * LEARNT:
            error, _, _, asymmetry, _, usual, _ = judged(memory)
            left = n + error * m + asymmetry * b
            counts *= _trust(left * left * memory[TIME], usual)
            counts *= _trust(m * m * memory[TIME], memory[MM])
        for at in range(MM, TIME):
            memory[at] *= forget
        memory[MM] += counts * m * m
        memory[MN] += counts * m * n
        memory[NN] += counts * n * n
        memory[DD] += counts * d * d
        memory[DN] += counts * d * n
        memory[EE] += counts * b * b
        memory[EN] += counts * b * n
        memory[EM] += counts * b * m
        memory[HH] += counts * h * h
        memory[HN] += counts * h * n
        memory[DH] += counts * d * h
        memory[DE] += counts * d * b
        memory[HE] += counts * h * b
        memory[TIME] = forget * memory[TIME] + counts
    else:
        memory[STILL] += dt
    if memory[TIME] * p[LOW_EDGE] < LEARNT:
        return
    error, _, used, asymmetry, even_used, left, lost = judged(memory)
    _doubt(memory)
    follows, told = 0.5 * (1.0 - low), _told(left, lost)
    aim = min(max(1.0 + used * error, LOW), HIGH)
    if memory[LOAD] > 0.0:
        aim = min(max(aim, memory[LOAD] - SHIFT), memory[LOAD] + SHIFT)
        memory[RATIO] += follows * told * (aim - memory[RATIO])
    else:
        memory[RATIO] += follows * (1.0 + told * (aim - 1.0) - memory[RATIO])
        if memory[TIME] * p[LOW_EDGE] > FOUND and used * told > 0.5:
            memory[LOAD] = memory[RATIO]
    aim = min(max(even_used * asymmetry, -WIDEST), WIDEST)
    memory[EVEN] += follows * (aim - memory[EVEN])
