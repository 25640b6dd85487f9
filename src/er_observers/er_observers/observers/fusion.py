r"""Two accelerometers and a deflection sensor, fused: a force that needs no model where the model is wrong, compiled.

The body's balance tells the force without any damper model, and its noise is that of two sensors,

.. math::  F_b = -\theta m_s y_1 - k_s x_m, \quad \sigma_b^2 = (\theta m_s \sigma_a)^2 + (k_s \sigma_x)^2

The model of the damper tells it with less noise and is wrong under a fault. An extended Kalman filter weighs the two:

.. math::  x' = v, \quad v' = y_1 - y_2, \quad \tau f' = -f + f_c \rho \tanh(k_1 x + c_1 v), \quad d' = w, \quad
           -\theta m_s y_1 = (k_s + k_0) x + c_0 v + f + d

with the accelerations as inputs, whose error between two samples is in proportion to how they bend there, and d for
all that the model does not hold. The variance q of w follows the innovations: while they are larger than their
covariance it grows, at once after one that is far too large, else it falls. So a healthy damper is filtered by its
model, and under a fault the filter is the balance with a filtered deflection. The force never leaves

.. math::  |\hat F - F_b| \le 4 \sigma_b

which is what is promised for any damper, fault, friction and road (docs/observers.md). sigma_x is that of the rig's
file, or more where the second differences of x_m less those of the accelerations show more.

*A sensor that hangs, jumps or is missing* shows in what the
accelerations alone predict of it, eight deviations away. From that sample on the
observer of the two accelerometers answers. The sensor is believed again when its samples go on from what was predicted
over `SKIPS` samples at most, or when its difference from the observer's own deflection is for `RETURN` seconds what it
used to be, in the mean and in the mean square.

*An accelerometer that is wrong* draws the motion that both predict to one side of the sensor. The mean of these
innovations over their root mean square shows it; the estimate goes on, degraded, since nobody knows which of the two
accelerometers it is.

*The load.* k_s x_m is regressed on m_s y_1, c_0 v and f, all through one band around the body's resonance: what a
damper loses shows in the coefficients of v and f, and what the body weighs in that of y_1, a quarter of a period apart.
Only the damper's own stiffness k_0 is not told from mass: a leak that takes it away looks like (k_s + k_0) / (k_s + f
k_0) times the mass. So what the regression says is an interval, and theta moves only as far as it must: a load that the
interval and its error allow stays.

Source: ours. Innovation-based adaptation: Mehra 1970; test of innovations: Bar-Shalom, Li and Kirubarajan 2001, 11.2.
"""

from __future__ import annotations

import math

import numpy as np
from er_models.linear import LinearForm
from er_models.model import Array

from er_observers.forms import SENSORS
from er_observers.observers.compiled import compiled
from er_observers.observers.gate import gate_of
from er_observers.observers.payload import HIGH, LOW

