"""The force of measured terms (`er_models.measured`), from the numbers behind the parameters of the effects.

how many, lagged quantity (-1: none), rate of its lag; then of each term: both quantities (-1: no second), what it
is multiplied by (-1: nothing), n and m, n + 4 knots, m + 4 knots of the second, n m coefficients
"""

from __future__ import annotations

from er_models.kernel.fast import inner

HEAD, OF_TERM = 3, 5
"""Numbers before the first term, and before the knots of each."""


@inner
def signal(code, x, v, a, u, u_f, f_y, theta, f_d, lagged):
    """The quantity of a place in `measured.QUANTITIES`, of the one behind them that which is lagged."""
    if code < 4.0:
        if code < 2.0:
            return x if code < 1.0 else v
        return a if code < 3.0 else u
    if code < 6.0:
        return u_f if code < 5.0 else f_y
    if code < 7.0:
        return theta
    return f_d if code < 8.0 else lagged


@inner
def spline(p, k, n, q):
    """The first of the four cubic B-splines (of n, knots from p[k] on) that act at q, and their values (de Boor)."""
    q = min(max(q, p[k + 3]), p[k + n])
    i = 3
    while i < n - 1 and q >= p[k + i + 1]:
        i += 1
    k += i
    l1, l2, l3 = q - p[k], q - p[k - 1], q - p[k - 2]
    r1, r2, r3 = p[k + 1] - q, p[k + 2] - q, p[k + 3] - q
    b0, b1 = r1 / (r1 + l1), l1 / (r1 + l1)
    c0, c1 = b0 / (r1 + l2), b1 / (r2 + l1)
    b0, b1, b2 = r1 * c0, l2 * c0 + r2 * c1, l1 * c1
    c0, c1, c2 = b0 / (r1 + l3), b1 / (r2 + l2), b2 / (r3 + l1)
    return i - 3, r1 * c0, l3 * c0 + r2 * c1, l2 * c1 + r3 * c2, l1 * c2


@inner
def measured(p, at, x, v, a, u, u_f, f_y, theta, f_d, lagged):
    """Force of all terms [N], whose numbers begin at p[at]."""
    total, k = 0.0, at + HEAD
    for _ in range(int(p[at])):
        n, m = int(p[k + 3]), int(p[k + 4])
        knots = k + OF_TERM
        i, b0, b1, b2, b3 = spline(
            p, knots, n, signal(p[k], x, v, a, u, u_f, f_y, theta, f_d, lagged)
        )
        c, end = knots + n + 4, knots + n + 4 + n
        if p[k + 1] < 0.0:
            c += i
            force = b0 * p[c] + b1 * p[c + 1] + b2 * p[c + 2] + b3 * p[c + 3]
        else:
            j, d0, d1, d2, d3 = spline(
                p, c, m, signal(p[k + 1], x, v, a, u, u_f, f_y, theta, f_d, lagged)
            )
            c += m + 4
            end = c + n * m
            c += i * m + j
            force = 0.0
            for b in (b0, b1, b2, b3):
                force += b * (d0 * p[c] + d1 * p[c + 1] + d2 * p[c + 2] + d3 * p[c + 3])
                c += m
        if p[k + 2] >= 0.0:
            force *= signal(p[k + 2], x, v, a, u, u_f, f_y, theta, f_d, lagged)
        total += force
        k = end
    return total
