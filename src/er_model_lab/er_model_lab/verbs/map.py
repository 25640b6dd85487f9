"""What the columns of somebody's own files are."""

from __future__ import annotations

from collections.abc import Mapping
from pathlib import Path
from typing import Any

from er_records.mapping.mapping import Mapped, mapped


def map(path: str | Path, names: Mapping[str, Any] | None = None) -> Mapped:
    """The columns of a file or folder with unit, range and rate, and what they probably are, by channel.

    `names` of the result is what `load(names=...)` takes; `save()` writes it as `names.yaml` into the folder, where
    every later `load` finds it. names: what is known already, such as `{"damper_force": "Kraft [kN]"}`.

    Raises:
        InputError: No measurement, or a column in names that is not there.
    """
    return mapped(path, names)