BAND = 4.0
"""Deviations of the balance that the fused force may be away from it."""
ROUGH, ROUGH_X = 0.06, 0.03
"""Error of the integrated acceleration over a sample, in shares of dt times its second difference, and that of the
deflection in shares of dt^2. On ISO roads 0.058 and 0.002 are left; a larger one weighs the sensor more."""
BENT = 0.8
"""Share of the parabola through three samples that the relative acceleration follows within the last step."""
PATH = 4
"""Pieces of a sample along which the gate is integrated."""
WINDOW, WINDOW_X = 0.25, 2.0
"""Averages of the bend, and of the second differences of the deflection [s]."""
SPEED_UP, FAR, SHARE, USUAL, SETTLED = 0.05, 36.0, 0.1, 9.0, 20.0
"""How fast q follows the innovations; squared innovation over its variance from which q is set at once, to which share
of that square; the largest that counts else; samples before that."""
LEAST, MOST = 3e-5, 1e6
"""Bounds of q: in variances of m_s y_1, and [N2]."""
GATE = 64.0
"""Squared innovation of the deflection over its variance that is no sensor's."""
CAREFUL = 4.0
"""How much larger the error of the integrated acceleration is taken for where the sensor is judged."""
ALIAS = 0.085
"""Error of the second difference of the deflection in shares of dt^2 times the bend: above what ISO roads leave."""
SKIPS = 1
"""Samples in a row that may be refused before the sensor is believed only after `RETURN`."""
LEARNT, UNKNOWN = 40.0, 5.0
"""Second differences before the sensor's noise counts as known; before, it is taken for so many times the file's."""
WARM = 100.0
"""Samples before the band's outputs are used."""
FASTEST = 1.0
"""Deviation of the first velocity [m/s]."""
RETURN = 0.5
"""Time for which a sensor must be as usual before it is believed again [s]."""
HUNG = 2.0
"""Repetitions of the last value that are a sensor that hangs, where the car moves by as many deviations a sample."""
ALONG = 0.5
"""Average of the innovations of the deflection, by which the accelerometers are judged [s]."""
AWAY, NEAR = 0.15, 0.05
"""Square of their mean over their mean square above which the accelerometers contradict the sensor, and below which no
more. Healthy sensors stay below 0.02 on ISO roads and bumps, and below 0.1 on a step with a duty that switches."""
ALIKE = 9.0
"""How many times its usual size a squared difference from the observer's own deflection may be for a return."""
EDGES = (4.0, 40.0)
"""Band of the regression for a body of 24.8 rad/s; scaled with the body's frequency."""
BODY = 24.8
MEMORY = 20.0
"""Time after which a lesson of the load counts a third [s]."""
ENOUGH = 1.0
"""Time in motion before the load may move [s]."""
LEAK = 1.15
"""Loss of stiffness over the loss of damping that is found, at most."""
UNEXPLAINED = 2.0
"""What the share that the regression leaves unexplained adds to its error: friction and noise bias it by that share."""
UNSURE = 3.0
"""Standard deviations of the regression that a load may be off without being moved."""

(
    ON, LEARNS, M_S, K_S, K_0, C_0, F_C, PER_TAU, K_1, C_1, NOISE_A, NOISE_X, EDGE_LOW, EDGE_HIGH, STANDING, YIELD,
    USUAL_X,
) = range(17)  # fmt: skip
NUMBERS = USUAL_X + 1
(X, V, F, D, P00, P01, P02, P03, P11, P12, P13, P22, P23, P33) = range(14)
(
    Q, BEND, APART, CHANGE, LAST_X, PAST_X, PAST_APART, SECOND, NOISE, TRUST, SKIPPED, BACK, MEAN, SQUARE, MEAN_USUAL,
    SQUARE_USUAL, THETA, TIME, SAMPLES, WIDTH, KIN_X, KIN_V, KIN_00, KIN_01, KIN_11, KNOWN, SAME, DRIFT, SPREAD,
    ADRIFT, DIFFER,
) = range(14, 45)  # fmt: skip
FILTERS = 45
"""Three signals (m_s y_1, x_m, f) with five numbers each."""
SUMS = FILTERS + 15
SIZE = SUMS + 10
NEVER, BELIEVED, REFUSED = 0.0, 1.0, 2.0
"""What is thought of the deflection sensor; NEVER: it was never there."""


def numbers_of(
    form: LinearForm, acceleration: float, deflection: float, size: float, *, learns: bool
) -> Array:
    """What the fusion takes of a model (17,); all zero where it cannot be done.

    Needs the four relative states with a yield force that only the gate drives, and gains for two accelerometers.
    acceleration [m/s2], deflection [m]: noise of the sensors; size: of the deflection [m]; learns: whether the load is
    estimated.
    """
    numbers = np.zeros(NUMBERS)
    at = int(np.argmax(np.abs(form.B)))
    lone = form.n == 4 and not np.any(np.delete(form.A[at], at)) and not form.C[0, 2]
    if not (lone and form.C.shape[0] < len(SENSORS) and form.C[0, 0] < 0.0 and form.F[at]):
        return numbers
    m_s = -form.F[at] / form.C[0, at]
    numbers[[ON, LEARNS, M_S, YIELD]] = 1.0, float(learns), m_s, at
    numbers[K_0], numbers[C_0] = form.F[0], form.F[1]
    numbers[K_S] = -m_s * form.C[0, 0] - form.F[0]
    numbers[F_C], numbers[PER_TAU] = -form.B[at] / form.A[at, at] * form.F[at], -form.A[at, at]
    numbers[K_1], numbers[C_1] = form.Gamma[:2]
    numbers[NOISE_A], numbers[NOISE_X] = acceleration, deflection
    scale = math.sqrt(-form.C[0, 0]) / BODY
    numbers[EDGE_LOW], numbers[EDGE_HIGH] = scale * EDGES[0], scale * EDGES[1]
    numbers[STANDING] = (10.0 * m_s * acceleration) ** 2
    numbers[USUAL_X] = 0.005 * size
    return numbers


