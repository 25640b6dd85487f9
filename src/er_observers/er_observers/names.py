"""Names of the observers: for the graph, parameters and files, which need none of their code."""

from __future__ import annotations

OBSERVERS = ("unified", "nlpv_polytopic", "nlpv_gridding")
"""Each has a theorem in `synthesis`, a file in `observers`, gains in `config/gains` and a node."""
