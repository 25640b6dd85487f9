"""An `improve` that was interrupted: what its model says, and how the same call goes on from it.

It goes the same way again and finds every fit that was made, so that it ends where it would have ended at once.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import Any

from er_models.model import Model
from er_records.dataset import Dataset
from er_records.load import fingerprint

from er_model_lab.problem.fit_store import Notes, packed, unpacked

BEGUN, STOPPED, FITS = "begun_from", "interrupted", "fits"
"""Keys in the history of a model file."""


@dataclass(frozen=True)
class Begun:
    """What was done before: digest of the model `improve` was asked for, effects added to it, and fits made.

    added: None where nothing was left.
    """

    digest: str
    added: tuple[str, ...] | None = None
    noted: Notes = field(default_factory=dict)


def resume(left: Model | None, model: Model, data: Dataset) -> Begun:
    """What a model holds that was left by an interruption of the same work, or nothing done."""
    digest = model.digest()
    fresh = Begun(digest)
    if left is None:
        return fresh
    entries = [e for e in left.history[len(model.history) :] if e.get(BEGUN) == digest]
    same = entries and entries[-1].get("data") == fingerprint(data.originals)
    if not same or not entries[-1].get(STOPPED):
        return fresh
    try:
        noted = unpacked(str(entries[-1].get(FITS)))
    except ValueError:
        return fresh
    return Begun(digest, tuple(e for h in entries for e in h["added"]), noted)


def begun(model: Model, data: Dataset, start: Begun) -> Model:
    """The model of which nothing was added yet, as what an interruption would leave."""
    entry = {"added": [], "data": fingerprint(data.originals), "from": model.name}
    return marked(replace(model, history=(*model.history, entry)), start.digest)


def marked(model: Model, digest: str) -> Model:
    """The model with what it was begun from in the last entry of its history."""
    return _last(model, {BEGUN: digest})


def finished(model: Model, *, interrupted: bool) -> Model:
    """The model with the mark of an interruption set or taken away."""
    if not model.history or BEGUN not in model.history[-1]:
        return model
    return _last(model, {STOPPED: interrupted})


def with_fits(model: Model, noted: Notes) -> Model:
    """An interrupted model with the fits that a later call need not make again."""
    return _last(model, {FITS: packed(noted)}) if model.history else model


def left_by(model: Model, start: Begun) -> Model:
    """What an interruption leaves: the model so far, and the fits made since."""
    return with_fits(finished(model, interrupted=True), start.noted)


def _last(model: Model, more: Mapping[str, Any]) -> Model:
    """The model with more in the last entry of its history."""
    return replace(model, history=(*model.history[:-1], {**model.history[-1], **more}))