def begin() -> Array:
    """Memory (70,) before any deflection."""
    memory = np.zeros(SIZE)
    memory[THETA] = 1.0
    return memory


def interrupted(memory: Array) -> Array:
    """Memory (70,) where the next sample does not follow this one: what was learnt stays."""
    kept = memory.copy()
    kept[SAMPLES] = 0.0
    return kept


@compiled
def _begin(p: Array, w: Array, seen: float, v: float, f: float) -> None:
    """Start the filter, in place, at a deflection that was seen, with the observer's own velocity and yield force."""
    w[X], w[V], w[F], w[D] = seen, v, f, 0.0
    for i in range(P00, P33 + 1):
        w[i] = 0.0
    if w[KNOWN] < LEARNT:
        w[NOISE] = UNKNOWN * p[NOISE_X]
    noise, balance = w[NOISE] * w[NOISE], p[M_S] * p[NOISE_A]
    w[P00], w[P11], w[P22] = noise, FASTEST * FASTEST, p[F_C] * p[F_C]
    w[P33] = p[C_0] * p[C_0] * w[P11]
    w[KIN_X], w[KIN_V], w[KIN_00], w[KIN_01], w[KIN_11] = seen, v, noise, 0.0, w[P11]
    w[Q] = max(w[Q], balance * balance)
    w[LAST_X], w[PAST_X], w[SAMPLES], w[CHANGE] = seen, math.nan, 1.0, 0.0
    w[DRIFT] = w[SPREAD] = w[ADRIFT] = 0.0
    for i in range(FILTERS, SUMS):
        w[i] = 0.0
    w[FILTERS + 5] = seen


@compiled
def _innovation(p: Array, w: Array, seen: float, now: float, dt: float) -> float:
    """Squared innovation of the sensor over its variance, by the accelerations alone; NaN where nothing was seen [m].

    The motion that they predict is corrected, in place, where that is below `GATE`.
    """
    bend = now - w[APART] - w[CHANGE]
    x = w[KIN_X] + dt * w[KIN_V] + dt * dt * (w[APART] / 3.0 + now / 6.0)
    v = w[KIN_V] + 0.5 * dt * (w[APART] + now) - BENT / 12.0 * dt * bend
    noise = CAREFUL * _noise_of_speed(p, w, bend, dt)
    a = w[KIN_00] + dt * (2.0 * w[KIN_01] + dt * w[KIN_11]) + 0.25 * dt * dt * noise
    b = w[KIN_01] + dt * w[KIN_11] + 0.5 * dt * noise
    c = w[KIN_11] + noise
    s, innovation = a + w[NOISE] * w[NOISE], seen - x
    far = innovation * innovation / s
    if far < GATE:
        _judge(w, innovation / math.sqrt(s), dt)
        x, v = x + a / s * innovation, v + b / s * innovation
        a, b, c = a - a * a / s, b - a * b / s, c - b * b / s
    w[KIN_X], w[KIN_V], w[KIN_00], w[KIN_01], w[KIN_11] = x, v, a, b, c
    return float(far)


