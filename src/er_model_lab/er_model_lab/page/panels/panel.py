"""What a panel asks of the view that holds it."""

from __future__ import annotations

from collections.abc import Awaitable, Callable
from typing import Any, Protocol

from er_model_lab.page.plots import Theme
from er_model_lab.session.desk import Desk
from er_model_lab.session.sight import Selection


class Panel(Protocol):
    """One panel."""

    def refresh(self) -> None:
        """Show what has changed."""


class Host(Protocol):
    """The view."""

    desk: Desk
    theme: Theme

    def safely(self, action: Callable[..., Any]) -> Callable[..., Awaitable[None]]:
        """An action whose errors are one line on the page."""

    def select(self, selection: Selection) -> None:
        """Show a selection everywhere."""

    def draw(self) -> None:
        """Redraw plots and numbers."""

    def look(self) -> None:
        """Redraw what has changed."""
