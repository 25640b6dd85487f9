"""The verdict in plain words; the page and the terminal say the same."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from er_models.catalogue import CATALOGUE
from er_models.measured import LABEL, PREFIX

from er_model_lab.output.text.units import newtons, percent
from er_model_lab.view import View

TITLES: dict[str, str] = {
    "adequate": "The model is adequate",
    "missing_effect": "Missing effect found",
    "ambiguous": "Something is missing; these data cannot say which effect",
    "partial": "Part of what is missing was found",
    "unknown_effect": "Something is missing that the catalogue does not know",
    "insufficient_data": "These data cannot decide",
    "identified": "Every parameter was identified",
    "identified_in_part": "These data do not say every parameter",
    "told_apart": "A program that tells them apart",
    "one_way": "A program that tells them apart if one is true, not if the other is",
    "not_told_apart": "No program within the limits tells them apart",
    "revealed": "A program that shows it",
    "not_revealed": "No program within the limits shows it",
    "usable": "The data can be used",
    "not_usable": "The data cannot be used as they are",
}
"""Title of the banner by verdict."""

PLANNED = ("told_apart", "one_way", "not_told_apart", "revealed", "not_revealed")
"""Verdicts of a plan."""

STATUS: dict[str, str] = {
    "present": "present",
    "absent": "absent",
    "not_excited": "not excited",
    "confounded": "cannot be told apart",
}
"""Status of a candidate in words."""


def joined(names: Sequence[str], last: str = "and") -> str:
    """Names as a sentence lists them."""
    if len(names) < 2:
        return "".join(names)
    return f"{', '.join(names[:-1])} {last} {names[-1]}"


def title_of(view: View, effect: str) -> str:
    """Title of an effect, or of several joined by +; a name unknown here is said in words."""
    titles = {card.effect: card.title for card in view.candidates}
    titles |= {e.name: e.title for e in CATALOGUE.effects if e.name not in titles}
    parts = [part.strip() for part in effect.split("+")]
    words = (titles.get(part, part.replace("_", " ")) for part in parts)
    learnt = (f" ({LABEL})" if _is_term(part) else "" for part in parts)
    return " + ".join(map("".join, zip(words, learnt, strict=True)))


def unknowable(view: View) -> list[tuple[str, str]]:
    """Title of every effect that no record of these channels can show, and why."""
    entries = view.result.get("unknowable") or ()
    return [(title_of(view, str(e["effect"])), str(e["because"])) for e in entries]


def verdict_title(view: View) -> str:
    """First line of the banner; a comparison has no verdict, so its share of the error stands there."""
    verdict = view.result.get("verdict")
    if verdict is None:
        share = view.result.get("explainable")
        return (
            "Model against measurement"
            if share is None
            else f"{percent(share)} of the squared error is the model's"
        )
    title = TITLES.get(str(verdict), str(verdict).replace("_", " "))
    names = _names(view)
    if (tried := _in_vain(view)) is not None:
        return f"{title_of(view, tried)} does not explain the error"
    if verdict in ("missing_effect", "partial") and names:
        return f"{title}: {joined(names)}"
    return title


def verdict_sentence(view: View) -> str:
    """What the verdict means, with its numbers."""
    result = view.result
    makers = {
        "adequate": _adequate, "missing_effect": _missing, "ambiguous": _ambiguous,
        "partial": _partial,
        "unknown_effect": _unknown, "insufficient_data": _insufficient,
        "identified": _identified, "identified_in_part": _identified,
        "usable": _checked, "not_usable": _checked,
        **dict.fromkeys(PLANNED, _planned),
    }  # fmt: skip
    maker = makers.get(str(result.get("verdict")))
    if said := _of_one(view):
        return said
    return maker(view) if maker else _compared(view)


def learnt(view: View) -> list[str]:
    """What each term that was learnt at last does, in a sentence."""
    return [
        f"{LABEL.capitalize()}: a smooth term ({e['name']}) brings it to {newtons(e['rmse_held_out']['after'])}."
        for e in view.result.get("measured_terms") or ()
    ]


def _in_vain(view: View) -> str | None:
    """The effect that was added on request and explains nothing; None otherwise."""
    tried = [str(e["effect"]) for e in view.result.get("candidates") or ()]
    vain = view.command == "add" and len(tried) == 1 and not view.result.get("effects")
    return tried[0] if vain else None


def _of_one(view: View) -> str:
    """What a verdict means where one effect only was tried; empty where it says nothing of the others."""
    others = "./er lab diagnose tries the other effects"
    if _in_vain(view) is not None:
        before, after = newtons(rmse(view.result)), newtons(rmse(view.result, "rmse_after"))
        said = f"The error on held-out data was {before} and is {after} with it"
        return f"{said}; noise alone is {_floor(view)}; {others}."
    if view.command == "add" and view.result.get("verdict") == "partial":
        return f"With it {_fall(view)}{_more(view)}; {others}."
    return ""


def rmse(result: Mapping[str, Any], key: str = "rmse") -> float | None:
    """Error on held-out data [N] where the result splits it and there are any, else over all data."""
    value = result.get(key)
    if isinstance(value, Mapping):
        value = value.get("held_out", value.get("train"))
    return None if value is None else float(value)


ALIKE = 1.05
"""Ratio of errors that are called equal."""


def left_after(view: View) -> float | None:
    """Error on held-out data with the effects that were added [N]; None when none was."""
    steps = [s for s in view.result.get("steps") or [] if not _is_term(s["added"])]
    if len(steps) > 1:
        return float(steps[-1]["rmse_held_out"])
    return rmse(view.result, "rmse_after") if _names(view) else None


def _is_term(name: str | None) -> bool:
    """Whether a name is that of a measured term, which explains nothing."""
    return str(name).startswith(PREFIX)


def _names(view: View) -> list[str]:
    return [title_of(view, e) for e in view.result.get("effects", ()) if not _is_term(e)]


def _fall(view: View) -> str:
    """The error before and after, in a clause."""
    before, after = rmse(view.result), left_after(view)
    if after is None:
        return f"the error on held-out data is {newtons(before)}"
    return f"the error on held-out data falls from {newtons(before)} to {newtons(after)}"


def _floor(view: View) -> str:
    return newtons(view.result.get("noise_floor"))


def _more(view: View) -> str:
    """That more is missing, in a clause: held-out data show it, or where they are few, those that were learnt from."""
    after, floor = left_after(view), view.result.get("noise_floor")
    left, noise = view.result.get("rmse_after"), view.result.get("noise_floor_train")
    learnt = left.get("train") if isinstance(left, Mapping) else None
    if further := view.result.get("held_out_beyond"):
        return (
            f": {newtons(further['rms_inside'])} within what was learnt from, where noise is {_floor(view)}, and "
            f"{newtons(further['rms_beyond'])} beyond it"
        )
    within = after is not None and floor is not None and after <= ALIKE * floor
    if within and learnt is not None and noise is not None and learnt > ALIKE * noise:
        return (
            f". That is noise there ({_floor(view)}), but of the {newtons(learnt)} left in the data that were learnt "
            f"from it is {newtons(noise)}: more is missing"
        )
    return f", but noise alone is {_floor(view)}: more is missing"


def _adequate(view: View) -> str:
    unseen = [e for e in view.result.get("candidates") or () if e.get("status") == "not_excited"]
    hidden = f"; {len(unseen)} would not show in these data" if unseen else ""
    if further := view.result.get("held_out_beyond"):
        return (
            f"Within what was learnt from, the model leaves {newtons(further['rms_inside'])} of the held-out data, "
            f"noise is {_floor(view)}. Beyond it {newtons(further['rms_beyond'])} are left: what acts there, these "
            f"data do not show. No known effect helps by more than chance{hidden}."
        )
    return (
        f"What the model leaves on held-out data, {newtons(rmse(view.result))}, is noise "
        f"({_floor(view)}). No known effect helps by more than chance{hidden}."
    )


def _missing(view: View) -> str:
    them = "it" if len(_names(view)) == 1 else "them"
    return f"With {them} {_fall(view)}; noise alone is {_floor(view)}."


def _ambiguous(view: View) -> str:
    groups = [[title_of(view, e) for e in group] for group in view.result.get("alternatives", ())]
    blocking = (view.result.get("coverage") or {}).get("blocking") or ()
    doubt = f" It may be something else: {'; '.join(blocking)}." if blocking else ""
    if not groups:
        doubt = doubt or " The data are too narrow to be sure."
        return f"{joined(_names(view))} would explain it: {_fall(view)}.{doubt}"
    either = "; ".join(joined(group, "or") for group in groups)
    return f"It is {either}. {_rivals(view)}, noise {_floor(view)}.{doubt}"


def _rivals(view: View) -> str:
    """What each of the first group of tied effects leaves where they are not quite alike, in a clause."""
    left = {
        str(e["effect"]): rmse(e, "rmse_held_out") for e in view.result.get("candidates") or ()
    }
    group = view.result["alternatives"][0] if len(_names(view)) == 1 else ()
    found = [value for e in group if (value := left.get(e)) is not None]
    if not found or max(found) <= ALIKE * min(found):
        return f"Each explains the error as well: {_fall(view)}"
    before, after = newtons(rmse(view.result)), joined([newtons(value) for value in found], "or")
    return f"Chance could make their difference: the error on held-out data falls from {before} to {after}"


def _partial(view: View) -> str:
    them = "it" if len(_names(view)) == 1 else "them"
    return f"With {them} {_fall(view)}{_more(view)}, and no known effect explains it."


def _unknown(view: View) -> str:
    error, floor = rmse(view.result), view.result.get("noise_floor")
    if error is not None and floor is not None and error <= ALIKE * floor:
        return (
            f"The error on held-out data is {newtons(error)}. Neither motion nor duty would predict more of it, but it "
            "is not noise either, and no known effect makes it."
        )
    return (
        f"The error on held-out data is {newtons(error)}, noise alone is "
        f"{_floor(view)}, and no known effect explains the difference."
    )


def _insufficient(view: View) -> str:
    blocking = (view.result.get("coverage") or {}).get("blocking") or ()
    if blocking:
        return f"What is missing: {'; '.join(blocking)}."
    why = [*(view.result.get("reasons") or ())][-1:]
    return f"{why[0]}." if why else "Too little of the damper's range is in them."


def _identified(view: View) -> str:
    where = "held-out data" if "held_out" in view.result["rmse"] else "the data"
    after = newtons(rmse(view.result, "rmse_after"))
    return (
        f"The error on {where} falls from {newtons(rmse(view.result))} with the values given to {after}; "
        f"the white noise of the force is {_floor(view)}."
    )


def _planned(view: View) -> str:
    return str((view.result.get("why") or [""])[0])


def _checked(view: View) -> str:
    found = view.result.get("preflight") or {"findings": (), "cells": (), "missing": {}}
    bad = [f for f in found["findings"] if f["level"] == "fail"]
    if bad:
        f = bad[0]
        what = f"{f['channel'] or f['check']} of {f['record']}: {f['found']}; {f['remedy']}."
        return what.replace("_", " ")
    lacking = sum(not c["covered"] for c in found["cells"])
    if not lacking:
        return "They cover every region that an effect of the catalogue needs."
    return f"{lacking} of {len(found['cells'])} regions are missing; {len(found['missing'])} effects may stay hidden."


def _compared(view: View) -> str:
    return f"The error is {newtons(rmse(view.result))}; noise alone is {_floor(view)}."
