"""The true dampers: every law in one file, and one step along an imposed motion.

Each step is an implicit midpoint rule for what moves in a joint, and the exact solution over the step for lags,
branches and friction (a Dahl spring is solved over the path, not over time). All of it stands in this file since numba
keeps compiled code by the file of a function alone.

Rows of ``laws`` are switched off by a first column of zero; signs: force resists extension, x and v grow in extension.
"""

from __future__ import annotations

from math import cos, exp, pi, sin, sqrt, tanh

import numba
import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
LAWS = (
    "coulomb", "stribeck", "dahl", "direction", "loaded", "orifice", "check", "knee", "thin", "taper", "stop", "gas",
    "offset", "maxwell", "mount", "play", "inertia", "void", "thicken", "stiffen", "mixed", "saturate", "late",
    "amplifier", "threshold", "switching", "slowing", "remanent", "pressed", "heat", "fade", "wear", "cogging",
    "zero", "force_late", "force_slow",
)  # fmt: skip
"""Rows of the table of laws; the last three act in the sensors (`sensors.py`)."""
(
    COULOMB, STRIBECK, DAHL, DIRECTION, LOADED, ORIFICE, CHECK, KNEE, THIN, TAPER, STOP, GAS,
    OFFSET, MAXWELL, MOUNT, PLAY, INERTIA, VOID, THICKEN, STIFFEN, MIXED, SATURATE, LATE,
    AMPLIFIER, THRESHOLD, SWITCHING, SLOWING, REMANENT, PRESSED, HEAT, FADE, WEAR, COGGING,
    ZERO, FORCE_LATE, FORCE_SLOW,
) = range(len(LAWS))  # fmt: skip
COLUMNS = 5
BASE = ("k0", "c0", "f_c", "k1", "c1", "tau", "beta", "u_m", "F_c", "v_0")
"""Spring, dashpot; lagged yield force f_c u_m (u / u_m)^beta tanh(k1 x + c1 v); friction F_c tanh(v / v_0)."""
K0, C0, FY, K1, C1, TAU, BETA, UM, FC, V0 = range(len(BASE))
U1, U2, HELD, CHAINS, YIELD, Z, M1, M2, HOLLOW, XD = range(10)
"""States: the amplifier's two, play of the field, chains, yield force, bend of friction, branches, void, damper."""

law = numba.njit(error_model="numpy")


@law
def smooth_sign(v: float, width: float) -> float:
    """Algebraic sign of a velocity."""
    return v / sqrt(v * v + width * width)


@law
def friction(v: float, spring: float, laws: Array) -> float:
    """Friction without memory [N]: Coulomb, Stribeck (a Lorentz hump), by direction, by the load of the spring [N]."""
    force = laws[COULOMB, 0] * smooth_sign(v, laws[COULOMB, 1]) if laws[COULOMB, 0] > 0.0 else 0.0
    r = laws[STRIBECK]
    if r[0] > 0.0:
        force += r[0] * (r[3] + 1.0 / (1.0 + (v / r[1]) ** 2)) * smooth_sign(v, r[2])
    r = laws[DIRECTION]
    if r[0] > 0.0:
        s = smooth_sign(v, r[2])
        force += r[0] * s * (1.0 + r[1] * s)
    if laws[LOADED, 0] > 0.0:
        force += laws[LOADED, 0] * abs(spring) * smooth_sign(v, laws[LOADED, 1])
    return force


@law
def valve(v: float, c0: float, opens: float, share: float, soft: float) -> float:
    """Force [N] at a speed v >= 0 of a bleed c0 beside a valve that opens at a force and then passes c0 / share.

    The flows add up to v: F / c0 + share / c0 (d + (d^2 + soft^2)^(1/2)) / 2 = v with d = F - opens, a quadratic.
    """
    a = 2.0 * (c0 * v - opens) / share
    b = 1.0 + 2.0 / share
    root = sqrt(a * a + (b * b - 1.0) * soft * soft)
    return opens + (a * b - root) / (b * b - 1.0)


