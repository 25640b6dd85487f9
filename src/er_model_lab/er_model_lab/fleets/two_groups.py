r"""Two dampers under one name: values of a unit that fall into two groups, whatever the order of its recordings.

Whether they scatter more than chance makes them is Fisher's test of their variance against the spread within the units
of the fleet. The form is that with the least Bayesian information criterion: one wide normal distribution, a change
along an axis, or two normal ones, as narrow as the fleet's are, with each value in the nearer one (classification
likelihood; Celeux and Govaert 1992).
"""

from __future__ import annotations

import math

import numpy as np
from scipy.stats import f as fisher

from er_model_lab.fleets.pooled import Array
from er_model_lab.fleets.trends import Trend

LEAST, SHARE = 3, 0.1
"""Values that make a group, and the share of all that do: a few far off are outliers."""


def two_groups(y: Array, variance: Array, freedom: int, along: float = math.inf) -> Trend | None:
    """Groups that values y (n,) with these variances fall into; None for too few values.

    freedom: degrees of freedom that the variances rest on; along: criterion of the best change along an axis. The form
    is `groups`: `low` and `high` are the means of the two, `at` lies between. p is 1 where another form describes
    the values as well.
    """
    n = y.size
    least = max(LEAST, math.ceil(SHARE * n))
    if n < 2 * least:
        return None
    order = np.argsort(y, kind="stable")
    y, w = y[order], 1.0 / variance[order]
    left = float(np.sum(w * (y - np.sum(w * y) / w.sum()) ** 2))
    below, sums = np.cumsum(w), np.cumsum(w * y)
    low, high = sums[:-1] / below[:-1], (sums[-1] - sums[:-1]) / (below[-1] - below[:-1])
    gains = (high - low) ** 2 * below[:-1] * (below[-1] - below[:-1]) / below[-1]
    first = np.arange(1.0, n)
    mixed = -2.0 * (first * np.log(first / n) + (n - first) * np.log(1.0 - first / n))
    costs = (left - gains + mixed + 2.0 * math.log(n))[least - 1 : n - least]
    k = least - 1 + int(np.argmin(costs))
    cost = float(costs.min())
    wide = n * (math.log(max(left / n, 1e-300)) + 1.0) + math.log(n)
    p = float(fisher.sf(left / (n - 1), n - 1, freedom)) if cost < min(wide, along, left) else 1.0
    sd = math.sqrt(1.0 / below[k] + 1.0 / (below[-1] - below[k]))
    at = 0.5 * float(y[k] + y[k + 1])
    return Trend("groups", at, float(low[k]), float(high[k]), float(high[k] - low[k]), sd, p, cost)
