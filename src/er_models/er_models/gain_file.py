"""Gain files of observers and controllers, value by value: each is checked, each complaint is one line."""

from __future__ import annotations

import hashlib
import json
import math
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from er_models.errors import InputError
from er_models.model import Array
from er_models.shipped import file_of
from er_models.yaml_file import read_yaml


@dataclass(frozen=True)
class Document:
    """A parsed file; values are asked for by dotted keys and raise `InputError` when unfit."""

    path: Path
    content: Mapping[str, Any]

    def at(self, key: str) -> Any:
        """Value at a key."""
        value: Any = self.content
        for part in key.split("."):
            if not isinstance(value, dict) or part not in value:
                raise InputError(self.path, key, "a value", "nothing")
            value = value[part]
        return value

    def number(self, key: str) -> float:
        """A finite number."""
        return float(self._finite(key, [self.at(key)])[0])

    def numbers(self, key: str, length: int) -> Array:
        """A list of finite numbers (length,)."""
        values = self.at(key)
        if not isinstance(values, list) or len(values) != length:
            raise InputError(self.path, key, f"a list of {length} numbers", values)
        return self._finite(key, values)

    def matrix(self, key: str, shape: tuple[int | None, ...]) -> Array:
        """A matrix given as shape and flat data; None in the shape stands for any length."""
        given, data = self.at(f"{key}.shape"), self.at(f"{key}.data")
        fits = isinstance(given, list) and len(given) == len(shape)
        fits = fits and all(w in (None, have) for w, have in zip(shape, given, strict=True))
        if not fits or not isinstance(data, list) or len(data) != math.prod(given):
            expected = " x ".join("any" if s is None else str(s) for s in shape)
            found = f"shape {given}"
            raise InputError(self.path, key, f"a matrix {expected} with as many entries", found)
        return self._finite(key, data).reshape(given)

    def _finite(self, key: str, values: list[Any]) -> Array:
        """Numbers, all finite."""
        for value in values:
            real = isinstance(value, int | float) and not isinstance(value, bool)
            if not real or not math.isfinite(value):
                raise InputError(self.path, key, "finite numbers", repr(value))
        return np.array(values, float)


def read(given: str | Path) -> Document:
    """Parsed YAML mapping of a file, or of the shipped gains of a name (`unified`)."""
    path = file_of(given, "gains")
    content = read_yaml(path, "a gain file")
    if not isinstance(content, dict):
        raise InputError(path, "", "a mapping of names to values", type(content).__name__)
    return Document(path, content)


def digest(content: Mapping[str, Any]) -> str:
    """Hash of everything but the digest itself."""
    rest = {key: value for key, value in content.items() if key != "digest"}
    return hashlib.sha256(json.dumps(rest, sort_keys=True, default=str).encode()).hexdigest()[:16]


def flat(matrix: Array) -> dict[str, list[Any]]:
    """Shape and entries row by row."""
    return {"shape": list(matrix.shape), "data": [float(v) for v in np.ravel(matrix)]}
