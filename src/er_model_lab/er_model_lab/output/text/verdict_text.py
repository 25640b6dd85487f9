"""The verdict in plain words; the page and the terminal say the same."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from typing import Any

from er_models.catalogue import CATALOGUE
from er_models.measured import LABEL, is_term

from er_model_lab.output.text.units import moves, newtons, percent
from er_model_lab.view import View

TITLES: dict[str, str] = {
    "adequate": "The model is adequate",
    "missing_effect": "Missing effect found",
    "ambiguous": "Something is missing; these data cannot say which effect",
    "partial": "Part of what is missing was found",
    "unknown_effect": "Something is missing that the catalogue does not know",
    "insufficient_data": "These data cannot decide",
    "identified": "Every parameter was identified",
    "identified_in_part": "These data do not determine every parameter",
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
    "absent": "not needed",
    "outdone": "explained better by another",
    "minor": "helps, but explains too little",
    "not_excited": "not excited",
    "confounded": "cannot be told apart",
}
"""Standing of a candidate in words."""
GOOD = 0.005
"""Error over the range of the measured force [1] up to which a model is called good whatever is missing."""


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
    learnt = (f" ({LABEL})" if is_term(part) else "" for part in parts)
    return " + ".join(map("".join, zip(words, learnt, strict=True)))


def standing(entry: Mapping[str, Any]) -> str:
    """Status of a candidate; of one that is not taken and helps by more than chance, outdone by another, or minor."""
    status, size, chance = (entry.get(key) for key in ("status", "evidence", "threshold"))
    if status != "absent" or entry.get("explained_by"):
        return "outdone" if status == "absent" else str(status or "")
    return "minor" if size is not None and chance is not None and size > chance else "absent"


def standing_words(view: View, entry: Mapping[str, Any]) -> str:
    """Standing of a candidate in words, with the effects that it stands behind or beside."""
    kind = standing(entry)
    if kind == "outdone":
        better = [title_of(view, e).partition(" (")[0] for e in entry["explained_by"]]
        return f"explained better by {joined(better)}"
    return STATUS.get(kind, kind)


def unknowable(view: View) -> list[tuple[str, str]]:
    """Title of every effect that no record of these channels can show, and why."""
    entries = view.result.get("unknowable") or ()
    return [(title_of(view, str(e["effect"])), str(e["because"])) for e in entries]


def verdict_title(view: View) -> str:
    """First line of the banner; a comparison has no verdict, so its share of the error stands there."""
    verdict = view.result.get("verdict")
    if verdict is None:
        share = beyond_noise(view)
        return (
            "Model against measurement"
            if share is None
            else f"{percent(share)} of the squared error is the model's"
        )
    title = TITLES.get(str(verdict), str(verdict).replace("_", " "))
    names = _names(view)
    if (tried := _in_vain(view)) is not None:
        return f"{title_of(view, tried)} does not explain the error"
    if verdict in ("partial", "unknown_effect") and small_rest(view) is not None:
        title = (
            f"Good model, small rest{' that no known effect explains' * (verdict != 'partial')}"
        )
    if verdict in ("missing_effect", "partial") and names:
        return f"{title}: {joined(names)}"
    return title


def small_rest(view: View) -> float | None:
    """Error that is left over the range of the measured force [1], where it is so small that the model is good."""
    before, left = rmse(view.result), rmse(view.result, "rmse_after")
    share = rmse(view.result, "nrmse")
    if share is None or not before:
        return None
    share *= (before if left is None else left) / before
    return share if share <= GOOD else None


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
    said = _of_one(view) or (maker(view) if maker else _compared(view))
    good = small_rest(view) if result.get("verdict") in ("partial", "unknown_effect") else None
    first = "" if good is None else f"The model errs by {percent(good)} of the force's range. "
    return f"{first}{said}{_refit(view)}"


def learnt(view: View) -> list[str]:
    """What each term that was learnt at last does, in a sentence."""
    return [
        f"{LABEL.capitalize()}: with a smooth term ({e['name']}) the error on held-out data "
        f"{moves(e['rmse_held_out']['before'], e['rmse_held_out']['after'])}."
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
        said = moves(rmse(view.result), rmse(view.result, "rmse_after"))
        return (
            f"With it the error on held-out data {said}; noise alone is {_floor(view)}; {others}."
        )
    if view.command == "add" and view.result.get("verdict") == "partial":
        return f"With it {_fall(view)}{_more(view)}; {others}."
    return ""


def rmse(result: Mapping[str, Any], key: str = "rmse") -> float | None:
    """Error on held-out data [N] where the result splits it and there are any, else over all data."""
    value = result.get(key)
    if isinstance(value, Mapping):
        value = value.get("held_out", value.get("train"))
    return None if value is None else float(value)


ALIKE, MUCH = 1.05, 2.0
"""Ratio of errors that are called equal, and over noise that is told even where most is explained."""


def left_after(view: View) -> float | None:
    """Error on held-out data with the effects that were added [N]; None when none was."""
    steps = view.result.get("steps") or []
    known = [s for s in steps if not is_term(s["added"])]
    final = view.command == "improve" and len(known) == len(steps)
    if len(known) > 1 and not final:
        return float(known[-1]["rmse_held_out"])
    return rmse(view.result, "rmse_after") if _names(view) else None


def _names(view: View) -> list[str]:
    return [title_of(view, e) for e in view.result.get("effects", ()) if not is_term(e)]


def beyond_noise(view: View) -> float | None:
    """Share of the squared error [1] that is beyond the noise, both of the data of the headline; None without them."""
    error, floor = rmse(view.result), view.result.get("noise_floor")
    if not error or floor is None or "stages" in view.result:
        return None
    return max(1.0 - (float(floor) / error) ** 2, 0.0)


def given(view: View) -> float | None:
    """Error of the model as it was given on held-out data [N], where the result states it."""
    value = view.result.get("rmse_as_given")
    return (
        None if value is None or not isinstance(view.result.get("rmse"), Mapping) else float(value)
    )


def _fall(view: View) -> str:
    """The error of the model as given and after, in a clause; on training data where held-out ones show no fall."""
    before, after, first = rmse(view.result), left_after(view), given(view)
    if after is None:
        return f"the error on held-out data is {newtons(before)}"
    said = f"the error on held-out data {moves(before if first is None else first, after)}"
    if first is not None:
        said += f" (the refit alone: {newtons(before)})"
    learnt, left = (view.result.get(key) for key in ("rmse", "rmse_after"))
    shown = moves(before, after).startswith("falls")
    if shown or not isinstance(learnt, Mapping) or not isinstance(left, Mapping):
        return said
    return f"{said}; on training data it {moves(learnt.get('train'), left.get('train'))} beside the refit"


def _refit(view: View) -> str:
    """A sentence where refitting what the model holds made held-out data worse; empty where it did not."""
    first, before = given(view), rmse(view.result)
    if first is None or not moves(first, before).startswith("rises"):
        return ""
    return (
        f" The refit fits the training data, but on held-out data its error rises from {newtons(first)} to "
        f"{newtons(before)}."
    )


def _floor(view: View) -> str:
    return newtons(view.result.get("noise_floor"))


def _more(view: View) -> str:
    """That more is missing, in a clause: held-out data show it, or where they are few, those that were learnt from."""
    after, floor = left_after(view), view.result.get("noise_floor")
    left, noise = view.result.get("rmse_after"), view.result.get("noise_floor_train")
    learnt = left.get("train") if isinstance(left, Mapping) else None
    if further := view.result.get("held_out_beyond"):
        return (
            f": {newtons(further['rms_inside'])} within the range of the training data, where noise is {_floor(view)}, "
            f"and {newtons(further['rms_beyond'])} beyond it"
        )
    within = after is not None and floor is not None and after <= ALIKE * floor
    if within and learnt is not None and noise is not None and learnt > ALIKE * noise:
        return (
            f". Held-out error has reached its noise ({_floor(view)}). On the training data {newtons(learnt)} remain, "
            f"noise is {newtons(noise)}: more is missing"
        )
    return f", but noise alone is {_floor(view)}: more is missing"


def _adequate(view: View) -> str:
    unseen = [e for e in view.result.get("candidates") or () if e.get("status") == "not_excited"]
    hidden = f"; {len(unseen)} would not show in these data" if unseen else ""
    if further := view.result.get("held_out_beyond"):
        return (
            f"Where held-out data stay within the training data, the error is {newtons(further['rms_inside'])} and "
            f"noise {_floor(view)}. Beyond them it is {newtons(further['rms_beyond'])}: these data do not show what "
            f"acts there. No known effect helps by more than chance{hidden}."
        )
    return (
        f"The error on held-out data, {newtons(rmse(view.result))}, is noise "
        f"({_floor(view)}). No known effect helps by more than chance{hidden}."
    )


def _missing(view: View) -> str:
    them = "it" if len(_names(view)) == 1 else "them"
    after, floor = left_after(view), view.result.get("noise_floor")
    more = ""
    if (
        view.result.get("final_verdict") == "unknown_effect"
        and after
        and floor
        and after > MUCH * floor
    ):
        more = " That is most of what was missing. What is left is no noise, and no known effect explains it."
    return f"With {them} {_fall(view)}; noise alone is {_floor(view)}.{more}"


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
    after = joined([newtons(value) for value in found], "or")
    start = newtons(rmse(view.result))
    return f"Chance could make their difference: the error on held-out data is {start} and becomes {after}"


def _partial(view: View) -> str:
    them = "it" if len(_names(view)) == 1 else "them"
    return f"With {them} {_fall(view)}{_more(view)}, and no known effect explains it."


def _unknown(view: View) -> str:
    error, floor = rmse(view.result), view.result.get("noise_floor")
    if error is not None and floor is not None and error <= ALIKE * floor:
        return (
            f"The error on held-out data is {newtons(error)}. Motion and duty predict no more of it, yet it is not "
            "noise either, and no known effect explains it."
        )
    return (
        f"The error on held-out data is {newtons(error)}, noise alone is "
        f"{_floor(view)}, and no known effect explains the difference."
    )


def _insufficient(view: View) -> str:
    blocking = (view.result.get("coverage") or {}).get("blocking") or ()
    if differ := (view.result.get("coverage") or {}).get("unlike"):
        return f"The records are unlike: {differ}."
    if blocking:
        return f"What is missing: {'; '.join(blocking)}."
    why = [*(view.result.get("reasons") or ())][-1:]
    return f"{why[0]}." if why else "Too little of the damper's range is in them."


def _identified(view: View) -> str:
    where = "held-out data" if "held_out" in view.result["rmse"] else "the data"
    return (
        f"The error on {where} {moves(rmse(view.result), rmse(view.result, 'rmse_after'))} against the values given; "
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