@compiled
def _judge(w: Array, innovation: float, dt: float) -> None:
    """Follow, in place, whether innovations, each over its deviation, lie to one side."""
    weight = min(1.0, dt / ALONG)
    w[DRIFT] += weight * (innovation - w[DRIFT])
    w[SPREAD] += weight * (innovation * innovation - w[SPREAD])
    if w[SAMPLES] > SETTLED:
        limit = NEAR if w[ADRIFT] > 0.0 else AWAY
        w[ADRIFT] = 1.0 if w[DRIFT] * w[DRIFT] > limit * w[SPREAD] else 0.0


@compiled
def _noise_of_speed(p: Array, w: Array, bend: float, dt: float) -> float:
    """Variance that a sample adds to the integrated velocity [m2/s2]."""
    rough = max(w[BEND], bend * bend)
    return float((dt * p[NOISE_A]) ** 2 + (ROUGH * dt) ** 2 * rough)


@compiled
def _path(
    p: Array, w: Array, x: float, v: float, now: float, rho: float, dt: float
) -> tuple[float, float, float]:
    """Yield force dt [s] later and its derivatives by the gate's input at both ends.

    The velocity follows the cubic between (w[V], w[APART]) and (v, now).
    """
    keep = math.exp(-p[PER_TAU] * dt / PATH)
    s_0 = p[K_1] * w[X] + p[C_1] * w[V]
    t_0, area_0 = gate_of(s_0)
    s, t, area, f, drive = s_0, t_0, area_0, w[F], (1.0 - keep) * p[F_C] * rho
    for k in range(1, PATH + 1):
        h = k / PATH
        way, left = h * h * (3.0 - 2.0 * h), 1.0 - h
        speed = w[V] + (v - w[V]) * way + dt * h * left * (left * w[APART] - h * now)
        s_k = p[K_1] * (w[X] + (x - w[X]) * h) + p[C_1] * speed
        t_k, area_k = gate_of(s_k)
        gate = (area_k - area) / (s_k - s) if abs(s_k - s) > 1e-3 else 0.5 * (t + t_k)
        f = keep * f + drive * gate
        s, t, area = s_k, t_k, area_k
    whole = (1.0 - keep**PATH) * p[F_C] * rho
    if abs(s - s_0) > 1e-3:
        gate = (area - area_0) / (s - s_0)
        return f, whole * (gate - t_0) / (s - s_0), whole * (t - gate) / (s - s_0)
    slope = 0.5 * whole * (1.0 - t * t)
    return f, slope, slope


@compiled
def _predict(p: Array, w: Array, now: float, rho: float, dt: float) -> None:
    """Move the filter dt [s] on, in place; now: relative acceleration at its end [m/s2], rho: duty during it."""
    change = now - w[APART]
    bend = change - w[CHANGE]
    w[BEND] += min(1.0, dt / WINDOW) * (bend * bend - w[BEND])
    v = w[V] + 0.5 * dt * (w[APART] + now) - BENT / 12.0 * dt * bend
    x = w[X] + dt * w[V] + dt * dt * (w[APART] / 3.0 + now / 6.0)
    f, first, last = _path(p, w, x, v, now, rho, dt)
    keep = math.exp(-p[PER_TAU] * dt)
    a_x, a_v = p[K_1] * (first + last), p[C_1] * (first + last) + p[K_1] * dt * last
    p00, p01, p02, p03, p11 = w[P00], w[P01], w[P02], w[P03], w[P11]
    p12, p13, p22, p23 = w[P12], w[P13], w[P22], w[P23]
    noise, rough = _noise_of_speed(p, w, bend, dt), max(w[BEND], bend * bend)
    half, gate = 0.5 * dt, last * (p[C_1] + 0.5 * dt * p[K_1])
    w[P00] = p00 + dt * (2.0 * p01 + dt * p11) + noise * half * half
    w[P00] += (ROUGH_X * dt * dt) ** 2 * rough
    w[P01] = p01 + dt * p11 + noise * half
    w[P02] = (p00 + dt * p01) * a_x + (p01 + dt * p11) * a_v + (p02 + dt * p12) * keep
    w[P02] += noise * half * gate
    w[P03], w[P11] = p03 + dt * p13, p11 + noise
    w[P12] = p01 * a_x + p11 * a_v + p12 * keep + noise * gate
    w[P22] = a_x * (a_x * p00 + 2.0 * a_v * p01) + a_v * a_v * p11
    w[P22] += keep * (2.0 * (a_x * p02 + a_v * p12) + keep * p22) + noise * gate * gate
    w[P23] = a_x * p03 + a_v * p13 + keep * p23
    w[P33] += w[Q]
    w[X], w[V], w[F], w[CHANGE] = x, v, f, change


