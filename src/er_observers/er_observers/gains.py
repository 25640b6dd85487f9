"""Gain files: gains, what they promise, and enough to prove it; without a proof nothing is loaded.

Matrices are flat, row by row, with their shape. The file holds no date and no time, so the same
synthesis writes the same file.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from importlib.metadata import version
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np
import yaml
from er_models.errors import InputError
from er_models.files import write_whole
from er_models.forms.relative import STATES as RELATIVE
from er_models.gain_file import Document, digest, read
from er_models.linear import LinearForm, fingerprint
from er_models.model import Array, Model

from er_observers.claim_file import claim_of, sections
from er_observers.forms import SENSORS, form_of
from er_observers.observers.kernel import SUBSTEP
from er_observers.observers.matrices import Plan, bridge_plan, plan_of
from er_observers.observers.payload import numbers_of
from er_observers.observers.sample import Layout, book_of, layout_of
from er_observers.observers.status import LIMITS, Limits
from er_observers.observers.watch import Watch, rules_of, watch_of
from er_observers.opening.phase import Opening, opening_of, spread_of
from er_observers.synthesis.proof import Claim, prove

if TYPE_CHECKING:
    from er_observers.synthesis.certify import Certificate

SCHEMA = "er_gains 1"
_KEYS = (
    *("schema", "observer", "model", "spec", "scaling", "law", "solution", "common"),
    *("certificate", "trade_off", "solver", "digest"),
)


@dataclass(frozen=True, eq=False)
class Gains:
    """Proved gains of one observer for one model, with what the loop takes from them.

    plan: the observer; bridge: the model alone; watch: constants of its health; opening: of its
    start phase, None where it needs none or its states are not the relative ones; payload: whether the
    sprung mass is estimated, where it can be; spread (n,): of a start within the envelope; layout,
    reading, rules, mass: parts of the book that the loop takes, see `sample.book_of`;
    sees_deflection: whether the gains were made for a deflection sensor beside the accelerometers.
    """

    observer: str
    model: str
    claim: Claim
    figures: Mapping[str, Any]
    digest: str
    limits: Limits = LIMITS
    opening: Opening | None = None
    payload: bool = True
    spread: Array | None = None
    plan: Plan = field(init=False)
    bridge: Plan = field(init=False)
    watch: Watch = field(init=False)
    layout: Layout = field(init=False)
    sees_deflection: bool = field(init=False)
    reading: Array = field(init=False)
    rules: Array = field(init=False)
    mass: Array = field(init=False)
    book: Array = field(init=False)

    def __post_init__(self) -> None:
        form, law, scaling = self.form, self.claim.solution.law, self.claim.scaling
        poles = np.array([np.linalg.eigvals(M) for M in law.M])
        object.__setattr__(self, "plan", plan_of(form, law, scaling))
        object.__setattr__(self, "bridge", bridge_plan(form, scaling))
        watch, parts = watch_of(form, poles), (law.R, law.S, form.F, form.Gamma)
        object.__setattr__(self, "watch", watch)
        object.__setattr__(self, "sees_deflection", len(form.C) == len(SENSORS))
        object.__setattr__(self, "layout", layout_of(form.C.shape[0], form.n, law.order))
        object.__setattr__(self, "reading", np.concatenate([np.ravel(p) for p in parts]))
        object.__setattr__(self, "rules", rules_of(watch, self.limits))
        object.__setattr__(self, "mass", numbers_of(form, self.limits.noise, on=self.payload))
        book = book_of(self.plan, self.reading, self.rules, self.mass, self.layout)
        object.__setattr__(self, "book", book)

    @property
    def form(self) -> LinearForm:
        """Linear form of the model the gains belong to."""
        return self.claim.form


def save_gains(
    path: str | Path,
    observer: str,
    model: Model,
    claim: Claim,
    certificate: Certificate,
    trade_off: Mapping[str, Sequence[float | None]] | None = None,
) -> None:
    """Write a gain file, whole or not at all; trade_off: columns to be kept beside them.

    Raises:
        InputError: The file cannot be written.
    """
    names = {"name": model.name, "fingerprint": fingerprint(model)}
    content: dict[str, Any] = {
        "schema": SCHEMA,
        "observer": observer,
        "model": {
            **names,
            "states": list(claim.form.states),
            "outputs": list(SENSORS[: claim.form.C.shape[0]]),
        },
        **sections(claim),
        "certificate": certificate.figures,
        **({"trade_off": dict(trade_off)} if trade_off else {}),
        "solver": {
            "name": "Clarabel",
            "version": version("clarabel"),
            "cvxpy": version("cvxpy"),
            "status": claim.solution.solver_status,
        },
    }
    content["digest"] = digest(content)
    text = yaml.safe_dump(content, sort_keys=False, width=99, default_flow_style=None)
    write_whole(Path(path), text)


def observer_of(path: str | Path) -> str:
    """Which observer a gain file is for; raises `InputError` for what is no gain file of an observer."""
    file = read(path)
    found = file.content.get("schema")
    if found != SCHEMA:
        kind = (
            f"that of '{file.content['controller']}'"
            if "controller" in file.content
            else repr(found)
        )
        raise InputError(path, "schema", f"'{SCHEMA}', a gain file of an observer", kind)
    return str(file.at("observer"))


def load_gains(
    path: str | Path, model: Model, observer: str | None = None, limits: Limits = LIMITS
) -> Gains:
    """Read a gain file for this model and prove its inequalities again, exactly (20 to 400 ms).

    path: of the file, or the name of shipped gains (`unified`).
    observer: whose gains they must be, None: any. limits: when its estimates are called degraded, weak, invalid.

    Raises:
        InputError: In one line: no file, not a gain file, another observer, edited by hand, made for another model,
            or inequalities that do not hold.
    """
    observer = observer or observer_of(path)
    file = read(path)
    again = f"make it again: python -m er_observers.synth {observer} --model MODEL --out {path}"
    _check_identity(file, model, observer, again)
    claim = claim_of(file, _form(file, model))
    _, failed = prove(claim)
    if failed:
        expected = f"inequalities that hold for model '{model.name}' ({again})"
        raise InputError(path, "solution", expected, failed)
    if file.number("certificate.discrete.substep") < SUBSTEP:
        expected = f"a substep of {SUBSTEP} s or longer ({again})"
        found = file.at("certificate.discrete.substep")
        raise InputError(path, "certificate.discrete.substep", expected, found)
    figures, name = file.at("certificate"), str(file.at("digest"))
    opening = _opening(model, claim, limits)
    spread = spread_of(model, claim.form)
    gains = Gains(observer, model.name, claim, figures, name, limits, opening, spread=spread)
    key, rows = "certificate.discrete.duties", len(gains.plan.part("duties"))
    if file.number(key) != rows:
        raise InputError(path, key, f"{rows}, the substeps that run ({again})", file.at(key))
    return gains


def _opening(model: Model, claim: Claim, limits: Limits) -> Opening | None:
    """The start phase; a measured deflection leaves no doubt that would need one."""
    if claim.form.C.shape[0] == len(SENSORS) or claim.form.states != RELATIVE:
        return None
    return opening_of(model, claim.form, model.rig.get("acceleration_noise", limits.noise))


def _form(file: Document, model: Model) -> LinearForm:
    """The form of the file's outputs; its states are the relative ones, which the loop is made for."""
    deflection = len(SENSORS) == len(_names(file, "model.outputs", [*SENSORS]))
    form = form_of(model, deflection=deflection)
    states = file.at("model.states")
    if list(form.states) != states:
        raise InputError(file.path, "model.states", str(list(form.states)), states)
    return form


def _names(file: Document, key: str, known: list[str]) -> list[str]:
    """Outputs: both accelerations, perhaps the deflection."""
    found = file.at(key)
    if found not in (known, known[:-1]):
        raise InputError(file.path, key, f"{known[:-1]} or {known}", found)
    return list(found)


def _check_identity(file: Document, model: Model, observer: str, again: str) -> None:
    """Refuse files of another kind, another observer, another model or another hand."""
    for key in file.content:
        if key not in _KEYS:
            raise InputError(file.path, str(key), f"one of {', '.join(_KEYS)}", "an unknown key")
    for key, expected in (("schema", SCHEMA), ("observer", observer)):
        if file.at(key) != expected:
            raise InputError(file.path, key, f"'{expected}'", repr(file.at(key)))
    if file.at("digest") != digest(file.content):
        expected = f"the file as it was written ({again})"
        raise InputError(file.path, "digest", expected, "an edited file")
    own, found = fingerprint(model), file.at("model.fingerprint")
    if found != own:
        expected = f"{own} of model '{model.name}' ({again})"
        raise InputError(file.path, "model.fingerprint", expected, found)