@law
def viscous(v: float, c0: float, laws: Array) -> float:
    """Force of the fluid without field [N]: linear, thinning (Cross), or through valves with a knee a direction."""
    force = c0 * v
    r = laws[KNEE]
    if r[0] > 0.0:
        up = v >= 0.0
        opens = r[1] if up else r[2]
        rest = valve(0.0, c0, opens, r[0], r[3])
        size = valve(abs(v), c0, opens, r[0] if up else r[0] * r[4], r[3]) - rest
        force = size if up else -size
    r = laws[THIN]
    if r[0] > 0.0:
        ratio = (abs(v) / r[1]) ** r[2]
        force -= c0 * v * r[0] * ratio / (1.0 + ratio)
    return force


@law
def damping(x: float, v: float, laws: Array) -> float:
    """Further losses without memory [N]: orifice with a laminar core, check valve, taper along the stroke."""
    r = laws[ORIFICE]
    force = r[0] * v * sqrt(v * v + r[1] * r[1]) if r[0] > 0.0 else 0.0
    r = laws[CHECK]
    if r[0] != 0.0:
        force += r[0] * (sqrt(v * v + r[1] * r[1]) - r[1])
    r = laws[TAPER]
    if r[0] > 0.0:
        force += r[0] * v * 0.5 * (1.0 - cos(pi * x / r[1]))
    return force


@law
def springs(x: float, laws: Array) -> float:
    """Elastic forces beside the linear one [N]: stop, polytropic gas without its linear part, offset, cogs."""
    r = laws[STOP]
    force = 0.0
    if r[0] > 0.0 and abs(x) > r[1]:
        d = abs(x) - r[1]
        force = r[0] * d * (1.0 + d / r[2]) * (1.0 if x > 0.0 else -1.0)
    r = laws[GAS]
    if r[0] > 0.0:
        force += r[0] * (1.0 - r[2] * x / r[1] - (1.0 + x / r[1]) ** -r[2])
    r = laws[COGGING]
    if r[0] > 0.0:
        force += r[0] * sin(2.0 * pi * x / r[1])
    return force + laws[OFFSET, 0]


@law
def under_field(x: float, v: float, chains: float, laws: Array) -> float:
    """What the chains that have formed (duty that has acted) add at once [N]: pressure, viscosity, stiffness."""
    r = laws[THICKEN]
    force = laws[PRESSED, 0] * chains
    if r[0] > 0.0:
        force += r[0] * chains / (1.0 + chains / (3.0 * r[1])) * v
    r = laws[STIFFEN]
    if r[0] > 0.0:
        force += r[0] * chains * 1.5 * r[1] * tanh(x / (1.5 * r[1]))
    return force


@law
def at_once(x: float, v: float, chains: float, warm: float, base: Array, laws: Array) -> float:
    """All forces without a state of their own [N]; warm: factor on the viscosity."""
    spring = base[K0] * x
    force = spring + warm * viscous(v, base[C0], laws) + friction(v, spring, laws)
    if base[FC] > 0.0:
        force += base[FC] * tanh(v / base[V0])
    return force + damping(x, v, laws) + springs(x, laws) + under_field(x, v, chains, laws)


@law
def bent(z: float, dx: float, limit: float) -> float:
    """Deflection [m] of a Dahl spring after a path dx: the solution of dz = dx (1 - z sign(dx) / limit)."""
    side = limit if dx > 0.0 else -limit
    return side - (side - z) * exp(-abs(dx) / limit)


@law
def field(u: float, held: float, laws: Array) -> tuple[float, float]:
    """Field that a duty makes, and where its play operator then stands (remanence)."""
    r = laws[THRESHOLD]
    if r[0] > 0.0:
        u = 0.5 * (u - r[0] + sqrt((u - r[0]) ** 2 + r[1] * r[1]))
    r = laws[MIXED]
    if r[0] != 0.0:
        u = (1.0 - r[0]) * u + r[0] * u * u / r[1]
    r = laws[SATURATE]
    if r[0] > 0.0:
        u = r[1] / r[0] * (1.0 - exp(-u * r[0] / r[1]))
    r = laws[REMANENT]
    if r[0] > 0.0:
        held = min(max(held, u - r[1]), u + r[1])
        u = (1.0 - r[0]) * u + r[0] * held
    return u, held