@compiled
def _correct(w: Array, g: tuple[float, float, float, float], s: float, innovation: float) -> None:
    """Kalman's correction in place; g: covariance of the state with what is measured, s: variance of the innovation."""
    a, b, c, d = g
    per = 1.0 / s
    share = per * innovation
    w[X] += a * share
    w[V] += b * share
    w[F] += c * share
    w[D] += d * share
    w[P00] -= a * a * per
    w[P01] -= a * b * per
    w[P02] -= a * c * per
    w[P03] -= a * d * per
    w[P11] -= b * b * per
    w[P12] -= b * c * per
    w[P13] -= b * d * per
    w[P22] -= c * c * per
    w[P23] -= c * d * per
    w[P33] -= d * d * per


@compiled
def _weigh(p: Array, w: Array, sprung: float, of_x: float) -> None:
    """Correct by the balance and let q follow; of_x: squared innovation of the deflection over its variance."""
    h_0, h_1 = p[K_S] + p[K_0], p[C_0]
    a = w[P00] * h_0 + w[P01] * h_1 + w[P02] + w[P03]
    b = w[P01] * h_0 + w[P11] * h_1 + w[P12] + w[P13]
    c = w[P02] * h_0 + w[P12] * h_1 + w[P22] + w[P23]
    d = w[P03] * h_0 + w[P13] * h_1 + w[P23] + w[P33]
    mass = w[THETA] * p[M_S]
    usual = (mass * p[NOISE_A]) ** 2
    s = usual + h_0 * a + h_1 * b + c + d
    innovation = -mass * sprung - (h_0 * w[X] + h_1 * w[V] + w[F] + w[D])
    _correct(w, (a, b, c, d), s, innovation)
    size = innovation * innovation / s
    if size > FAR and w[SAMPLES] > SETTLED:
        w[Q] = max(w[Q], SHARE * innovation * innovation)
    w[Q] *= math.exp(SPEED_UP * (0.5 * (min(size, USUAL) + min(of_x, USUAL)) - 1.0))
    w[Q] = min(max(w[Q], LEAST * usual), MOST)


@compiled
def _noise(p: Array, w: Array, seen: float, now: float, dt: float) -> None:
    """Follow the noise of the sensor by its second differences, less those that the accelerations explain."""
    second = seen - 2.0 * w[LAST_X] + w[PAST_X]
    second -= dt * dt * (now + 4.0 * w[APART] + w[PAST_APART]) / 6.0
    if math.isfinite(second):
        w[KNOWN] += 1.0
        weight = max(dt / WINDOW_X, 1.0 / w[KNOWN])
        square = second * second
        if w[KNOWN] > LEARNT:
            square = min(square, GATE * w[SECOND])
        w[SECOND] += weight * (square - w[SECOND])
    bent = (ALIAS * dt * dt) ** 2 * w[BEND]
    told = p[NOISE_X] * p[NOISE_X]
    if w[KNOWN] >= LEARNT:
        w[NOISE] = math.sqrt(max(told, (w[SECOND] - bent) / 6.0))


@compiled
def _differs(p: Array, w: Array, seen: float, own: float, dt: float) -> bool:
    """Follow what the sensor differs by from the observer's own deflection; whether it is as usual [m]."""
    apart, weight = seen - own, dt / RETURN
    w[MEAN] += weight * (apart - w[MEAN])
    w[SQUARE] += weight * (apart * apart - w[SQUARE])
    if w[TRUST] == BELIEVED:
        weight *= 0.1
        w[MEAN_USUAL] += weight * (w[MEAN] * w[MEAN] - w[MEAN_USUAL])
        w[SQUARE_USUAL] += weight * (w[SQUARE] - w[SQUARE_USUAL])
    least = p[USUAL_X] * p[USUAL_X]
    alike = w[MEAN] * w[MEAN] < ALIKE * max(w[MEAN_USUAL], least)
    return bool(alike and w[SQUARE] < ALIKE * max(w[SQUARE_USUAL], least))


