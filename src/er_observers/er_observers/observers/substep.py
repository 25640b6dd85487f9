"""What one substep of an observer does, as one matrix: looked up over the duty, or made, compiled.

A substep of h seconds at the duty rho, y going straight, mean gate g, takes

    z  to  phi_0(h M) z + h phi_1(h M) J y + h phi_2(h M) J (change of y) + h phi_1(h M) b rho g

so the matrix has the columns [phi_0, h phi_1 J, h phi_2 J, h phi_1 b], N + 2 m + 1 of them.
"""

from __future__ import annotations

from er_models.model import Array

from er_observers.observers.compiled import compiled
from er_observers.observers.copies import copy
from er_observers.observers.phi import fill_phi

_SLOTS = 2
"""Substeps of unusual length that are remembered: of a duty that stays, or two that alternate."""


def room_of(n: int, m: int) -> int:
    """Doubles that `made` needs for n states and m outputs."""
    return 7 * n * n + n * m + _SLOTS * (2 + n * (n + 2 * m + 1))


@compiled
def between(rho: float, duties: Array) -> tuple[int, float]:
    """Interval of the duties (K,) that rho lies in, and how far along it; the ends are held."""
    low, high = 0, duties.shape[0] - 1
    while high - low > 1:
        middle = (low + high) // 2
        if rho > duties[middle]:
            low = middle
        else:
            high = middle
    share = (rho - duties[low]) / (duties[high] - duties[low])
    return low, min(max(share, 0.0), 1.0)


@compiled
def look_up(rho: float, duties: Array, rows: Array, out: Array) -> None:
    """Into out (L,): the mean of the two rows (K L,) that enclose rho, on straight lines between."""
    k, share = between(rho, duties)
    size = out.shape[0]
    low, high = k * size, (k + 1) * size
    for i in range(size):
        out[i] = (1.0 - share) * rows[low + i] + share * rows[high + i]


@compiled
def fill_substep(M: Array, J: Array, b: Array, h: float, room: Array, out: Array) -> None:
    """Into out (N, N + 2 m + 1): the matrix of a substep h [s]; room (6, N, N).

    M (N, N), J (N, m) at its duty, b (N,) at duty 1.
    """
    n, m = J.shape
    phi, scaled = room[:3], room[3]
    for i in range(n):
        for j in range(n):
            scaled[i, j] = h * M[i, j]
    fill_phi(scaled, phi, room[4], room[5])
    for i in range(n):
        for j in range(n):
            out[i, j] = phi[0, i, j]
        for j in range(m):
            level = ramp = 0.0
            for k in range(n):
                level += phi[1, i, k] * J[k, j]
                ramp += phi[2, i, k] * J[k, j]
            out[i, n + j], out[i, n + m + j] = h * level, h * ramp
        gate = 0.0
        for k in range(n):
            gate += phi[1, i, k] * b[k]
        out[i, n + 2 * m] = h * gate


@compiled
def made(law: Array, k: int, n: int, m: int, rho: float, h: float, room: Array) -> Array:
    """The matrix (N (N + 2 m + 1),) of a substep h [s] at a duty, remembered or made anew.

    law: duties (K,), M (K, N, N), J (K, N, m), b (N,), one after the other. room: of `room_of`; what
    it remembers is what would be made again. Comparisons with NaN are false.
    """
    square, at = n * n, k + k * n * n
    J_at = 7 * square
    width, slots = n + 2 * m + 1, J_at + n * m
    kept = room[slots:].reshape((_SLOTS, 2 + n * width))
    last: Array = kept[_SLOTS - 1]
    for slot in range(_SLOTS):
        if kept[slot, 0] == rho and kept[slot, 1] == h:
            last = kept[slot]
            return last[2:]
    copy(kept[1:], kept[:-1])
    last[0], last[1] = rho, h
    M, J = room[6 * square : J_at], room[J_at:slots]
    look_up(rho, law[:k], law[k:at], M)
    look_up(rho, law[:k], law[at : at + k * n * m], J)
    at += k * n * m
    rooms = room[: 6 * square].reshape((6, n, n))
    out = last[2:].reshape((n, width))
    fill_substep(M.reshape((n, n)), J.reshape((n, m)), law[at : at + n], h, rooms, out)
    return last[2:]