@law
def asked(x: float, v: float, h: float, base: Array) -> float:
    """Yield force [N] that a field h asks for."""
    if base[FY] <= 0.0 or h <= 0.0:
        return 0.0
    return base[FY] * base[UM] * (h / base[UM]) ** base[BETA] * tanh(base[K1] * x + base[C1] * v)


@law
def response(u: float, target: float, y: float, base: Array, laws: Array) -> float:
    """Time constant [s] of the yield force: by duty, and another where the force shrinks."""
    tau = base[TAU]
    if laws[SLOWING, 0] != 0.0:
        tau *= exp(laws[SLOWING, 0] * u / laws[SLOWING, 1])
    if laws[SWITCHING, 0] != 0.0 and (target * y < 0.0 or abs(target) < abs(y)):
        tau *= exp(laws[SWITCHING, 0])
    return tau


@law
def joint(s: float, laws: Array) -> float:
    """Force [N] of the joint in series stretched by s [m]: hardening rubber, or a gap with an elastic contact."""
    r = laws[PLAY]
    if r[0] > 0.0:
        return r[1] * (max(s - r[0], 0.0) - max(-s - r[0], 0.0))
    r = laws[MOUNT]
    return s / r[0] * (1.0 + (s / r[1]) ** 2)


@law
def unbalance(
    w: float, end: float, warm: float, h: float, s: Array, base: Array, laws: Array
) -> float:
    """Damper force less joint force [N] halfway through a step in which the damper moves at w; end: the joint's [m]."""
    x = s[XD] + 0.5 * h * w
    force = at_once(x, w, s[CHAINS], warm, base, laws) + s[YIELD] + s[M1] + s[M2]
    r = laws[DAHL]
    if r[0] > 0.0:
        force += r[0] * (1.0 + r[2] * s[CHAINS]) * bent(s[Z], 0.5 * h * w, r[1]) / r[1]
    return force - joint(end - x, laws)


@law
def moved(
    w: float, end: float, warm: float, h: float, s: Array, base: Array, laws: Array
) -> float:
    """Velocity [m/s] of the damper behind its joint: bracketed from the last one, then bisected with secants."""
    low = high = w
    at_low = at_high = unbalance(w, end, warm, h, s, base, laws)
    step = 1e-3 + 0.1 * abs(w)
    for _ in range(60):
        if at_low <= 0.0 <= at_high:
            break
        if at_low > 0.0:
            high, at_high = low, at_low
            low -= step
            at_low = unbalance(low, end, warm, h, s, base, laws)
        else:
            low, at_low = high, at_high
            high += step
            at_high = unbalance(high, end, warm, h, s, base, laws)
        step *= 2.0
    for k in range(60):
        span = high - low
        if span <= 1e-9 + 1e-9 * abs(low):
            break
        middle = low - at_low * span / (at_high - at_low)
        if k % 3 == 2 or not low < middle < high:
            middle = 0.5 * (low + high)
        at = unbalance(middle, end, warm, h, s, base, laws)
        if at < 0.0:
            low, at_low = middle, at
        else:
            high, at_high = middle, at
    return 0.5 * (low + high)


@law
def driven(u: float, h: float, s: Array, laws: Array) -> float:
    """Field that acts after a step in which a duty u was there: two poles, then what `field` makes of it."""
    pole = laws[AMPLIFIER, 0]
    if pole > 0.0:
        s[U1] += (u - s[U1]) * (1.0 - exp(-h / pole))
        s[U2] += (s[U1] - s[U2]) * (1.0 - exp(-h / (0.2 * pole)))
        u = s[U2]
    flux, s[HELD] = field(u, s[HELD], laws)
    return flux


