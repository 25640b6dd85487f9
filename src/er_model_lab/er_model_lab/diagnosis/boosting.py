"""Gradient-boosted regression trees on binned inputs, compiled.

Each tree lowers the squared error that those before it leave. It grows leaf by leaf, always where that lowers the error
most; sums over the bins of each input say where. They are small trees of few samples: a library for large ones spends
nine tenths of its time around them, and here its result comes out to rounding.

Source: Friedman 2001; sums over bins: Ke et al. 2017 (LightGBM).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from er_models.kernel.fast import entry, inner
from er_models.model import Array
from numpy.typing import NDArray

TREES, RATE = 80, 0.08
"""Trees, and the share of each that counts."""
LEAVES, LEAST, RIDGE = 12, 30, 1.0
"""Most leaves of a tree, fewest samples of a leaf, and samples without error that are added to each."""
BINS = 255
"""Most bins of an input, with as many samples each."""


@dataclass(frozen=True)
class Boosted:
    """A fitted regression.

    mean: where all begins; inputs, edges, after, values (trees, nodes): input that a node asks, the value up to which
    a sample goes to the node `after`, and to the one behind it else; -1 and what is added at a leaf.
    """

    mean: float
    inputs: NDArray[np.int64]
    edges: Array
    after: NDArray[np.int64]
    values: Array

    def predict(self, inputs: Array) -> Array:
        """The target (m,) at inputs (m, k)."""
        out = np.full(inputs.shape[0], self.mean)
        _added(np.ascontiguousarray(inputs), self.inputs, self.edges, self.after, self.values, out)
        return out


def boosted_trees(inputs: Array, target: Array) -> Boosted:
    """Trees fitted to a target (m,) by inputs (m, k)."""
    edges = [_edges(column) for column in inputs.T]
    bins = np.stack(
        [np.searchsorted(e, c, side="left") for e, c in zip(edges, inputs.T, strict=True)]
    )
    nodes = (TREES, 2 * LEAVES - 1)
    asked, at, after = np.full(nodes, -1), np.zeros(nodes, int), np.zeros(nodes, int)
    values, mean = np.zeros(nodes), float(target.mean())
    many = np.array([e.size + 1 for e in edges])
    _grow(bins.astype(np.uint8), many, target - mean, asked, at, after, values)
    width = max(int(many.max()) - 1, 1)
    table = np.stack([np.pad(e, (0, width - e.size)) for e in edges])
    return Boosted(mean, asked, table[np.maximum(asked, 0), at], after, values)


def _edges(column: Array) -> Array:
    """Values between the bins of an input (m,): between all of few, else equally many samples in each bin."""
    own = np.unique(column)
    if own.size <= BINS:
        return np.asarray(0.5 * (own[1:] + own[:-1]))
    shares = np.linspace(0.0, 100.0, BINS + 1)[1:-1]
    return np.unique(np.percentile(column, shares, method="averaged_inverted_cdf"))


@entry
def _added(
    inputs: Array, asked: NDArray[np.int64], edges: Array, after: NDArray[np.int64], values: Array, out: Array
) -> None:  # fmt: skip
    """Add to out (m,) what the trees say of inputs (m, k)."""
    for row in range(out.size):
        for tree in range(asked.shape[0]):
            node = 0
            while asked[tree, node] >= 0:
                right = inputs[row, asked[tree, node]] > edges[tree, node]
                node = after[tree, node] + right
            out[row] += values[tree, node]


@inner
def _summed(
    bins: NDArray[np.uint8], rows: NDArray[np.int64], pull: Array, sums: Array, counts: NDArray[np.int64]
) -> None:  # fmt: skip
    """Sums of the pull (m,) and counts of some rows in each bin of each input (k, BINS)."""
    for c in range(bins.shape[0]):
        for b in range(sums.shape[1]):
            sums[c, b], counts[c, b] = 0.0, 0
        for row in rows:
            b = bins[c, row]
            sums[c, b] += pull[row]
            counts[c, b] += 1


@inner
def _split(
    sums: Array, counts: NDArray[np.int64], many: NDArray[np.int64], size: int, total: float, shares: Array
) -> tuple[float, int, int]:  # fmt: skip
    """Where a leaf is split best: what that gains, which input, the last bin on the left; shares: 1 / (n + RIDGE)."""
    gain, column, bin_ = 0.0, -1, 0
    here = total * total * shares[size]
    for c in range(many.size):
        left, n = 0.0, 0
        for b in range(many[c] - 1):
            left += sums[c, b]
            n += counts[c, b]
            if n < LEAST:
                continue
            if size - n < LEAST:
                break
            right = total - left
            fall = left * left * shares[n] + right * right * shares[size - n] - here
            if fall > gain:
                gain, column, bin_ = fall, c, b
    return gain, column, bin_


@inner
def _parted(
    bins: NDArray[np.uint8], column: int, last: int, rows: NDArray[np.int64], scratch: NDArray[np.int64]
) -> int:  # fmt: skip
    """Sort rows, in place, into those up to a bin of an input and the others; how many go left."""
    n = m = 0
    for row in rows:
        if bins[column, row] <= last:
            rows[n] = row
            n += 1
        else:
            scratch[m] = row
            m += 1
    for k in range(m):
        rows[n + k] = scratch[k]
    return n


@inner
def _look(
    node: int, leaf: NDArray[np.int64], total: Array, sums: Array, counts: NDArray[np.int64], many: NDArray[np.int64],
    shares: Array, cut: NDArray[np.int64], gain: Array,
) -> None:  # fmt: skip
    """Note where a node is split best, in gain (nodes,) and cut (nodes, 2); one that is too small gains nothing."""
    size, own = leaf[node, 1] - leaf[node, 0], leaf[node, 2]
    gain[node] = 0.0
    if size >= 2 * LEAST:
        found = _split(sums[own], counts[own], many, size, total[node], shares)
        gain[node], cut[node, 0], cut[node, 1] = found


@inner
def _branch(
    node: int, size: int, slot: int, bins: NDArray[np.uint8], left: Array, rows: NDArray[np.int64],
    scratch: NDArray[np.int64], leaf: NDArray[np.int64], total: Array, sums: Array, counts: NDArray[np.int64],
    cut: NDArray[np.int64],
) -> None:  # fmt: skip
    """Split a node into the nodes `size` and `size + 1`.

    leaf (nodes, 3): its rows, from and to, and where its sums are. Those of the smaller child are counted, in a new
    slot; those of the other are what is left of the node's.
    """
    i, j, own = leaf[node]
    middle = i + _parted(bins, cut[node, 0], cut[node, 1], rows[i:j], scratch)
    leaf[size, 0], leaf[size, 1], leaf[size + 1, 0], leaf[size + 1, 1] = i, middle, middle, j
    few, rest = (size, size + 1) if middle - i < j - middle else (size + 1, size)
    leaf[few, 2], leaf[rest, 2] = slot, own
    _summed(bins, rows[leaf[few, 0] : leaf[few, 1]], left, sums[slot], counts[slot])
    for c in range(bins.shape[0]):
        for b in range(BINS):
            sums[own, c, b] -= sums[slot, c, b]
            counts[own, c, b] -= counts[slot, c, b]
    total[few] = 0.0
    for b in range(BINS):
        total[few] += sums[slot, 0, b]
    total[rest] = total[node] - total[few]


@inner
def _largest(gain: Array, size: int) -> int:
    """The first of the largest gains."""
    node = 0
    for other in range(1, size):
        if gain[other] > gain[node]:
            node = other
    return node


@inner
def _take(
    size: int, asked: NDArray[np.int64], rows: NDArray[np.int64], leaf: NDArray[np.int64], total: Array, shares: Array,
    values: Array, left: Array,
) -> None:  # fmt: skip
    """Note what the leaves of a tree of so many nodes add, and take it off what is left (m,)."""
    for node in range(size):
        if asked[node] < 0:
            i, j = leaf[node, 0], leaf[node, 1]
            values[node] = RATE * total[node] * shares[j - i]
            for place in range(i, j):
                left[rows[place]] -= values[node]


@entry
def _grow(
    bins: NDArray[np.uint8], many: NDArray[np.int64], left: Array, asked: NDArray[np.int64], at: NDArray[np.int64],
    after: NDArray[np.int64], values: Array,
) -> None:  # fmt: skip
    """Fill all trees (trees, nodes), one after the other; left (m,): what they shall explain, and leave in the end."""
    (k, m), nodes = bins.shape, asked.shape[1]
    sums, counts = np.empty((LEAVES, k, BINS)), np.empty((LEAVES, k, BINS), np.int64)
    rows, scratch, shares = np.empty(m, np.int64), np.empty(m, np.int64), np.empty(m + 1)
    leaf, cut = np.zeros((nodes, 3), np.int64), np.zeros((nodes, 2), np.int64)
    gain, total = np.empty(nodes), np.empty(nodes)
    for n in range(m + 1):
        shares[n] = 1.0 / (n + RIDGE)
    for row in range(m):
        rows[row] = row
    for tree in range(asked.shape[0]):
        leaf[0, 1], leaf[0, 2], total[0], size = m, 0, 0.0, 1
        for row in range(m):
            total[0] += left[row]
        _summed(bins, rows, left, sums[0], counts[0])
        _look(0, leaf, total, sums, counts, many, shares, cut, gain)
        for slot in range(1, LEAVES):
            node = _largest(gain, size)
            if not gain[node] > 0.0:
                break
            asked[tree, node], at[tree, node], after[tree, node] = cut[node, 0], cut[node, 1], size
            gain[node] = 0.0
            _branch(node, size, slot, bins, left, rows, scratch, leaf, total, sums, counts, cut)
            for child in range(size, size + 2):
                _look(child, leaf, total, sums, counts, many, shares, cut, gain)
            size += 2
        _take(size, asked[tree], rows, leaf, total, shares, values[tree], left)
