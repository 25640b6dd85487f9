r"""The regression that (6.8) is: linear in f_2 k_0, f_2 f_3 c_0, f_1 f_2 f_3, and in errors of the model.

.. math::  -m_s \ddot z_s - k_s x = f_2 k_0 x + f_2 f_3 (c_0 v + f_1 F_{er})
           + \delta_s k_s x + b + f_1 f_2 f_3 \sum_q \delta_q\, \partial F_{er} / \partial \ln q

with q = tau, k_1, c_1. A wrong mass is no column: it scales all others alike (`rules.py`), and as a column it would
explain everything, the noise of the acceleration included. Where a force is given it takes the place of the left side.
x, v and F_er are those of `follow`, whose innovations are the rows: y = innovation + phi beta_expected.

Source: thesis (6.8), (1.12), (1.8).
"""

from __future__ import annotations

NAMES = ("k0", "c0", "f_c", "k_s", "offset", "tau", "k1", "c1")
"""Unknowns: shares of the first three (1 healthy) and relative errors; offsets in N."""
K0, C0, SIGMA, BETA, K1, C1, TAU, M_S, K_S, M_US, K_T = range(11)
"""Places of the damper's and the car's constants in p (11,)."""
