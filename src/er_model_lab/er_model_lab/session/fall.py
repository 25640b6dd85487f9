"""How the error of a session's models falls: as given, and with every effect and measured term that was added."""

from __future__ import annotations

from collections.abc import Callable, Iterator
from dataclasses import dataclass, replace
from typing import Any

from er_models.measured import is_term
from er_models.model import Model

from er_model_lab.results.records import Errors
from er_model_lab.results.result import DiagnosisResult
from er_model_lab.session.steps import Session, State, Step

Judge = Callable[[Model], Errors | None]


@dataclass(frozen=True)
class Stage:
    """A model on the way: what made it of the one before, its errors, and the effects or terms that it added."""

    says: str
    errors: Errors
    added: tuple[str, ...] = ()

    @property
    def measured(self) -> bool:
        """Whether what was added is learnt, and not explained."""
        return any(map(is_term, self.added))


def fallen(result: DiagnosisResult) -> list[list[Any]]:
    """What a step keeps of the way that `improve` went: what was added, errors learnt from and held out [N]."""
    return [[s.added, s.errors.train, s.errors.held_out] for s in result.steps]


def fall(session: Session, judged: Judge) -> list[Stage]:
    """The model as given, after every fit, and what was set since; judged: errors of a model, None where not known."""
    states = [s for s in session.past if s.step.kind == "start" or s.step.fits]
    states += [session.now] if session.now.model is not None and session.now not in states else []
    return [stage for state in states for stage in _stages(state, judged)]


def _stages(state: State, judged: Judge) -> Iterator[Stage]:
    """Those of one state: of an improvement one for each effect, and one where some were needless at last."""
    model = state.model
    errors = None if model is None else judged(model)
    if model is None or errors is None:
        return
    way = [
        _stage(added, Errors(train, held)) for added, train, held in state.step.values.get("fall", ())
    ]  # fmt: skip
    if not way:
        yield Stage(state.step.says, errors, _added(state.step))
        return
    there = {*model.effects, *(t.name for t in model.terms)}
    if all(name in there for stage in way for name in stage.added):
        way[-1] = replace(way[-1], errors=errors)
    else:
        way.append(Stage("needless effects out", errors))
    yield from way


def _stage(added: str | None, errors: Errors) -> Stage:
    names = tuple(added.split(" + ")) if added else ()
    return Stage(f"+ {added}".replace("_", " ") if added else "refitted", errors, names)


def _added(step: Step) -> tuple[str, ...]:
    return (step.what,) if step.kind == "add" else ()