@compiled
def fuse(
    p: Array, w: Array, sprung: float, unsprung: float, seen: float, own: Array, rho: float,
    dt: float,
) -> tuple[bool, float, float, float]:  # fmt: skip
    """Take a sample into the memory w (70,), in place: whether the sensor is believed, force [N], deflection, velocity.

    own (n,): the observer's estimate, with which the filter begins; rho: duty in force for dt [s] until now.
    """
    now, there = sprung - unsprung, math.isfinite(seen)
    if p[ON] == 0.0 or (w[TRUST] == NEVER and not there):
        return False, 0.0, 0.0, 0.0
    alike = there and _differs(p, w, seen, own[0], dt)
    if w[SAMPLES] == 0.0 or (w[TRUST] == REFUSED and w[SKIPPED] > SKIPS):
        w[BACK] = w[BACK] + dt if alike else 0.0
        if there and (w[TRUST] != REFUSED or w[BACK] > RETURN):
            w[TRUST], w[SKIPPED] = BELIEVED, 0.0
            _begin(p, w, seen, own[1], own[int(p[YIELD])])
            _weigh(p, w, sprung, 1.0)
            w[APART] = w[PAST_APART] = now
            w[FILTERS] = p[M_S] * sprung
            return _answer(p, w, sprung, seen)
        w[TRUST] = REFUSED
        return False, 0.0, 0.0, 0.0
    past, far = w[APART], _innovation(p, w, seen, now, dt)
    _predict(p, w, now, rho, dt)
    w[SAME] = w[SAME] + 1.0 if seen == w[LAST_X] else 0.0
    hangs = w[SAME] >= HUNG and abs(w[KIN_V]) * dt > HUNG * w[NOISE]
    good, of_x = far < GATE and not hangs, 1.0
    if good:
        _noise(p, w, seen, now, dt)
        s, innovation = w[P00] + w[NOISE] * w[NOISE], seen - w[X]
        of_x = innovation * innovation / s
        _correct(w, (w[P00], w[P01], w[P02], w[P03]), s, innovation)
    _weigh(p, w, sprung, of_x)
    w[PAST_X], w[LAST_X] = w[LAST_X], seen if good or hangs else math.nan
    w[PAST_APART], w[APART] = past, now
    w[SAMPLES] += 1.0
    if not good:
        w[SKIPPED] += 1.0
        w[TRUST], w[BACK] = REFUSED, 0.0
        return False, 0.0, 0.0, 0.0
    w[TRUST], w[SKIPPED] = BELIEVED, 0.0
    if p[LEARNS] > 0.0:
        _learn(p, w, sprung, seen, dt)
    return _answer(p, w, sprung, seen)


@compiled
def _answer(p: Array, w: Array, sprung: float, seen: float) -> tuple[bool, float, float, float]:
    """The force within its band about the balance, with deflection and velocity."""
    force = p[K_0] * w[X] + p[C_0] * w[V] + w[F] + w[D]
    return True, banded(p, w, force, sprung, seen), w[X], w[V]


@compiled
def banded(p: Array, w: Array, force: float, sprung: float, seen: float) -> float:
    """A force [N] within the band about the balance; sprung [m/s2], seen [m]: what the sensors say."""
    mass = w[THETA] * p[M_S]
    balance = -mass * sprung - p[K_S] * seen
    band = BAND * math.sqrt((mass * p[NOISE_A]) ** 2 + (p[K_S] * w[NOISE]) ** 2)
    return float(min(max(force, balance - band), balance + band))


