"""An `improve` that was interrupted: what its model file says, and how the same command goes on from it."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from er_models.catalogue import Catalogue
from er_models.errors import ErError
from er_models.files import load_model
from er_models.model import Model

from er_model_lab.load import fingerprint
from er_model_lab.record import Record, originals

BEGUN, STEPS, STOPPED = "begun_from", "steps", "interrupted"
"""Keys in the history of a model file."""


@dataclass(frozen=True)
class Begun:
    """Where `improve` begins: the model, the digest of the one it was asked for, and what was done before.

    passes: diagnoses already made; steps: the errors they led to; effects: what they added.
    """

    model: Model
    digest: str
    passes: int = 0
    steps: tuple[Mapping[str, Any], ...] = ()
    effects: tuple[str, ...] = ()


def resume(out: Path, model: Model, records: Sequence[Record], catalogue: Catalogue) -> Begun:
    """The model itself, or the one in `out` where that was left by an interruption of the same work."""
    digest = model.digest()
    fresh = Begun(model, digest)
    if not out.is_file():
        return fresh
    try:
        left = load_model(out, catalogue)
    except ErError:
        return fresh
    entries = [e for e in left.history[len(model.history) :] if e.get(BEGUN) == digest]
    same = entries and entries[-1].get("data") == fingerprint(originals(records))
    if not same or not entries[-1].get(STOPPED):
        return fresh
    steps = [*entries[0][STEPS], *(s for e in entries[1:] for s in e[STEPS][1:])]
    return Begun(
        left, digest, len(entries), tuple(steps), tuple(e for h in entries for e in h["added"])
    )


def marked(model: Model, digest: str, steps: Sequence[Mapping[str, Any]]) -> Model:
    """The model with what a later call needs to go on, in the last entry of its history."""
    return _last(model, {BEGUN: digest, STEPS: [dict(s) for s in steps]})


def finished(model: Model, *, interrupted: bool) -> Model:
    """The model with the mark of an interruption set or taken away."""
    if not model.history or BEGUN not in model.history[-1]:
        return model
    return _last(model, {STOPPED: interrupted})


def _last(model: Model, more: Mapping[str, Any]) -> Model:
    """The model with more in the last entry of its history."""
    return replace(model, history=(*model.history[:-1], {**model.history[-1], **more}))
