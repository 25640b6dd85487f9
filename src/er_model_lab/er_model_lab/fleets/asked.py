"""What a fleet is asked, and the names under which answers are kept."""

from __future__ import annotations

import hashlib
import platform
from collections.abc import Sequence
from dataclasses import astuple, dataclass
from functools import lru_cache
from importlib import import_module
from importlib.metadata import PackageNotFoundError, version

from er_models.cache.sources import state
from er_models.model import Model

from er_model_lab.diagnosis.rule import RULE, Rule

OURS = ("er_models", "er_common", "er_records", "er_model_lab")
LIBRARIES = (
    "numpy", "scipy", "numba", "scikit-learn", "pyarrow", "pandas", "rosbags", "asammdf", "h5py", "nptdms",
)  # fmt: skip
"""Packages whose versions decide a result."""
CARRIERS = ("dask", "distributed", "cloudpickle")
"""Packages that carry jobs: client and workers need the same, but no result depends on them."""


@dataclass(frozen=True)
class Asked:
    """The question to every unit.

    search: whether effects are searched for, or parameters only refitted; most: recordings of a unit that it is
    diagnosed with, at most; by_namespace: whether each namespace of a bag is a unit.
    """

    model: Model
    seed: int = 0
    rule: Rule = RULE
    anyway: bool = False
    search: bool = True
    most: int = 20
    by_namespace: bool = False

    def key(self, what: str, digests: Sequence[str]) -> str:
        """Name of an answer: by the content of the data, the model, the code and all that is asked."""
        asked = (
            what, *digests, self.model.digest(), self.seed, astuple(self.rule), self.anyway, self.by_namespace,
            *((self.search, self.most) if what in ("unit", "page") else ()),
            sorted((name, state) for name, state in code().items() if name not in CARRIERS),
        )  # fmt: skip
        return hashlib.sha256(repr(asked).encode()).hexdigest()


@lru_cache(maxsize=1)
def code() -> dict[str, str]:
    """What decides a result beside data and model: state of our sources, versions of Python and libraries."""
    found = {"python": ".".join(platform.python_version_tuple()[:2])}
    for name in OURS:
        import_module(name)
        found[name] = state(name)[0].rpartition("-")[2]
    for name in (*LIBRARIES, *CARRIERS):
        try:
            found[name] = version(name)
        except PackageNotFoundError:
            found[name] = "not installed"
    return found