@compiled
def _filtered(p: Array, w: Array, at: int, value: float, dt: float) -> tuple[float, float]:
    """A signal through the band: two high passes, two low passes; before and after the sample."""
    low = 1.0 / (1.0 + dt * p[EDGE_LOW])
    high = dt * p[EDGE_HIGH] / (1.0 + dt * p[EDGE_HIGH])
    first = low * (w[at + 1] + value - w[at])
    second = low * (w[at + 2] + first - w[at + 1])
    before = w[at + 4]
    w[at], w[at + 1], w[at + 2] = value, first, second
    w[at + 3] += high * (second - w[at + 3])
    w[at + 4] += high * (w[at + 3] - before)
    return before, w[at + 4]


@compiled
def _learn(p: Array, w: Array, sprung: float, seen: float, dt: float) -> None:
    """Regress the springs' force on inertia, velocity and yield force, and move the load as far as it must."""
    a_0, a_1 = _filtered(p, w, FILTERS, p[M_S] * sprung, dt)
    x_0, x_1 = _filtered(p, w, FILTERS + 5, seen, dt)
    f_0, f_1 = _filtered(p, w, FILTERS + 10, w[F], dt)
    if w[SAMPLES] < WARM:
        return
    a, v, f = 0.5 * (a_0 + a_1), p[C_0] * (x_1 - x_0) / dt, 0.5 * (f_0 + f_1)
    u = -0.5 * (p[K_S] + p[K_0]) * (x_0 + x_1)
    if a * a + u * u < p[STANDING] and w[SUMS + 9] < p[STANDING] * w[TIME]:
        return
    fade, at = 1.0 - dt / MEMORY, SUMS
    z = (a, v, f, u)
    for i in range(4):
        for j in range(i, 4):
            w[at] = fade * w[at] + dt * z[i] * z[j]
            at += 1
    w[TIME] = fade * w[TIME] + dt
    if w[TIME] > ENOUGH:
        _move(p, w, dt)


@compiled
def _move(p: Array, w: Array, dt: float) -> None:
    """Move the load theta, in place, into the interval of the regression where it is not within it and its error."""
    aa, av, af, au = w[SUMS], w[SUMS + 1], w[SUMS + 2], w[SUMS + 3]
    vv, vf, vu = w[SUMS + 4], w[SUMS + 5], w[SUMS + 6]
    ff, fu, uu = w[SUMS + 7], w[SUMS + 8], w[SUMS + 9]
    vv -= w[TIME] * _speed_noise(p, w, dt)
    if not (vv > 0.0 and ff > 0.0 and uu > 0.0):
        return
    # eliminate f, then v: what is left of a and u
    aa, av, au = aa - af * af / ff, av - af * vf / ff, au - af * fu / ff
    vv, vu, uu_f = vv - vf * vf / ff, vu - vf * fu / ff, uu - fu * fu / ff
    if not (vv > 1e-6 * aa and aa > 0.0):
        return
    left = aa - av * av / vv
    if not left > 1e-3 * aa:
        return
    ratio = (au - av * vu / vv) / left
    damping = (vu - ratio * av) / vv
    rest = max(uu_f - ratio * au - damping * vu, 0.0)
    error = math.sqrt(rest / (left * w[TIME] * p[EDGE_HIGH] * 0.25)) * UNSURE
    error += UNEXPLAINED * rest / uu
    kept = min(max(1.0 - LEAK * (1.0 - damping), 0.0), 1.0)
    low = ratio * (p[K_S] + kept * p[K_0]) / (p[K_S] + p[K_0])
    w[WIDTH] = ratio - low
    theta = w[THETA]
    if theta < low - error:
        theta = low
    elif theta > ratio + error:
        theta = ratio
    w[THETA] = min(max(theta, LOW), HIGH)


@compiled
def _speed_noise(p: Array, w: Array, dt: float) -> float:
    """Power that the sensor's noise leaves in c_0 v behind the band [N2].

    Of a white noise's first difference two low passes of a weight h leave 2 (h / (2 - h))^3 of the noise's variance.
    """
    h = dt * p[EDGE_HIGH] / (1.0 + dt * p[EDGE_HIGH])
    return float(2.0 * (p[C_0] * w[NOISE] / dt) ** 2 * (h / (2.0 - h)) ** 3)
