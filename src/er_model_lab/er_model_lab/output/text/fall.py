"""The fall of the error on held-out data: the model as given, refitted, then step by step."""

from __future__ import annotations

from dataclasses import dataclass

from er_model_lab.output.text.units import newtons
from er_model_lab.output.text.verdict_text import given, rmse, title_of
from er_model_lab.view import View


@dataclass(frozen=True)
class Stage:
    """A model on the way and its error [N]; alone: of a pair, each of the two and the error with it alone."""

    name: str
    error: float
    alone: tuple[tuple[str, float], ...] = ()


def stages(view: View) -> tuple[Stage, ...]:
    """Every model from the one given to the last, all on the same held-out data; empty where there is no fall."""
    steps = view.result.get("steps") or []
    first = given(view)
    if len(steps) + (first is not None) < 2 or not steps:
        return ()
    start = [] if first is None else [Stage("model as given", first)]
    refitted = Stage("refitted" if start else "model, refitted", float(steps[0]["rmse_held_out"]))
    found = (*start, refitted, *(_step(view, s["added"], s["rmse_held_out"]) for s in steps[1:]))
    # an effect that a later one made needless is taken out again at the end
    last = rmse(view.result, "rmse_after")
    pruned = (
        view.command == "improve"
        and last is not None
        and newtons(last) != newtons(found[-1].error)
    )
    return (*found, Stage("needless effects out", last)) if pruned and last is not None else found


def _step(view: View, added: str, error: float) -> Stage:
    """What one step added; the entry of either of a pair holds the error of the model with the other one alone."""
    parts = [part.strip() for part in str(added).split("+")]
    entries = {str(e["effect"]): e for e in view.result.get("candidates") or ()}
    alone = []
    if len(parts) == 2:
        for part, other in (parts, parts[::-1]):
            left = entries.get(other, {}).get("rmse_before")
            alone += [] if left is None else [(title_of(view, part), float(left))]
    return Stage(f"+ {title_of(view, str(added))}", float(error), tuple(alone))
