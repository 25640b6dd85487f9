"""What one section of the page is: a heading, figures, and the facts its template shows."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any

from er_model_lab.output.report.figure import Figure


@dataclass(frozen=True)
class Section:
    """One section; `key` names its anchor and, unless `template` does, its template `<key>.html.j2`."""

    key: str
    title: str
    figures: tuple[Figure, ...] = ()
    facts: Mapping[str, Any] = field(default_factory=dict)
    template: str = ""
