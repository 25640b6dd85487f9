"""The model of a file, or as much of it as the form of the observers can hold."""

from __future__ import annotations

from pathlib import Path

from er_models.files import load_model
from er_models.model import Model
from er_models.nearest import nearest

from er_observers.forms import form_of


def held(path: str | Path, *, leave_out: bool) -> tuple[Model, tuple[str, ...]]:
    """The model, and names of what it was left without; nothing is left out unless `leave_out`.

    Raises `InputError` for a file that is no model, and as `form_of` where nothing of the model fits.
    """
    model = load_model(path)
    return nearest(model, form_of) if leave_out else (model, ())