@law
def fluid_steps(
    x: float,
    w: float,
    u: float,
    flux: float,
    weak: float,
    h: float,
    s: Array,
    base: Array,
    laws: Array,
) -> None:
    """Chains, yield force, friction's bend and branches after a step at velocity w with x in its middle."""
    if base[TAU] > 0.0:
        s[CHAINS] += (flux - s[CHAINS]) * (1.0 - exp(-h / base[TAU]))
        target = weak * asked(x, w, flux, base)
        s[YIELD] += (target - s[YIELD]) * (
            1.0 - exp(-h / response(u, target, s[YIELD], base, laws))
        )
    else:
        s[CHAINS] = flux
    if laws[DAHL, 0] > 0.0:
        s[Z] = bent(s[Z], h * w, laws[DAHL, 1])
    r = laws[MAXWELL]
    if r[0] > 0.0:
        d1, d2 = exp(-h / r[1]), exp(-h / (4.0 * r[1]))
        s[M1] = s[M1] * d1 + r[0] * (1.0 - r[2]) * w * r[1] * (1.0 - d1)
        s[M2] = s[M2] * d2 + r[0] * r[2] * w * 4.0 * r[1] * (1.0 - d2)


@law
def rigid(x: float, v: float, warm: float, h: float, s: Array, base: Array, laws: Array) -> float:
    """Force [N] of a damper without a joint; a void (cavitation) cuts what the fluid pushes with and must close."""
    force = at_once(x, v, s[CHAINS], warm, base, laws) + s[YIELD] + s[M1] + s[M2]
    r = laws[DAHL]
    if r[0] > 0.0:
        force += r[0] * (1.0 + r[2] * s[CHAINS]) * s[Z] / r[1]
    r = laws[VOID]
    if r[0] > 0.0:
        fluid = warm * viscous(v, base[C0], laws) + s[YIELD]
        most = r[1] * (1.0 - r[0])
        open_ = s[HOLLOW] > 0.0 or fluid > most
        s[HOLLOW] = max(s[HOLLOW] + h * (v - most / base[C0]), 0.0) if open_ else 0.0
        force += (most - fluid) * (1.0 - exp(-s[HOLLOW] / r[2]))
    return force


@law
def fading(law_row: Array, t: float) -> float:
    """What is left [1] after a time of the record, t / (t + time of half the loss)."""
    return 1.0 - law_row[0] * t / (t + law_row[1]) if law_row[0] != 0.0 and t > 0.0 else 1.0


@numba.njit(cache=True, error_model="numpy")
def run(
    x: Array, v: Array, a: Array, u: Array, h: float, lead: int, base: Array, laws: Array
) -> Array:
    """Force [N] at every fine sample (n,) of a damper that is moved so.

    Args:
        x, v, a, u: deflection [m], velocity, acceleration, duty (n,); a duty holds until the next sample.
        h: step [s].
        lead: samples before the record begins; heat and ageing count from there.
        base: `BASE` (10,).
        laws: one row each of `LAWS` (36, 5).
    """
    out, s = np.empty(x.size), np.zeros(10)
    late = round(laws[LATE, 0] / h)
    jointed = laws[MOUNT, 0] > 0.0 or laws[PLAY, 0] > 0.0
    s[U1] = s[U2] = u[0]
    flux, s[HELD] = field(u[0], u[0], laws)
    s[CHAINS], s[YIELD] = flux, asked(x[0], v[0], flux, base)
    s[Z], s[XD] = laws[DAHL, 3] * laws[DAHL, 1], x[0]
    heat, w, hot = 0.0, v[0], laws[HEAT]
    for i in range(x.size):
        t = (i - lead) * h
        warm, weak = (
            1.0 / (1.0 + hot[0] * heat),
            fading(laws[FADE], t) / (1.0 + 0.6 * hot[0] * heat),
        )
        if i > 0:
            before = u[max(i - 1 - late, 0)]
            flux = driven(before, h, s, laws)
            w = (
                moved(w, 0.5 * (x[i] + x[i - 1]), warm, h, s, base, laws)
                if jointed
                else (x[i] - x[i - 1]) / h
            )
            fluid_steps(s[XD] + 0.5 * h * w, w, before, flux, weak, h, s, base, laws)
            s[XD] += h * w
        if jointed:
            force = joint(x[i] - s[XD], laws)
        else:
            s[XD] = x[i]
            force = rigid(x[i], v[i], warm, h, s, base, laws)
        out[i] = (force + laws[INERTIA, 0] * a[i]) * fading(laws[WEAR], t)
        if hot[0] != 0.0 and t >= 0.0:
            heat += (abs(out[i] * v[i]) / hot[2] - heat) * (1.0 - exp(-h / hot[1]))
    return out
